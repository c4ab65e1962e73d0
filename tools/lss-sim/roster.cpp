#include "tools/lss-sim/frame/vehicle.h"

namespace lss::sim {

#define LSS_VEHICLE(name, Name) std::unique_ptr<VehicleKind> make_##name##_kind();
#include "roster.inc"
#undef LSS_VEHICLE

std::vector<std::unique_ptr<VehicleKind>> all_vehicles() {
  std::vector<std::unique_ptr<VehicleKind>> all;
#define LSS_VEHICLE(name, Name) all.push_back(make_##name##_kind());
#include "roster.inc"
#undef LSS_VEHICLE
  return all;
}

}  // namespace lss::sim
