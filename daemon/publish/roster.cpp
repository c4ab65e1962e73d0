// The telemetry topics of the vehicles that were built; LSS_FOR_EACH_VEHICLE is made by the build.

#include "roster.h"

#include <algorithm>
#include <cstddef>
#include <iterator>

#include "daemon/publish/telemetry_topic.h"
#include "lss.h"

namespace lss {
namespace {

// What TelemetryPlane fills and reads without the type.
#define LSS_CHECK(name, Type)                                                 \
  static_assert(offsetof(Type, vehicle_id) == 0 &&                            \
                sizeof(Type::vehicle_id) == sizeof(lss_Status::vehicle_id) && \
                offsetof(Type, time_ns) == sizeof(Type::vehicle_id));
LSS_FOR_EACH_VEHICLE(LSS_CHECK)
#undef LSS_CHECK

#define LSS_TOPIC(name, Type) {#name, &Type##_desc, sizeof(Type)},
const TelemetryTopic kTopics[] = {LSS_FOR_EACH_VEHICLE(LSS_TOPIC)};
#undef LSS_TOPIC

}  // namespace

const TelemetryTopic* find_telemetry_topic(std::string_view vehicle) {
  const auto* found = std::ranges::find(kTopics, vehicle, &TelemetryTopic::vehicle);
  return found == std::end(kTopics) ? nullptr : found;
}

}  // namespace lss
