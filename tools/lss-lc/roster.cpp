#include <array>

#include "tools/lss-lc/vehicle.h"

namespace lss::lc {

#define LSS_VEHICLE(name, Name) const Verified& name##_verified();
#include "roster.inc"
#undef LSS_VEHICLE

std::span<const Verified* const> verified_vehicles() {
  static const std::array all = {
#define LSS_VEHICLE(name, Name) &name##_verified(),
#include "roster.inc"
#undef LSS_VEHICLE
  };
  return all;
}

const Verified* verified_vehicle(const std::string& name) {
  for (const Verified* vehicle : verified_vehicles()) {
    if (vehicle->name == name) return vehicle;
  }
  return nullptr;
}

}  // namespace lss::lc
