#pragma once

// A vehicle from a dictionary (docs/dds.md): commands, parameters, codes, telemetry and how it is
// driven and shown. With the overlay of its name, when this program has one. A dictionary that
// cannot be read is thrown as a Failure.

#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "daemon/cycle/text.h"
#include "tools/lss-cli/session/telemetry_screen.h"
#include "tools/lss-cli/session/telemetry_type.h"
#include "tools/lss-cli/session/vehicle.h"

namespace lss::cli {

class DescribedVehicle {
 public:
  explicit DescribedVehicle(const std::string& dictionary);
  DescribedVehicle(const DescribedVehicle&) = delete;
  DescribedVehicle& operator=(const DescribedVehicle&) = delete;

  const Vehicle& vehicle() const { return vehicle_; }

 private:
  using Json = nlohmann::json;
  // As in a Presentation.
  struct Step {
    std::uint16_t step = 0;
    std::vector<std::uint8_t> modes;
    std::vector<std::uint16_t> commands;
    std::optional<double> argument, when;
  };
  using Case = Presentation::Case;
  using Alarm = Presentation::Alarm;

  void read(const Json& dictionary);
  void read_command(const Json& json);
  std::vector<CodeInfo> codes(const Json& list);
  const char* keep(const Json& text);

  void read_presentation(const Json& presentation);
  static std::vector<Case> read_cases(const Json& list);
  static const Case* find_case(const std::vector<Case>& cases, const Invocation& command);
  void put_on(const Overlay& overlay);

  std::vector<Invocation> prepare(const lss_Status& status, const Invocation& wanted) const;
  std::vector<Problem> problems(const lss_Status& status, const void* sample) const;
  std::optional<double> distance_m(const void* sample) const;
  nlohmann::ordered_json sample_json(const void* sample) const;
  Json telemetry_json(const void* sample) const;

  std::deque<std::string> texts_;  // addresses stay
  std::deque<std::vector<ParameterInfo>> parameters_;
  std::deque<std::vector<const char*>> choices_;
  std::vector<CommandInfo> commands_;
  std::map<std::uint16_t, std::vector<lc::Allowed>> allowed_;
  std::vector<const char*> subjects_, states_;
  std::vector<TunableInfo> tunables_;
  std::vector<CodeInfo> faults_, reasons_, events_;
  std::unique_ptr<TelemetryType> telemetry_;
  Json fields_, presentation_;
  Shown shown_;
  std::vector<Step> steps_;
  std::vector<Case> ends_, slow_;
  std::vector<Alarm> alarms_;
  std::string distance_;
  nlohmann::ordered_json (*raw_json_)(const void* sample) = nullptr;  // the overlay's
  std::uint8_t begins_ = 0;
  Vehicle vehicle_{};
};

// The vehicle of a recording: from the dictionary in it; without one, or with one that cannot be
// read, that of this build.
class RecordedVehicle {
 public:
  RecordedVehicle(const std::string& dictionary, std::string_view name);

  const Vehicle* vehicle() const { return vehicle_; }  // nullptr: not known
  OwnCodes codes() const { return vehicle_ != nullptr ? vehicle_->codes : OwnCodes{}; }

 private:
  std::unique_ptr<const DescribedVehicle> own_;
  const Vehicle* vehicle_;
};

}  // namespace lss::cli
