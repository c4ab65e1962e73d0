#pragma once

// Lunar Zebro as its On-Board Computer sees it: one serial line `legs` with seven modules on it,
// six of them turning the legs of the robot, one the solar panel. The entry for lss-sim's roster,
// and the vehicle itself for tests that step it without threads.

#include <array>
#include <memory>
#include <mutex>

#include "drivers/zebro/ascii_codec.h"
#include "tools/lss-sim/frame/vehicle.h"
#include "tools/lss-sim/zebro/module.h"
#include "tools/lss-sim/zebro/plant.h"

namespace lss::sim {

std::unique_ptr<VehicleKind> make_zebro_kind();

namespace zebro {

inline constexpr int kModules = 7;  // addresses 1..7: legs LF, RF, LM, RM, LH, RH and the panel

struct ZebroOptions {
  TerrainOptions terrain;
  lss::zebro::Check check = lss::zebro::Check::lrc;
  lss::zebro::Stop stop = lss::zebro::Stop::lf;
  PlantKind plant = PlantKind::dart;
  TimeNs step_ns =
      kStepNs;  // of step(); a value other than the simulator's only with the kinematic plant
};

// As of `lss-sim zebro --patch`. Throws std::invalid_argument.
soil::Patch parse_patch(const std::string& text);

// The solar panel: from its mechanical stop at 0 (retracted) to the one at 110 deg.
class Panel {
 public:
  explicit Panel(double step_s) : step_s_(step_s) {}
  const ShaftState& step(const ShaftDrive& drive);
  const ShaftState& shaft() const { return shaft_; }

 private:
  double step_s_;
  ShaftState shaft_;
};

class Zebro final : public Vehicle, public LineDevice {
 public:
  // Throws std::invalid_argument for a step or a terrain that the plant does not support.
  explicit Zebro(const ZebroOptions& options);

  std::vector<SerialLine> lines() override { return {{"legs", this}}; }
  void step() override;
  nlohmann::ordered_json truth() const override;
  void set_fault(const Fault& fault, bool attach) override;
  bool in_force(const Fault& fault) const override;
  std::span<const std::uint8_t> receive(std::uint8_t character, TimeNs now) override;
  // The same for characters that arrive together; returns the reply to their last complete frame.
  std::span<const std::uint8_t> receive(std::span<const std::uint8_t> characters, TimeNs now);

  // Time passes with all motors off, as during sleep of the OBC: nothing moves, the motors cool.
  void rest(double seconds);

  const Plant& robot() const { return *plant_; }
  double panel_rad() const { return panel_.shaft().angle_rad; }
  TimeNs step_ns() const { return options_.step_ns; }
  // Of all motors together, as in the last step.
  double current_A() const;

 private:
  // The effect of a fault on a shaft between gear and leg.
  struct Obstacle {
    bool stuck = false;
    bool limp = false;  // the motor turns nothing
    double drag_Nm = 0;
    double slip = 0;  // the leg turns so much less than the motor, as a share
  };

  ShaftDrive through_obstacle(std::size_t module, const ShaftDrive& drive);
  void feel(std::size_t module, const ShaftState& shaft);

  ZebroOptions options_;
  std::unique_ptr<Plant> plant_;
  Panel panel_;
  mutable std::mutex mutex_;  // of all below: shared by physics, the line and faults
  std::vector<Module> modules_;
  std::array<Obstacle, kModules> obstacles_{};
  std::array<ShaftState, kModules> felt_{};  // load of the motors in the last step
  std::array<ShaftDrive, kModules> wanted_{};
  std::array<EncoderFault, kModules> encoder_{};
  std::array<double, kModules> slipped_rad_{};  // motor before leg
  lss::zebro::Receiver receiver_;
  std::uint64_t dropped_ = 0;
  std::array<std::uint8_t, lss::zebro::kMaxFrameCharacters> reply_{};
};

}  // namespace zebro
}  // namespace lss::sim
