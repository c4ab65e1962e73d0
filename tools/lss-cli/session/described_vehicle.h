#pragma once

// A vehicle that this program was built without, from the dictionary of its daemon (docs/dds.md):
// commands, parameters, codes and telemetry, with the same interface as those on the roster. A
// dictionary that cannot be read is thrown as a Failure.

#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "tools/lss-cli/session/telemetry_type.h"
#include "tools/lss-cli/session/vehicle.h"

namespace lss::cli {

class DescribedVehicle {
 public:
  explicit DescribedVehicle(const std::string& dictionary);
  DescribedVehicle(const DescribedVehicle&) = delete;
  DescribedVehicle& operator=(const DescribedVehicle&) = delete;

  const Vehicle& vehicle() const { return vehicle_; }
  // Of the telemetry, as in the dictionary.
  const nlohmann::json& fields() const { return fields_; }

 private:
  using Json = nlohmann::json;

  void read(const Json& dictionary);
  void read_command(const Json& json);
  std::vector<CodeInfo> codes(const Json& list);
  const char* keep(const Json& text);

  std::vector<Invocation> prepare(const lss_Status& status, const Invocation& wanted) const;
  nlohmann::ordered_json telemetry_json(const void* sample) const;

  std::deque<std::string> texts_;  // addresses stay
  std::deque<std::vector<ParameterInfo>> parameters_;
  std::deque<std::vector<const char*>> choices_;
  std::vector<CommandInfo> commands_;
  std::map<std::uint16_t, std::vector<lc::Allowed>> allowed_;
  std::vector<const char*> subjects_, states_;
  std::vector<TunableInfo> tunables_;
  std::vector<CodeInfo> faults_, reasons_, events_;
  std::unique_ptr<TelemetryType> telemetry_;
  Json fields_;
  Vehicle vehicle_{};
};

}  // namespace lss::cli
