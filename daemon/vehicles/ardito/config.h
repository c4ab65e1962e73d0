#pragma once

// The [ardito] table of the configuration. Start-up only.

#include "daemon/config/config.h"
#include "daemon/vehicles/ardito/solver.h"
#include "drivers/ardito/rover_bus.h"
#include "gnc/ardito/parameters.h"

namespace lss::ardito {

inline constexpr double kAcceleration_m_s2 = 1.0;  // towards a commanded speed

struct Parameters {
  RoverBusParameters bus;
  gnc::ardito::Parameters mobility{.geometry = {}, .top_speed_m_s = kSpeedLimits_m_s[0]};
  TimeNs beacon_ns = 5 * kSecond;    // before anything else (Ardito thesis part III)
  TimeNs autonomy_ns = 5 * kSecond;  // the lamp flashes before the vehicle drives by itself
  double wheel_current_A = 4;        // rated: what 1000 per mille are
  double steering_current_A = 2;
  TimeNs io_silent_ns = 300 * kMillisecond;
  TimeNs reset_ns = 10 * kSecond;  // from a commanded reset until the node runs again
  SolverParameters solver;
};

// Errors go to the section; without errors the result is usable.
Parameters read_parameters(config::Section& section);

}  // namespace lss::ardito
