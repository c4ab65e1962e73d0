#pragma once

// The [zebro] table of the configuration. Start-up only.

#include "daemon/config/config.h"
#include "daemon/vehicles/zebro/solver.h"
#include "drivers/zebro/leg_bus.h"
#include "gnc/zebro/locomotion.h"
#include "idl/angles.h"

namespace lss::zebro {

struct Parameters {
  LegBusParameters bus;
  gnc::zebro::LocomotionParameters locomotion;
  TimeNs module_silent_ns = 500 * kMillisecond;
  TimeNs reset_ns = 5 * kSecond;  // from a commanded reset until the module answers again
  double current_limit_A = 1.2;   // below the modules' own 1.7 A (Zebro thesis [P-Int-1])
  double total_limit_A = 6.0;     // of all motors together, below that of the Power sub-system:
  double power_limit_A = 8.0;
  TimeNs current_time_ns = 100 * kMillisecond;
  double temperature_warning_degC = 80;
  double soil_share = 0.16;  // of Sinking::share(): more, and the belly lies in the soil
  double panel_deployed_rad = 110 * kDegree;
  TimeNs panel_move_ns = 10 * kSecond;
  SolverParameters solver;
  // A lease and the safe stop after it that take longer would be broken off. Set by with_link().
  TimeNs obc_timeout_ns = 30 * kSecond;
  TimeNs lease_min_ns = 200 * kMillisecond;
};

// Errors go to the section; without errors the result is usable.
Parameters read_parameters(config::Section& section);
// Adds what is of [link].
Parameters with_link(Parameters parameters, const config::Config& config) noexcept;

}  // namespace lss::zebro
