#pragma once

// The telemetry of a vehicle from the text of its IDL: the
// type for DDS, and a sample as JSON. A sample in memory is its CDR bytes without
// their header. Errors are thrown as a Failure.

#include <dds/dds.h>

#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "tools/lss-cli/recording/idl_types.h"

namespace lss::cli {

class TelemetryType {
 public:
  // `name`: lss::ZebroTelemetry. It begins with vehicle_id and time_ns, as every telemetry does.
  TelemetryType(std::string idl, const std::string& name);
  TelemetryType(const TelemetryType&) = delete;  // the descriptor points into it
  TelemetryType& operator=(const TelemetryType&) = delete;

  const dds_topic_descriptor_t* descriptor() const { return descriptor_.get(); }
  std::string_view idl() const { return idl_; }

  // All members but the key.
  nlohmann::ordered_json json(const void* sample) const;
  // nullopt: there is no number of this name.
  std::optional<double> number(std::string_view name, const void* sample) const;

 private:
  std::vector<std::byte> message(const void* sample) const;

  std::string idl_;
  recording::Types types_;
  recording::Layout layout_;
  std::vector<std::uint32_t> ops_;
  dds_key_descriptor_t key_{};
  std::unique_ptr<const dds_topic_descriptor_t> descriptor_;
};

}  // namespace lss::cli
