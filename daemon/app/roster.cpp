#include "daemon/app/roster.h"

namespace lss {

#define LSS_VEHICLE(name, Name) Port name##_port();
#include "roster.inc"
#undef LSS_VEHICLE

std::vector<std::string> vehicle_names() {
  return {
#define LSS_VEHICLE(name, Name) #name,
#include "roster.inc"
#undef LSS_VEHICLE
  };
}

Port vehicle_port(const std::string& wanted) {
#define LSS_VEHICLE(name, Name) \
  if (wanted == #name) return name##_port();
#include "roster.inc"
#undef LSS_VEHICLE
  return {};
}

}  // namespace lss
