#pragma once

// The telemetry topic of a vehicle. The roster of the build lists the vehicles. Constant data, any
// thread.

#include <cstddef>
#include <string_view>

struct dds_topic_descriptor;

namespace lss {

struct TelemetryTopic {
  std::string_view vehicle;
  const dds_topic_descriptor* descriptor;  // of lss_NAMETelemetry
  std::size_t size;                        // of one sample, which begins with its key
};

// nullptr for a vehicle that was not built.
const TelemetryTopic* find_telemetry_topic(std::string_view vehicle);

}  // namespace lss
