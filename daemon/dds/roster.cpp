// The telemetry topics of the vehicles that were built; LSS_FOR_EACH_VEHICLE is made by the build.

#include "roster.h"

#include "daemon/dds/telemetry_topic.h"

namespace lss {

#define LSS_DECLARE(name)                  \
  namespace name {                         \
  const TelemetryTopic& telemetry_topic(); \
  }
LSS_FOR_EACH_VEHICLE(LSS_DECLARE)
#undef LSS_DECLARE

const TelemetryTopic* find_telemetry_topic(std::string_view vehicle) {
#define LSS_FIND(name) \
  if (vehicle == name::telemetry_topic().vehicle) return &name::telemetry_topic();
  LSS_FOR_EACH_VEHICLE(LSS_FIND)
#undef LSS_FIND
  return nullptr;
}

}  // namespace lss
