#include "daemon/replay/records.h"

namespace lss {

#define LSS_VEHICLE(name, Name) record::VehicleRecords name##_records();
#include "roster.inc"
#undef LSS_VEHICLE

std::optional<record::VehicleRecords> vehicle_records(const std::string& wanted) {
#define LSS_VEHICLE(name, Name) \
  if (wanted == #name) return name##_records();
#include "roster.inc"
#undef LSS_VEHICLE
  return std::nullopt;
}

}  // namespace lss
