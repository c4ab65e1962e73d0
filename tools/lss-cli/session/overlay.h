#pragma once

// For a vehicle's overlay: its functions take the struct of its telemetry. The caller includes the
// fields of the IDL. Pure functions.

#include "daemon/record/json.h"
#include "tools/lss-cli/session/vehicle.h"

namespace lss::cli {

template <class Telemetry, auto kScreen, auto kProgress>
constexpr TelemetryView view_of(const dds_topic_descriptor_t& type) {
  return {.idl = idl_of(Telemetry{}),
          .type = &type,
          .json = [](const void* sample) -> nlohmann::ordered_json {
            return record::to_json(*static_cast<const Telemetry*>(sample));
          },
          .screen =
              [](const Vehicle& vehicle, const void* sample, const Style& style) {
                return kScreen(vehicle, *static_cast<const Telemetry*>(sample), style);
              },
          .progress =
              [](const void* sample) { return kProgress(*static_cast<const Telemetry*>(sample)); }};
}

}  // namespace lss::cli
