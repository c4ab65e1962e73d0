#pragma once

// A vehicle's telemetry topic, its only addition to the DDS face, defined in daemon/dds/NAME.cpp as
// `const TelemetryTopic& lss::NAME::telemetry_topic()`. The roster of the build lists the vehicles.
// Constant data, any thread.

#include <cstddef>
#include <string_view>

struct dds_topic_descriptor;

namespace lss {

struct TelemetryTopic {
  std::string_view vehicle;
  const dds_topic_descriptor* descriptor;  // of lss_NAMETelemetry
  std::size_t size;                        // of one sample
  // Converts the vehicle's own struct to a sample of the descriptor's type. `to` may be
  // uninitialised shared memory: every byte of it is written.
  void (*convert)(const void* from, std::string_view vehicle_id, void* to);
};

// nullptr for a vehicle that was not built.
const TelemetryTopic* find_telemetry_topic(std::string_view vehicle);

}  // namespace lss
