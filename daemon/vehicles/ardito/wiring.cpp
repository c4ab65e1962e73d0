// D.I.A.N.A. Ardito's wiring: one CAN bus.

#include "daemon/kit/declare.h"
#include "daemon/vehicles/ardito/tunables.h"
#include "daemon/vehicles/ardito/vehicle.h"
#include "daemon/vehicles/ardito/words.h"

namespace lss::ardito {
namespace {

constexpr auto kPeriod = static_cast<TimeNs>(gnc::ardito::kFrame_s * kSecond);

}  // namespace

Buses::Buses(const config::Config& config, const Parameters& parameters)
    : OnePort(kit::port_of(config, "rover"), parameters.bus, kit::port_of(config, "rover").path,
              canopen::filters()),
      period_ns_(config.period_ns) {}

std::string Buses::wrong_configuration() const {
  if (period_ns_ == kPeriod) return "";
  return fmt::format(
      "[frame] period_ms is {}: the mobility controller is made for frames of 100 ms",
      static_cast<double>(period_ns_) * 1e-6);
}

}  // namespace lss::ardito

namespace lss {

record::VehicleRecords ardito_records();

Port ardito_port() {
  return kit::port<ardito::Vehicle, ardito::Buses>(ardito::read_parameters, ardito::tuning(),
                                                   ardito::logic(), ardito::vocabulary(),
                                                   ardito_records);
}

}  // namespace lss
