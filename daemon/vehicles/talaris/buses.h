#pragma once

// The wiring of TALARIS: an IMU, whose packets begin the frames, a second one, an altimeter, four
// at the corners and a camera on serial lines; valves, fans and load cell on a CAN bus; and the
// actuate thread's part, which writes the edges of the valves. Ports of the configuration: "imu",
// "altimeter", "can", and "standby_imu", "camera" and "corner_1" to "corner_4" where there are
// such.

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <tl/expected.hpp>
#include <utility>
#include <vector>

#include "daemon/config/config.h"
#include "daemon/runtime/frames.h"
#include "daemon/runtime/progress.h"
#include "daemon/vehicles/talaris/actuation.h"
#include "daemon/vehicles/talaris/line.h"
#include "drivers/talaris/ar1000.h"
#include "drivers/talaris/crossbow.h"
#include "drivers/talaris/flow_camera.h"
#include "drivers/talaris/landmark30.h"

namespace lss::talaris {

enum class ImuKind : std::uint8_t { landmark30, crossbow };

struct BusesParameters {
  ImuKind imu = ImuKind::landmark30;
  LandMark30Parameters landmark{};
  CrossbowParameters crossbow{};
  Ar1000Parameters altimeter{};  // those at the corners are of its kind
  bool has_corners = false;
  bool has_standby = false;
  CrossbowParameters standby{};
  bool has_camera = false;
  FlowCameraParameters camera{};
  HopperBusParameters can{};
  ValveParameters valves{};
  // After this delay of its last packet the frame begins by the clock.
  TimeNs grace_ns = 15 * kMillisecond;
};

// Adds what the drivers inherit from the ports and the frame.
BusesParameters complete(BusesParameters parameters, const config::Config& config);

// A serial line.
struct LineReport {
  LineStatus status{};
  TimeNs time_ns = 0;  // when its thread wrote this
  bool open = false;
  bool was_open = false;  // ever
};

// Inputs of the frame from the buses besides samples.
struct BusReport {
  LineReport imu{}, altimeter{}, camera{}, standby{};
  std::uint64_t corner_overflows = 0;  // samples of the altimeters at the corners, dropped
  HopperCan::Report can{};
  EdgeReport edges{};
};

class Buses {
 public:
  using Frames = SensorFrames;

  Buses(const config::Config& config, const BusesParameters& parameters);

  std::string wrong_configuration() const;  // "": nothing
  // Start-up: a port of the wrong kind is an error; an absent one is waited for.
  tl::expected<void, std::string> probe();
  std::vector<std::pair<std::string, std::function<void()>>> bodies();
  std::vector<Progress> progress() const;
  void stop() noexcept;

  SensorFrames& frames() noexcept { return frames_; }

  // Frame thread: samples stamped before T_k, each line in the order of time; how many. Those that
  // find no room are left to the next frame.
  std::size_t collect(TimeNs boundary_ns, std::span<TalarisSample> samples,
                      BusReport& report) noexcept;

  // Frame thread: memory of a bus thread, of the valves' timing or of the frames' was damaged in
  // both copies since the last call.
  bool take_memory_lost() noexcept;

  // Actuate thread: orders of this frame, or again those of the frame before.
  void release(const TalarisOrders& orders, const Boundary& boundary) noexcept;
  Actuation& actuation() noexcept { return actuation_; }

  // Any thread, never waits: valves shut and fans off by the actuate thread, now.
  void all_stop() noexcept;

 private:
  SensorLine& imu_line() noexcept;
  struct Extra {
    LineBus* line;
    const char* thread;
    bool present;
  };
  std::string wrong_ports_;
  BusesParameters parameters_;
  TimeNs period_ns_, offset_ns_;
  SensorFrames frames_;
  LandMark30 landmark_;
  Crossbow crossbow_;
  Ar1000 ar1000_;
  FlowCamera flow_camera_;
  Crossbow standby_imu_;
  LineBus imu_, altimeter_, camera_, standby_;
  std::array<Ar1000, kCornerAltimeters> corner_;
  std::array<LineBus, kCornerAltimeters> corners_;
  std::array<Extra, 2 + kCornerAltimeters> extra_;  // lines of sensors beyond those as built
  HopperCan can_;
  Actuation actuation_;
};

}  // namespace lss::talaris
