// The wiring of Lunar Zebro: the port "legs" has a bus of seven leg modules; the frame thread takes
// its replies and the actuate thread releases orders to it.

#include <fmt/format.h>

#include <cmath>

#include "daemon/kit/declare.h"
#include "daemon/vehicles/zebro/tunables.h"
#include "daemon/vehicles/zebro/vehicle.h"
#include "daemon/vehicles/zebro/words.h"

namespace lss::zebro {
namespace {

const config::Port& legs_port(const config::Config& config) { return kit::port_of(config, "legs"); }

// Parameters that the bus inherits from the port and the frame.
LegBusParameters bus_parameters(const config::Config& config, LegBusParameters bus) {
  const config::Port& port = legs_port(config);
  bus.baud = static_cast<int>(port.baud);
  bus.half_duplex = port.half_duplex;
  bus.period_ns = config.period_ns;
  return bus;
}

SerialSettings settings(const config::Config& config) {
  const config::Port& port = legs_port(config);
  return {.path = port.path, .baud = static_cast<int>(port.baud), .half_duplex = port.half_duplex};
}

// What is wrong with [frame], or with [link] and these times, or "".
std::string wrong_times(const config::Config& config, const Parameters& parameters) {
  if (config.period_ns > kLongestPeriod) {
    return fmt::format(
        "[frame] period_ms is {:.4g}: a leg that stands still would not be found; it must be at "
        "most {}",
        static_cast<double>(config.period_ns) * 1e-6, kLongestPeriod / kMillisecond);
  }
  if (check_stop(parameters) == nullptr) return "";
  const double least_s =
      safe_stop_s(parameters) + static_cast<double>(usual_lease_ns(parameters)) * 1e-9;
  return fmt::format(
      "[link] obc_timeout_s is {:.4g}: a silent OBC would break off a safe stop; it must be at "
      "least {:.1f}, or [zebro.gait] and [zebro.motion] shorter",
      static_cast<double>(config.obc_timeout_ns) * 1e-9, std::ceil(least_s * 10) / 10);
}

}  // namespace

Buses::Buses(const config::Config& config, const Parameters& parameters)
    : OnePort(legs_port(config), bus_parameters(config, parameters.bus), settings(config)),
      wrong_times_(wrong_times(config, parameters)) {}

}  // namespace lss::zebro

namespace lss {

record::VehicleRecords zebro_records();

Port zebro_port() {
  return kit::port<zebro::Vehicle, zebro::Buses>(zebro::read_parameters, zebro::tuning(),
                                                 zebro::logic(), zebro::vocabulary(), zebro_records,
                                                 zebro::with_link);
}

}  // namespace lss
