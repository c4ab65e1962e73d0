#include "daemon/publish/dictionary.h"

#include <algorithm>
#include <cctype>
#include <nlohmann/json.hpp>

#include "daemon/cycle/allowed.h"
#include "idl/codes.h"
#include "idl/commands.h"
#include "idl/units.h"

namespace lss {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kSeverities[] = {"info", "warning", "error", "fatal"};

// Fields by the text of record::Schema: NAME:TYPE; with TYPE a number ("f8"), "{FIELDS}", or
// "[COUNT]TYPE".
class Fields {
 public:
  explicit Fields(std::string_view text) : text_(text) {}

  Json until(char end) {
    Json all = Json::array();
    while (!text_.empty() && text_.front() != end) {
      const std::string_view name = take_to(':');
      Json field = {{"name", name}};
      type(field);
      if (const Unit unit = unit_in(name); !unit.text.empty()) {
        field["unit"] = unit.text;
        if (unit.factor != 1) field["shown"] = {{"unit", unit.shown}, {"factor", unit.factor}};
        field["label"] = without_unit(name);
      }
      take_to(';');
      all.push_back(std::move(field));
    }
    return all;
  }

 private:
  std::string_view take_to(char end) {
    const std::string_view part = text_.substr(0, text_.find(end));
    text_.remove_prefix(std::min(text_.size(), part.size() + 1));
    return part;
  }
  void type(Json& field) {
    if (text_.front() == '[') {
      text_.remove_prefix(1);
      field["count"] = std::stoul(std::string(take_to(']')));
    }
    if (text_.front() == '{') {
      text_.remove_prefix(1);
      field["fields"] = until('}');
      text_.remove_prefix(1);
      return;
    }
    field["type"] = text_.substr(0, text_.find(';'));
  }

  std::string_view text_;
};

Json parameter(const ParameterInfo& p) {
  Json json = {{"name", p.name},       {"unit", p.unit},        {"min", p.min},
               {"max", p.max},         {"default", p.fallback},  // NaN, null in JSON: required
               {"whole", p.is_whole()}};
  if (p.choices != nullptr) {
    json["choices"] = Json::array();
    for (double value = p.min; value <= p.max; ++value)
      json["choices"].push_back(p.choices[static_cast<std::size_t>(value - p.min)]);
  }
  json["help"] = p.help;
  return json;
}

Json list(const auto& from) {
  Json all = Json::array();
  for (const auto& one : from) all.push_back(one);
  return all;
}

Json cases(std::span<const Presentation::Case> from) {
  Json all = Json::array();
  for (const Presentation::Case& c : from)
    all.push_back(
        {{"command", c.command}, {"index", c.index}, {"value", c.value}, {"takes_s", c.takes_s}});
  return all;
}

Json presentation(const Presentation& p) {
  Json json = {{"begins", p.begins},
               {"steps", Json::array()},
               {"ends", cases(p.ends)},
               {"slow", cases(p.slow)},
               {"rest", p.rest},
               {"at_rest", p.at_rest},
               {"distance", p.distance},
               {"words", Json::array()},
               {"parts", Json::array()},
               {"alarms", Json::array()},
               {"details", list(p.details)},
               {"headline", Json::array()},
               {"first", list(p.first)},
               {"hold", Json::array()},
               {"without_client", p.without_client}};
  if (p.supply != nullptr) json["supply"] = p.supply;
  for (const Presentation::Hold& h : p.hold)
    json["hold"].push_back(
        {{"way", h.way}, {"command", h.command}, {"parameters", list(h.parameters)}});
  for (const Presentation::Headline& h : p.headline) {
    json["headline"].push_back({{"field", h.field}, {"label", h.label}});
    if (h.limit != nullptr) json["headline"].back()["limit"] = h.limit;
    if (h.parts != nullptr) json["headline"].back()["parts"] = h.parts;
  }
  for (const Presentation::Step& s : p.steps)
    json["steps"].push_back({{"step", s.step},
                             {"modes", list(s.modes)},
                             {"commands", list(s.commands)},
                             {"argument", s.argument},
                             {"when", s.when}});
  for (const Presentation::Words& w : p.words)
    json["words"].push_back(
        {{"field", w.field}, {"words", list(w.words)}, {"shown_only", w.shown_only}});
  for (const Presentation::Parts& parts : p.parts) {
    json["parts"].push_back({{"field", parts.field},
                             {"first", parts.first},
                             {"lesser", parts.lesser},
                             {"optional", parts.optional}});
    if (parts.unheard != nullptr) json["parts"].back()["unheard"] = parts.unheard;
  }
  for (const Presentation::Alarm& a : p.alarms)
    json["alarms"].push_back({{"field", a.field},
                              {"good", a.good},
                              {"text", a.text},
                              {"advice", a.advice},
                              {"subject", a.subject},
                              {"alone", a.alone}});
  return json;
}

// Of commands of every vehicle.
constexpr Presentation::Example kExamples[] = {
    {static_cast<std::uint16_t>(CommandKind::solve),
     "  lss-cli solve                    leaves FatalError when the cause is gone\n"},
    {static_cast<std::uint16_t>(CommandKind::reset),
     "  lss-cli reset all\n"
     "  lss-cli reset controller\n"}};

Json command(const CommandInfo& info, const Logic& logic, const Vocabulary& vocabulary) {
  Json json = {{"kind", info.kind},
               {"name", info.name},
               {"summary", info.summary},
               {"access", info.access == Access::anyone ? "anyone" : "holder"},
               {"leased", info.leased},
               {"ends_motion", info.ends_motion},
               {"endless", info.endless},
               {"named", info.named},
               {"parameters", Json::array()},
               {"allowed", Json::array()}};
  for (const ParameterInfo& p : info.parameters) json["parameters"].push_back(parameter(p));
  std::string examples;
  for (const std::span<const Presentation::Example> list :
       {vocabulary.presentation.examples, std::span<const Presentation::Example>(kExamples)}) {
    for (const Presentation::Example& e : list)
      if (e.command == info.kind) examples += e.lines;
  }
  if (!examples.empty()) json["examples"] = examples;
  for (const lc::Allowed& a : lc::allowed(info, *logic.table, vocabulary.modes, logic.event_of))
    json["allowed"].push_back({{"where", a.where}, {"when", a.when}});
  return json;
}

Json codes(std::span<const CodeInfo> common, std::span<const CodeInfo> own) {
  Json all = Json::array();
  for (const std::span<const CodeInfo> list : {common, own}) {
    for (const CodeInfo& code : list) {
      all.push_back({{"number", code.number},
                     {"name", code.name},
                     {"severity", kSeverities[code.severity]},
                     {"text", code.text},
                     {"advice", code.advice}});
    }
  }
  return all;
}

// The struct of a vehicle's telemetry is named after it: lss::ZebroTelemetry.
std::string type_name(std::string vehicle) {
  vehicle.front() = static_cast<char>(std::toupper(static_cast<unsigned char>(vehicle.front())));
  return "lss::" + vehicle + "Telemetry";
}

}  // namespace

std::string dictionary(const std::string& vehicle, const Logic& logic, const Vocabulary& vocabulary,
                       std::string_view telemetry_schema, std::string_view idl) {
  Json json = {{"schema_version", 6},
               {"vehicle", vehicle},
               {"states", kStateNames},
               {"modes", vocabulary.modes},
               {"subjects", vocabulary.modules},
               {"strategies", vocabulary.strategies},
               {"commands", Json::array()},
               {"parameters", Json::array()}};
  for (const std::span<const CommandInfo> list :
       {std::span<const CommandInfo>(kCommonCommands), logic.commands}) {
    for (const CommandInfo& info : list)
      json["commands"].push_back(command(info, logic, vocabulary));
  }
  for (const TunableInfo& t : logic.tunables) {
    json["parameters"].push_back({{"name", t.name},
                                  {"unit", t.unit},
                                  {"min", t.min},
                                  {"max", t.max},
                                  {"whole", t.whole},
                                  {"change", t.change == Change::always ? "always" : "at rest"},
                                  {"help", t.help}});
  }
  json["presentation"] = presentation(vocabulary.presentation);
  json["faults"] = codes(kFaults, logic.codes.faults);
  json["reasons"] = codes(kReasons, logic.codes.reasons);
  json["events"] = codes(kEvents, logic.codes.events);
  json["telemetry"] = {{"topic", "lss/telemetry/" + vehicle},
                       {"type", type_name(vehicle)},
                       {"idl", idl},
                       {"fields", Fields(telemetry_schema).until('\0')}};
  return json.dump();
}

}  // namespace lss
