#pragma once

// The [talaris] table of the configuration. Start-up only.

#include <array>
#include <cstdint>

#include "daemon/config/config.h"
#include "daemon/vehicles/talaris/buses.h"
#include "daemon/vehicles/talaris/solver.h"
#include "gnc/talaris/navigation_parameters.h"
#include "gnc/talaris/parameters.h"

namespace lss::talaris {

inline constexpr const char* kImuKinds[] = {"landmark30", "crossbow"};

// Axis of the sensor along an axis of the body.
struct SensorAxis {
  std::uint8_t axis = 0;  // 0 x, 1 y, 2 z
  double sign = 1;
};

struct Parameters {
  // Set by with_frame() from [frame] offset_ms: commands are released so long after the boundary.
  TimeNs offset_ns = 5 * kMillisecond;

  BusesParameters buses;
  std::array<SensorAxis, 3> imu_axes{{{0, 1}, {1, 1}, {2, 1}}};
  std::array<SensorAxis, 3> standby_axes{{{0, 1}, {1, 1}, {2, 1}}};
  std::array<SensorAxis, 2> camera_axes{{{0, 1}, {1, 1}}};  // along y and z
  TimeNs imu_silent_ns = 250 * kMillisecond;
  double imu_stuck_s = 0.1;  // the same packet again and again for so long: broken
  int imu_lost_per_s = 20;   // more lost packets than that are a fault
  TimeNs altimeter_silent_ns = kSecond;
  // The same reading so often in a row, in the air: stuck. Fewer than navigation believes again
  // (gate_reopens_after); with 3 mm of noise in steps of 1 mm once in 10^7 readings.
  int altimeter_repeats = 7;
  TimeNs camera_silent_ns = kSecond;
  TimeNs reset_ns = 10 * kSecond;  // from a commanded reset until the node runs again

  double fan_slew_us_s = 5000;      // of a pulse width, upwards
  double pressure_corner_Hz = 0.5;  // Butterworth, 5 Hz
  double notch_Hz = 7;              // load cell, 500 Hz
  double notch_quality = 2;
  double min_voltage_V = 0;  // 0: not checked
  double refuelled = 0.97;   // tank at this share of full at start: counted as full

  gnc::talaris::NavigationParameters navigation;
  gnc::talaris::Parameters flight;
  SolverParameters solver;
};

// Errors go to the section; without errors the result is usable.
Parameters read_parameters(config::Section& section);
// Adds the parameters of flight and valves that come from [frame].
Parameters with_frame(Parameters parameters, const config::Config& config) noexcept;

}  // namespace lss::talaris
