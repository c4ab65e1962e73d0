// dictionary, codes: what a vehicle is, and the meaning of numbers.

#include <fmt/format.h>

#include <algorithm>
#include <span>
#include <string>
#include <utility>

#include "idl/codes.h"
#include "tools/lss-cli/session/vehicle.h"
#include "tools/lss-cli/verbs/verbs.h"

namespace lss::cli {
namespace {

ExitCode run_dictionary(Context& context) {
  nlohmann::json document = nlohmann::json::parse(context.session().link().dictionary());
  context.output.print(document.dump(2) + "\n");
  context.output.document(std::move(document));
  return ExitCode::completed;
}

struct List {
  const char* name;
  std::span<const CodeInfo> codes;
  std::span<const CodeInfo> OwnCodes::*of_vehicle;
};
constexpr List kLists[] = {{"faults", kFaults, &OwnCodes::faults},
                           {"reasons", kReasons, &OwnCodes::reasons},
                           {"events", kEvents, &OwnCodes::events}};
constexpr const char* kSeverities[] = {"info", "warning", "error", "fatal"};
constexpr const char* kModes = "modes";

// Of the locomotion controllers; the states are the same in all.
std::string modes(nlohmann::json& document) {
  std::string text;
  const auto tell = [&](const std::string& title, const nlohmann::json& names, const char* list,
                        const nlohmann::json& more) {
    text += title + "\n";
    for (std::size_t i = 0; i < names.size(); ++i) {
      text += fmt::format("  {:4} {}\n", i, names[i].get<std::string>());
      document[list].push_back({{"number", i}, {"name", names[i]}});
      document[list].back().update(more);
    }
  };
  for (const std::string& dictionary : built_dictionaries()) {
    const nlohmann::json vehicle = nlohmann::json::parse(dictionary);
    const std::string name = vehicle.at("vehicle");
    if (text.empty()) tell("states", vehicle.at("states"), "states", nlohmann::json::object());
    tell("modes of " + name, vehicle.at("modes"), kModes, {{"vehicle", name}});
  }
  return text;
}

ExitCode run_codes(Context& context, const std::string& wanted) {
  const bool known = wanted == kModes ||
                     std::ranges::any_of(kLists, [&](const List& l) { return wanted == l.name; });
  if (!wanted.empty() && !known) {
    throw Failure(ExitCode::unknown_name, fmt::format("there is no list {}", wanted),
                  "name one of: faults, reasons, events, modes");
  }
  nlohmann::json document = nlohmann::json::object();
  for (const List& list : kLists) {
    if (!wanted.empty() && wanted != list.name) continue;
    std::string text = fmt::format("{}\n", list.name);
    const auto tell = [&](const CodeInfo& code, std::string_view vehicle) {
      if (std::string_view(code.text) == "retired") return;
      const char* severity = kSeverities[code.severity];
      text += fmt::format("  {:4} {:28} {:8} {}\n", code.number, code.name, severity, code.text);
      if (*code.advice != '\0') text += fmt::format("{:44}-> {}\n", "", code.advice);
      document[list.name].push_back({{"number", code.number},
                                     {"name", code.name},
                                     {"severity", severity},
                                     {"text", code.text},
                                     {"advice", code.advice}});
      if (!vehicle.empty()) document[list.name].back()["vehicle"] = vehicle;
    };
    for (const CodeInfo& code : list.codes) tell(code, "");
    for (const Vehicle* vehicle : vehicles()) {
      bool first = true;
      for (const CodeInfo& code : vehicle->codes.*list.of_vehicle) {
        if (find_code(list.codes, code.number) != nullptr) continue;  // of all
        if (std::exchange(first, false))
          text += fmt::format("{} of {}\n", list.name, vehicle->name);
        tell(code, vehicle->name);
      }
    }
    context.output.print(text);
  }
  if (wanted.empty() || wanted == kModes) context.output.print(modes(document));
  context.output.document(std::move(document));
  return ExitCode::completed;
}

}  // namespace

void add_dictionary_verbs(Grammar& grammar) {
  if (grammar.scope() != Grammar::Scope::program) return;
  grammar.on(
      grammar.verb("dictionary",
                   "what the daemon says of its vehicle: commands, modes, parameters, faults "
                   "and telemetry, as JSON",
                   "  lss-cli dictionary\n"),
      run_dictionary);
  CLI::App& sub = grammar.verb(
      "codes", "numbers of faults, reasons and events, with advice; of states and modes",
      "  lss-cli codes\n  lss-cli codes faults\n");
  auto list = std::make_shared<std::string>();
  sub.add_option("list", *list, "faults, reasons, events or modes; all when not given");
  grammar.values(sub, "", {"faults", "reasons", "events", "modes"});
  grammar.on(sub, [list](Context& context) { return run_codes(context, *list); });
}

}  // namespace lss::cli
