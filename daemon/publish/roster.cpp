// The telemetry topics of the vehicles that were built.

#include <roster_types.h>

#include <algorithm>
#include <cstddef>
#include <iterator>

#include "daemon/publish/telemetry_topic.h"
#include "lss.h"

namespace lss {
namespace {

// What TelemetryPlane fills and reads without the type.
template <class Telemetry>
constexpr bool kFillable = offsetof(Telemetry, vehicle_id) == 0 &&
                           sizeof(Telemetry::vehicle_id) == sizeof(lss_Status::vehicle_id) &&
                           offsetof(Telemetry, time_ns) == sizeof(Telemetry::vehicle_id);
#define LSS_VEHICLE(name, Name)                   \
  static_assert(kFillable<lss_##Name##Telemetry>, \
                "begin it with: @key char vehicle_id[16]; long long time_ns;");
#include "roster.inc"
#undef LSS_VEHICLE

const TelemetryTopic kTopics[] = {
#define LSS_VEHICLE(name, Name) {#name, &lss_##Name##Telemetry_desc, sizeof(lss_##Name##Telemetry)},
#include "roster.inc"
#undef LSS_VEHICLE
};

}  // namespace

const TelemetryTopic* find_telemetry_topic(std::string_view vehicle) {
  const auto* found = std::ranges::find(kTopics, vehicle, &TelemetryTopic::vehicle);
  return found == std::end(kTopics) ? nullptr : found;
}

}  // namespace lss
