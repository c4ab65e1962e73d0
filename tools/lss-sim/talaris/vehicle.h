#pragma once

// TALARIS as its Locomotion Controller sees it: an IMU and an altimeter on serial lines, valves,
// fans and on test stands a load cell as nodes on a CAN bus, and the vehicle behind them. The entry
// for lss-sim's roster, and the vehicle itself for tests that step it without threads:
//
//   Talaris world({.plant = {.stand = Stand::sled, .heading_rad = 0.8}, .seed = 7});
//   sim::CanBus bus({.seed = 7}, world);               // its devices: world
//   sim::Uart imu({.baud = 115'200, .bits = 12}, world.imu());
//   world.step();                                      // a millisecond
//
// Frames as in plant.h.

#include <array>
#include <memory>
#include <optional>
#include <vector>

#include "tools/lss-sim/canopen/node_bus.h"
#include "tools/lss-sim/frame/vehicle.h"
#include "tools/lss-sim/talaris/altimeter.h"
#include "tools/lss-sim/talaris/fans.h"
#include "tools/lss-sim/talaris/gas.h"
#include "tools/lss-sim/talaris/imu.h"
#include "tools/lss-sim/talaris/nodes.h"
#include "tools/lss-sim/talaris/plant.h"

namespace lss::sim {

std::unique_ptr<VehicleKind> make_talaris_kind();

namespace talaris {

enum class Pointing : std::uint8_t { down, sideways };  // along -x, along +z

struct TalarisOptions {
  PlantOptions plant{};
  GasOptions gas{};
  FanOptions fans{};
  ImuOptions imu{};
  AltimeterOptions altimeter{};
  std::optional<Pointing> pointing{};        // unset: sideways on rail and sled, otherwise down
  Vector3 altimeter_at_m = Vector3::Zero();  // as [talaris.altimeter] of the configuration
  std::optional<bool> load_cell{};           // unset: only on the stand for it
  unsigned seed = 1;                         // of noise and biases
};

// The same vehicle with manufacturing and setup tolerances: mass, inertia, centre of mass, thrusts
// and lags drawn from the seed (docs/simulator.md has the ranges), about the given ones.
TalarisOptions dispersed(const TalarisOptions& nominal, unsigned seed);

class Talaris final : public Vehicle, public nodes::NodeBus {
 public:
  explicit Talaris(const TalarisOptions& options);

  std::vector<SerialLine> lines() override;
  std::vector<CanLine> can_buses() override { return {{"hopper", this}}; }
  void step() override;
  nlohmann::ordered_json truth() const override;
  void set_fault(const Fault& fault, bool attach) override;
  bool in_force(const Fault&) const override { return true; }

  // For tests, which have one thread.
  const TalarisOptions& options() const { return options_; }
  Imu& imu() { return *imu_; }
  Altimeter& altimeter() { return altimeter_; }
  const Plant& plant() const { return plant_; }
  const ColdGas& gas() const { return gas_; }
  const Fans& fans() const { return fans_; }
  const ValveNode& valve_node() const { return valve_node_; }
  const FanNode& fan_node() const { return fan_node_; }
  double voltage_V() const;
  std::optional<double> range_m() const;  // the true range of the altimeter

 private:
  Wrench act();
  bool set_imu_fault(const Fault& fault, bool attach);
  bool set_altimeter_fault(const Fault& fault, bool attach);
  bool set_named_node_fault(const Fault& fault, bool attach);
  bool set_actuator_fault(const Fault& fault, bool attach);

  TalarisOptions options_;
  Plant plant_;
  std::unique_ptr<Imu> imu_;
  Altimeter altimeter_;

  // The mutex guards all below: shared by physics, the bus and faults.
  ColdGas gas_;
  Fans fans_;
  ValveNode valve_node_;
  FanNode fan_node_;
  std::optional<LoadCellNode> load_cell_;
  Vector3 push_N_ = Vector3::Zero();
  double power_W_ = 0, drained_J_ = 0;
};

// The faults.
std::span<const FaultKind> fault_kinds();

}  // namespace talaris
}  // namespace lss::sim
