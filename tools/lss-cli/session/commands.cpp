#include "tools/lss-cli/session/commands.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <optional>

#include "tools/lss-cli/session/vehicle.h"
#include "tools/lss-cli/show/failure.h"
#include "tools/lss-cli/show/names.h"
#include "tools/lss-cli/show/units.h"

namespace lss::cli {
namespace {

bool required(const ParameterInfo& p) { return std::isnan(p.fallback); }

bool numbers_subjects(const ParameterInfo& p) {
  const std::string_view name = p.name;
  return p.choices == nullptr && (name == "leg" || name == "module" || name == "node");
}

bool is_set(const ParameterInfo& p) { return std::string_view(p.unit) == "set"; }

// Yes and no need the parameter's name: alone they are ambiguous.
bool speaks_for_itself(const ParameterInfo& p) {
  return p.choices != nullptr && p.choices != kNoYes && p.choices != kOffOn;
}

std::optional<double> value_named(const ParameterInfo& p, const Vehicle& vehicle,
                                  std::string_view word) {
  if (p.choices != nullptr) {
    for (double v = p.min; v <= p.max; ++v) {
      if (p.choices[static_cast<std::size_t>(v - p.min)] == word) return v;
    }
  } else if (is_set(p)) {
    if (word == "all") return p.max;
    if (word == "none") return 0;
  } else if (numbers_subjects(p)) {
    if (word == "controller" && p.min <= -1) return -1;
    if (word == "all" && p.min <= 0) return 0;
    for (std::size_t i = 0; i < vehicle.subjects.size(); ++i) {
      if (vehicle.subjects[i] == word) return static_cast<double>(i + 1);
    }
  }
  return std::nullopt;
}

std::string show(const ParameterInfo& p, double value) {
  if (p.choices != nullptr && value >= p.min && value <= p.max) {
    return p.choices[static_cast<std::size_t>(value - p.min)];
  }
  return format_quantity(value, p.unit);
}

std::string range(const ParameterInfo& p) {
  if (is_set(p)) return fmt::format("one or more of {}, divided by commas, or all", show(p, p.max));
  if (p.choices == nullptr) {
    return fmt::format("{} to {}", format_quantity(p.min, p.unit), format_quantity(p.max, p.unit));
  }
  std::string list;
  for (double v = p.min; v <= p.max; ++v) list += (v > p.min ? ", " : "") + show(p, v);
  return list;
}

double parse(const CommandInfo& info, const ParameterInfo& p, const Vehicle& vehicle,
             const std::string& word) {
  if (const std::optional<double> value = value_named(p, vehicle, word)) {
    if (*value >= p.min && *value <= p.max) return *value;
  }
  if (p.choices != nullptr) {
    throw Failure(ExitCode::usage,
                  fmt::format("{} --{}: '{}' is none of: {}", info.name, p.name, word, range(p)),
                  did_you_mean(word, value_names(p, vehicle)));
  }
  const std::string what = fmt::format("{} --{}", info.name, p.name);
  if (numbers_subjects(p) && !word.empty() && std::isalpha(static_cast<unsigned char>(word[0]))) {
    const std::vector<std::string> names = value_names(p, vehicle);
    throw Failure(ExitCode::usage,
                  fmt::format("{}: '{}' is none of: {}", what, word, fmt::join(names, ", ")),
                  did_you_mean(word, names));
  }
  if (is_set(p)) return parse_set(word, static_cast<std::uint64_t>(p.max), what);
  const double value = parse_quantity(word, p.unit, what);
  if (value < p.min || value > p.max) {
    throw Failure(ExitCode::usage,
                  fmt::format("{} --{}: {} is out of range", info.name, p.name,
                              format_quantity(value, p.unit)),
                  "choose from " + range(p));
  }
  if (p.is_whole() && value != std::floor(value)) {
    throw Failure(ExitCode::usage,
                  fmt::format("{} --{}: '{}' is not a whole number", info.name, p.name, word));
  }
  return value;
}

// The index of the parameter that a bare word belongs to; the number of parameters when there is
// none.
std::size_t place(const CommandInfo& info, const Vehicle& vehicle, const std::string& word,
                  const std::array<bool, kMaxParameters>& given) {
  const auto first = [&](auto&& fits) {
    std::size_t i = 0;
    while (i < info.parameters.size() && (given[i] || !fits(info.parameters[i]))) ++i;
    return i;
  };
  const std::size_t none = info.parameters.size();
  std::size_t i = first(required);
  if (i == none) {
    i = first([&](const ParameterInfo& p) {
      return (speaks_for_itself(p) || p.choices == nullptr) && value_named(p, vehicle, word);
    });
  }
  if (i == none && !std::isalpha(static_cast<unsigned char>(word.front()))) {
    i = first([](const ParameterInfo& p) { return p.choices == nullptr; });
  }
  return i;
}

Failure surplus(const CommandInfo& info, const Vehicle& vehicle, const std::string& word) {
  std::vector<std::string> known;
  for (const ParameterInfo& p : info.parameters) {
    if (p.choices != nullptr && !speaks_for_itself(p)) continue;
    for (std::string& name : value_names(p, vehicle)) known.push_back(std::move(name));
  }
  std::string advice = did_you_mean(word, known);
  if (advice.empty() && !known.empty())
    advice = fmt::format("choose from {}", fmt::join(known, ", "));
  if (advice.empty()) advice = fmt::format("see: lss-cli command describe {}", info.name);
  return Failure(ExitCode::usage, fmt::format("{} does not know what '{}' is for", info.name, word),
                 advice);
}

}  // namespace

std::vector<const CommandInfo*> commands_of(const Vehicle& vehicle) {
  std::vector<const CommandInfo*> all;
  for (const CommandInfo& info : kCommonCommands) all.push_back(&info);
  for (const CommandInfo& info : vehicle.commands) all.push_back(&info);
  std::ranges::sort(all, {}, &CommandInfo::kind);
  return all;
}

std::vector<std::string> command_names(const Vehicle& vehicle) {
  std::vector<std::string> names;
  for (const CommandInfo* info : commands_of(vehicle)) names.emplace_back(info->name);
  return names;
}

const CommandInfo& find_command(const Vehicle& vehicle, std::string_view name) {
  for (const CommandInfo* info : commands_of(vehicle)) {
    if (info->name == name) return *info;
  }
  std::string advice = did_you_mean(name, command_names(vehicle));
  if (advice.empty()) advice = "list them with: lss-cli command list";
  throw Failure(ExitCode::unknown_name, fmt::format("{} has no command '{}'", vehicle.name, name),
                advice);
}

const CommandInfo& find_command(const Vehicle& vehicle, std::uint16_t kind) {
  for (const CommandInfo* info : commands_of(vehicle)) {
    if (info->kind == kind) return *info;
  }
  throw Failure(ExitCode::internal, fmt::format("{} has no command number {}", vehicle.name, kind));
}

const CommandInfo& common_command(CommandKind kind) {
  return *std::ranges::find(kCommonCommands, static_cast<std::uint16_t>(kind), &CommandInfo::kind);
}

Invocation with_defaults(const CommandInfo& info) {
  Invocation result{.info = &info, .parameter = {}};
  for (std::size_t i = 0; i < info.parameters.size(); ++i)
    result.parameter[i] = info.parameters[i].fallback;
  return result;
}

Invocation read_invocation(const CommandInfo& info, const Vehicle& vehicle,
                           std::span<const std::string> words,
                           const std::map<std::string, std::string>& named) {
  Invocation result = with_defaults(info);
  std::array<bool, kMaxParameters> given{};
  for (std::size_t i = 0; i < info.parameters.size(); ++i) {
    const auto found = named.find(info.parameters[i].name);
    if (found == named.end()) continue;
    result.parameter[i] = parse(info, info.parameters[i], vehicle, found->second);
    given[i] = true;
  }
  for (const std::string& word : words) {
    const std::size_t i = place(info, vehicle, word, given);
    if (i == info.parameters.size()) throw surplus(info, vehicle, word);
    result.parameter[i] = parse(info, info.parameters[i], vehicle, word);
    given[i] = true;
  }
  for (std::size_t i = 0; i < info.parameters.size(); ++i) {
    const ParameterInfo& p = info.parameters[i];
    if (required(p) && !given[i]) {
      throw Failure(ExitCode::usage,
                    fmt::format("{} needs its {}: {}", info.name, p.name, range(p)),
                    fmt::format("see: lss-cli {} --help", info.name));
    }
  }
  return result;
}

std::string describe(const Invocation& invocation) {
  std::string text = invocation.info->name;
  for (std::size_t i = 0; i < invocation.info->parameters.size(); ++i) {
    const ParameterInfo& p = invocation.info->parameters[i];
    const double value = invocation.parameter[i];
    if (!required(p) && value == p.fallback && !speaks_for_itself(p)) continue;
    text +=
        speaks_for_itself(p) ? " " + show(p, value) : fmt::format(" {} {}", p.name, show(p, value));
  }
  return text;
}

std::string describe(const CommandInfo& info, const Vehicle& vehicle) {
  std::string text = fmt::format("{}  (number {})\n  {}\n", info.name, info.kind, info.summary);
  text += fmt::format("  from: {}{}\n",
                      info.access == Access::anyone ? "anyone" : "who holds authority, or takes it",
                      info.leased ? "; ends when the heartbeat of its source ends" : "");
  for (const ParameterInfo& p : info.parameters) {
    text += fmt::format(
        "  --{:<10} {}{}\n", p.name, range(p),
        required(p) ? "; must be given" : fmt::format("; default {}", show(p, p.fallback)));
    text += fmt::format("  {:<12} {}\n", "", p.help);
  }
  for (const lc::Allowed& a : vehicle.allowed(info)) {
    text += fmt::format("  in: {}\n", a.where);
    if (!a.when.empty()) text += fmt::format("      when {}\n", fmt::join(a.when, ", "));
  }
  if (const auto examples = vehicle.examples.find(info.kind); examples != vehicle.examples.end())
    text += fmt::format("  Examples:\n{}", examples->second);
  return text;
}

nlohmann::json to_json(const CommandInfo& info, const Vehicle& vehicle) {
  nlohmann::json places = nlohmann::json::array();
  for (const lc::Allowed& a : vehicle.allowed(info))
    places.push_back({{"where", a.where}, {"when", a.when}});
  nlohmann::json parameters = nlohmann::json::array();
  for (const ParameterInfo& p : info.parameters) {
    nlohmann::json one = {{"name", p.name}, {"unit", p.unit},          {"min", p.min},
                          {"max", p.max},   {"required", required(p)}, {"whole", p.is_whole()},
                          {"help", p.help}};
    one["default"] = required(p) ? nlohmann::json() : nlohmann::json(p.fallback);
    if (p.choices != nullptr) {
      for (double v = p.min; v <= p.max; ++v) one["choices"].push_back(show(p, v));
    }
    parameters.push_back(std::move(one));
  }
  return {{"kind", info.kind},
          {"name", info.name},
          {"summary", info.summary},
          {"access", info.access == Access::anyone ? "anyone" : "holder"},
          {"leased", info.leased},
          {"parameters", std::move(parameters)},
          {"allowed", std::move(places)}};
}

std::vector<std::string> value_names(const ParameterInfo& p, const Vehicle& vehicle) {
  std::vector<std::string> names;
  if (p.choices != nullptr) {
    for (double v = p.min; v <= p.max; ++v) names.push_back(show(p, v));
  } else if (is_set(p)) {
    names.emplace_back("all");
    if (p.min <= 0) names.emplace_back("none");
  } else if (numbers_subjects(p)) {
    for (std::size_t i = 0; i < vehicle.subjects.size(); ++i) {
      if (static_cast<double>(i + 1) <= p.max) names.emplace_back(vehicle.subjects[i]);
    }
    if (p.min <= 0) names.emplace_back("all");
    if (p.min <= -1) names.emplace_back("controller");
  }
  return names;
}

}  // namespace lss::cli
