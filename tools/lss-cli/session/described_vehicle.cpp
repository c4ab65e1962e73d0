#include "tools/lss-cli/session/described_vehicle.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "tools/lss-cli/session/telemetry.h"
#include "tools/lss-cli/session/wire.h"
#include "tools/lss-cli/show/failure.h"

namespace lss::cli {
namespace {

using Json = nlohmann::json;

constexpr std::size_t kMostBytes = 4'000'000;

[[noreturn]] void refuse(const std::string& what) {
  throw Failure(ExitCode::failed, "the dictionary of the daemon cannot be read: " + what,
                "take the lss-cli of the version of its lssd");
}

// Of a verb or an option.
void check_name(std::string_view name) {
  const auto fits = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '-' || c == '_';
  };
  if (name.empty() || name.front() == '-' || !std::ranges::all_of(name, fits))
    refuse(fmt::format("'{}' is no name", name));
}

bool equal(const std::vector<const char*>& names, const char* const (&others)[2]) {
  return std::ranges::equal(
      names, others, {}, [](const char* a) { return std::string_view(a); },
      [](const char* b) { return std::string_view(b); });
}

double number_or_nan(const Json& json) { return json.is_null() ? kRequired : json.get<double>(); }

// "Idle; Operational Standing"
bool names_idle(const lc::Allowed& place) {
  return place.where == "every state" || place.where == "Idle" || place.where.starts_with("Idle;");
}

bool is_common(std::uint16_t kind) {
  return std::ranges::find(kCommonCommands, kind, &CommandInfo::kind) != std::end(kCommonCommands);
}

}  // namespace

DescribedVehicle::DescribedVehicle(const std::string& dictionary) {
  if (dictionary.size() > kMostBytes) refuse(fmt::format("it has {} bytes", dictionary.size()));
  try {
    read(Json::parse(dictionary));
  } catch (const Json::exception& e) {
    refuse(e.what());
  }
}

const char* DescribedVehicle::keep(const Json& text) {
  return texts_.emplace_back(text.get<std::string>()).c_str();
}

void DescribedVehicle::read_command(const Json& json) {
  CommandInfo info{};
  info.kind = json.at("kind").get<std::uint16_t>();
  std::vector<lc::Allowed>& places = allowed_[info.kind];
  for (const Json& place : json.at("allowed"))
    places.push_back({place.at("where").get<std::string>(), place.at("when")});
  if (is_common(info.kind)) return;
  info.name = keep(json.at("name"));
  check_name(info.name);
  info.access = json.at("access") == "anyone" ? Access::anyone : Access::holder;
  info.leased = json.at("leased").get<bool>();
  info.summary = keep(json.at("summary"));
  info.ends_motion = json.at("ends_motion").get<bool>();
  info.endless = json.value("endless", false);
  std::vector<ParameterInfo>& parameters = parameters_.emplace_back();
  for (const Json& p : json.at("parameters")) {
    const char* name = keep(p.at("name"));
    check_name(name);
    ParameterInfo& one = parameters.emplace_back(ParameterInfo{
        name, keep(p.at("unit")), p.at("min").get<double>(), p.at("max").get<double>(),
        number_or_nan(p.at("default")), nullptr, keep(p.at("help")), p.at("whole").get<bool>()});
    constexpr double kMostOfSet = 9007199254740992;  // a double counts no further
    if (std::string_view(one.unit) == "set" && !(one.max >= 0 && one.max < kMostOfSet))
      refuse(fmt::format("{} {} is a set up to {}", info.name, name, one.max));
    if (!p.contains("choices")) continue;
    std::vector<const char*>& choices = choices_.emplace_back();
    for (const Json& choice : p.at("choices")) choices.push_back(keep(choice));
    if (static_cast<double>(choices.size()) != one.max - one.min + 1)
      refuse(fmt::format("{} {} has {} choices", info.name, name, choices.size()));
    // These two are known by their place.
    one.choices = equal(choices, kNoYes)   ? kNoYes
                  : equal(choices, kOffOn) ? kOffOn
                                           : choices.data();
  }
  if (parameters.size() > kMaxParameters)
    refuse(fmt::format("{} has {} parameters", info.name, parameters.size()));
  info.parameters = parameters;
  commands_.push_back(info);
}

std::vector<CodeInfo> DescribedVehicle::codes(const Json& list) {
  constexpr std::array<std::string_view, 4> kSeverities = {"info", "warning", "error", "fatal"};
  std::vector<CodeInfo> all;
  for (const Json& code : list) {
    const auto* severity =
        std::ranges::find(kSeverities, code.at("severity").get<std::string_view>());
    all.push_back({code.at("number").get<std::uint16_t>(), keep(code.at("name")),
                   static_cast<std::uint8_t>(severity - kSeverities.begin()), keep(code.at("text")),
                   keep(code.at("advice"))});
  }
  return all;
}

void DescribedVehicle::read(const Json& json) {
  for (const Json& command : json.at("commands")) read_command(command);
  for (const Json& subject : json.at("subjects")) subjects_.push_back(keep(subject));
  for (const Json& state : json.at("states")) states_.push_back(keep(state));
  for (const Json& p : json.at("parameters")) {
    tunables_.push_back({keep(p.at("name")), keep(p.at("unit")), p.at("min").get<double>(),
                         p.at("max").get<double>(),
                         p.at("change") == "always" ? Change::always : Change::at_rest,
                         p.at("whole").get<bool>(), keep(p.at("help"))});
  }
  faults_ = codes(json.at("faults"));
  reasons_ = codes(json.at("reasons"));
  events_ = codes(json.at("events"));
  const Json& telemetry = json.at("telemetry");
  fields_ = telemetry.value("fields", Json::array());
  if (telemetry.contains("idl"))
    telemetry_ = std::make_unique<TelemetryType>(telemetry.at("idl").get<std::string>(),
                                                 telemetry.at("type").get<std::string>());

  vehicle_.name = keep(json.at("vehicle"));
  vehicle_.commands = commands_;
  vehicle_.subjects = subjects_;
  vehicle_.codes = {.faults = faults_, .reasons = reasons_, .events = events_};
  vehicle_.rest = static_cast<std::uint16_t>(CommandKind::stop);
  vehicle_.tunables = [this] { return std::span<const TunableInfo>(tunables_); };
  vehicle_.allowed = [this](const CommandInfo& info) {
    const auto places = allowed_.find(info.kind);
    return places == allowed_.end() ? std::vector<lc::Allowed>() : places->second;
  };
  vehicle_.prepare = [this](const lss_Status& status, const Invocation& wanted) {
    return prepare(status, wanted);
  };
  vehicle_.at_rest = "nothing moves";
  vehicle_.json = [this](const void* sample) { return telemetry_json(sample); };
  vehicle_.screen = [this](const void* sample, const Style& style) {
    return telemetry_screen(telemetry_json(sample), style);
  };
  vehicle_.distance_m = [this](const void* sample) {
    return telemetry_->number("distance_m", sample);
  };
  if (telemetry_ == nullptr) return;
  vehicle_.telemetry = telemetry_->descriptor();
  vehicle_.idl = telemetry_->idl();
}

// In Idle, motion begins with a start.
std::vector<Invocation> DescribedVehicle::prepare(const lss_Status& status,
                                                  const Invocation& wanted) const {
  constexpr auto kStart = static_cast<std::uint16_t>(CommandKind::start);
  const CommandInfo& info = *wanted.info;
  const bool ready = std::ranges::any_of(vehicle_.allowed(info), names_idle);
  if (status.state != lss_STATE_IDLE || !info.leased || info.kind == kStart || ready) return {};
  const Invocation start = with_defaults(find_command(vehicle_, kStart));
  const bool complete =
      std::ranges::none_of(start.parameter, [](double x) { return std::isnan(x); });
  return complete ? std::vector<Invocation>{start} : std::vector<Invocation>();  // it says why not
}

nlohmann::ordered_json DescribedVehicle::telemetry_json(const void* sample) const {
  nlohmann::ordered_json json = telemetry_->json(sample);
  if (const auto state = json.find("state"); state != json.end() && state->is_number_unsigned()) {
    const auto number = state->get<std::size_t>();
    if (number < states_.size()) *state = states_[number];
  }
  return with_null_for_never(std::move(json));
}

}  // namespace lss::cli
