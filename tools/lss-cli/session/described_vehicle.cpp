#include "tools/lss-cli/session/described_vehicle.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstdlib>

#include "tools/lss-cli/session/vehicle_words.h"
#include "tools/lss-cli/session/wire.h"
#include "tools/lss-cli/show/failure.h"
#include "tools/lss-cli/show/units.h"

namespace lss::cli {
namespace {

// The type of a vehicle's telemetry is named after it (daemon/publish/dictionary.cpp).
bool is_of(const dds_topic_descriptor_t& type, std::string_view vehicle) {
  const auto lower = [](unsigned char c) { return std::tolower(c); };
  return std::ranges::equal(std::string_view(type.m_typename),
                            fmt::format("lss::{}Telemetry", vehicle), {}, lower, lower);
}

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

// "RM does not answer, last reply 3 s ago", with members of the element in braces.
std::string unheard(const std::string& name, const Json& element, std::string how) {
  const Json& age_ms = element.at("age_ms");
  if (!age_ms.is_number()) return name + " has never answered";
  for (std::size_t open = how.find('{'); open != std::string::npos; open = how.find('{')) {
    const std::size_t end = how.find('}', open);
    if (end == std::string::npos) break;
    const auto member = element.find(how.substr(open + 1, end - open - 1));
    how.replace(open, end - open + 1,
                member != element.end() && member->is_string() ? member->get<std::string>() : "?");
  }
  return fmt::format("{} {} {} ago", name, how, format_duration(age_ms.get<double>() / 1000));
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
  if (json.contains("examples"))
    vehicle_.examples[info.kind] = json.at("examples").get<std::string>();
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
  vehicle_.tunables = tunables_;
  shown_.subjects = subjects_;
  presentation_ = json.value("presentation", Json::object());
  read_presentation(presentation_);
  vehicle_.fields = &fields_;
  vehicle_.presentation = &presentation_;
  vehicle_.allowed = [this](const CommandInfo& info) {
    const auto places = allowed_.find(info.kind);
    return places == allowed_.end() ? std::vector<lc::Allowed>() : places->second;
  };
  vehicle_.prepare = [this](const lss_Status& status, const Invocation& wanted) {
    return prepare(status, wanted);
  };
  vehicle_.ends = [this](const Invocation& command) {
    return find_case(ends_, command) != nullptr;
  };
  vehicle_.takes_s = [this](const Invocation& command) {
    const Case* found = find_case(slow_, command);
    return found != nullptr ? found->takes_s : 0;
  };
  if (telemetry_ == nullptr) return;
  vehicle_.telemetry = telemetry_->descriptor();
  vehicle_.idl = telemetry_->idl();
  vehicle_.problems = [this](const lss_Status& status, const void* sample) {
    return problems(status, sample);
  };
  vehicle_.json = [this](const void* sample) { return telemetry_json(sample); };
  vehicle_.screen = [this](const void* sample, const Style& style) {
    return telemetry_screen(with_words(sample_json(sample), shown_), shown_, style);
  };
  vehicle_.details = [this](const void* sample, const Style& style) {
    return telemetry_details(with_words(sample_json(sample), shown_), shown_, style);
  };
  vehicle_.distance_m = [this](const void* sample) { return distance_m(sample); };
  for (const Overlay* overlay : overlays()) {
    if (is_of(*overlay->telemetry.type, vehicle_.name)) put_on(*overlay);
  }
}

void DescribedVehicle::read_presentation(const Json& json) {
  vehicle_.rest = json.value("rest", static_cast<std::uint16_t>(CommandKind::stop));
  vehicle_.at_rest = keep(json.value("at_rest", "nothing moves"));
  distance_ = json.value("distance", "distance_m");
  begins_ = json.value("begins", std::uint8_t{0});
  if (json.contains("rest")) find_command(vehicle_, vehicle_.rest);  // throws when there is none
  const auto number = [](const Json& x) {
    return x.is_null() ? std::nullopt : std::optional(x.get<double>());
  };
  for (const Json& step : json.value("steps", Json::array())) {
    steps_.push_back({step.at("step").get<std::uint16_t>(),
                      step.at("modes").get<std::vector<std::uint8_t>>(),
                      step.at("commands").get<std::vector<std::uint16_t>>(),
                      number(step.at("argument")), number(step.at("when"))});
    find_command(vehicle_, steps_.back().step);
  }
  ends_ = read_cases(json.value("ends", Json::array()));
  slow_ = read_cases(json.value("slow", Json::array()));
  for (const Json& alarm : json.value("alarms", Json::array())) {
    alarms_.push_back({keep(alarm.at("field")), alarm.at("good").get<bool>(),
                       keep(alarm.at("text")), keep(alarm.at("advice")),
                       alarm.at("subject").get<std::uint16_t>(), alarm.at("alone").get<bool>()});
  }
  for (const Json& w : json.value("words", Json::array()))
    shown_.words[w.at("field").get<std::string>()] = {w.at("words").get<std::vector<std::string>>(),
                                                      w.at("shown_only").get<bool>()};
  for (const Json& p : json.value("parts", Json::array())) {
    Shown::Parts& parts = shown_.parts[p.at("field").get<std::string>()];
    parts = {p.at("first").get<unsigned>(), std::nullopt, p.at("lesser").get<std::uint32_t>(),
             p.at("optional").get<std::uint32_t>()};
    if (p.contains("unheard")) parts.unheard = p.at("unheard").get<std::string>();
  }
  for (const Json& field : json.value("details", Json::array()))
    shown_.details.insert(field.get<std::string>());
}

void DescribedVehicle::put_on(const Overlay& overlay) {
  vehicle_.overlay = &overlay;
  const TelemetryView& view = overlay.telemetry;
  if (view.idl != telemetry_->idl()) return;  // the daemon's telemetry is of another type
  vehicle_.telemetry = view.type;
  raw_json_ = view.json;
  vehicle_.screen = [this, &view](const void* sample, const Style& style) {
    return view.screen(vehicle_, sample, style);
  };
  vehicle_.progress = view.progress;
}

std::vector<DescribedVehicle::Case> DescribedVehicle::read_cases(const Json& list) {
  std::vector<Case> cases;
  for (const Json& one : list) {
    const auto command = one.at("command").get<std::uint16_t>();
    const auto index = one.at("index").get<std::size_t>();
    if (index >= kMaxParameters) refuse(fmt::format("parameter {} of command {}", index, command));
    cases.push_back({command, static_cast<unsigned>(index), one.at("value").get<double>(),
                     one.at("takes_s").get<double>()});
  }
  return cases;
}

const DescribedVehicle::Case* DescribedVehicle::find_case(const std::vector<Case>& cases,
                                                          const Invocation& command) {
  const auto found = std::ranges::find_if(cases, [&](const Case& one) {
    return one.command == command.info->kind && command.parameter[one.index] == one.value;
  });
  return found != cases.end() ? &*found : nullptr;
}

// In Idle, motion begins with a start.
std::vector<Invocation> DescribedVehicle::prepare(const lss_Status& status,
                                                  const Invocation& wanted) const {
  constexpr auto kStart = static_cast<std::uint16_t>(CommandKind::start);
  const CommandInfo& info = *wanted.info;
  const bool idle = status.state == lss_STATE_IDLE;
  if (!info.leased || info.kind == kStart || !(idle || status.state == lss_STATE_OPERATIONAL))
    return {};  // the daemon says why not
  std::vector<Invocation> steps;
  if (idle && std::ranges::none_of(vehicle_.allowed(info), names_idle)) {
    Invocation start = with_defaults(find_command(vehicle_, kStart));
    if (vehicle_.overlay != nullptr && vehicle_.overlay->start != nullptr)
      vehicle_.overlay->start(start, wanted);
    if (std::ranges::any_of(start.parameter, [](double x) { return std::isnan(x); })) return {};
    steps.push_back(start);
  }
  const std::uint8_t mode = idle ? begins_ : status.mode;
  const auto has = [](const auto& list, auto number) {
    return std::ranges::find(list, number) != list.end();
  };
  for (const Step& step : steps_) {
    if (!has(step.modes, mode) || !has(step.commands, info.kind) ||
        (step.when && wanted.parameter[0] != *step.when))
      continue;
    Invocation& first = steps.emplace_back(with_defaults(find_command(vehicle_, step.step)));
    if (step.argument) first.parameter[0] = *step.argument;
  }
  return steps;
}

std::vector<Problem> DescribedVehicle::problems(const lss_Status& status,
                                                const void* sample) const {
  const Json telemetry = telemetry_json(sample);
  std::vector<Problem> list;
  for (const Alarm& alarm : alarms_) {
    const auto field = telemetry.find(alarm.field);
    if (field == telemetry.end() || *field == alarm.good) continue;
    const bool known = alarm.good && (latched(status, FaultId::port_lost, alarm.subject) ||
                                      latched(status, FaultId::port_absent, alarm.subject));
    if (!known) list.push_back({true, alarm.text, alarm.advice});
    if (alarm.alone) return list;
  }
  for (const auto& [name, parts] : shown_.parts) {
    const auto elements = telemetry.find(name);
    if (!parts.unheard || elements == telemetry.end() || !elements->is_array()) continue;
    for (const Json& element : *elements) {
      const auto online = element.find("online");
      if (online == element.end() || *online != false || !element.contains("age_ms")) continue;
      const std::uint16_t subject = shown_.subject_of(name, element);
      if (Shown::is_in(parts.optional, subject) ||
          latched(status, FaultId::module_silent, subject) ||
          latched(status, FaultId::node_wrong, subject))
        continue;
      list.push_back({!Shown::is_in(parts.lesser, subject),
                      unheard(subject_name(vehicle_, subject), element, *parts.unheard),
                      "check its power and the bus"});
    }
  }
  return list;
}

std::optional<double> DescribedVehicle::distance_m(const void* sample) const {
  const Json telemetry = telemetry_json(sample);
  const std::size_t index = distance_.find('[');
  const auto field = telemetry.find(distance_.substr(0, index));
  if (field == telemetry.end()) return std::nullopt;
  const Json* value = &*field;
  if (index != std::string::npos) {
    const std::size_t i = std::strtoul(distance_.c_str() + index + 1, nullptr, 10);
    if (!field->is_array() || i >= field->size()) return std::nullopt;
    value = &(*field)[i];
  }
  if (!value->is_number() || !std::isfinite(value->get<double>())) return std::nullopt;
  return value->get<double>();
}

nlohmann::ordered_json DescribedVehicle::sample_json(const void* sample) const {
  if (raw_json_ != nullptr) return raw_json_(sample);
  nlohmann::ordered_json json = telemetry_->json(sample);
  if (const auto state = json.find("state"); state != json.end() && state->is_number_unsigned()) {
    const auto number = state->get<std::size_t>();
    if (number < states_.size()) *state = states_[number];
  }
  return json;
}

nlohmann::json DescribedVehicle::telemetry_json(const void* sample) const {
  return with_words(sample_json(sample), shown_);
}

RecordedVehicle::RecordedVehicle(const std::string& dictionary, std::string_view name)
    : vehicle_(find_vehicle(name)) {
  try {
    if (dictionary.empty()) return;
    own_ = std::make_unique<const DescribedVehicle>(dictionary);
    vehicle_ = &own_->vehicle();
  } catch (const Failure&) {  // of another version: its records are described by their schema
  }
}

}  // namespace lss::cli
