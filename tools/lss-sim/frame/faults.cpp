#include "tools/lss-sim/frame/faults.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <optional>
#include <utility>

#include "idl/edit_distance.h"

namespace lss::sim {
namespace {

using Error = tl::unexpected<std::string>;

std::vector<std::string_view> split(std::string_view text) {
  std::vector<std::string_view> parts;
  for (std::size_t at = 0;;) {
    const std::size_t colon = text.find(':', at);
    parts.push_back(text.substr(at, colon - at));
    if (colon == std::string_view::npos) return parts;
    at = colon + 1;
  }
}

std::optional<double> to_number(std::string_view text) {
  if (text.starts_with("0x") || text.starts_with("0X")) {
    std::uint32_t bits = 0;
    const auto [end, error] = std::from_chars(text.data() + 2, text.data() + text.size(), bits, 16);
    if (error != std::errc{} || end != text.data() + text.size()) return {};
    return bits;
  }
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size() || !std::isfinite(value)) return {};
  return value;
}

std::string usage(const FaultKind& kind) {
  std::string text = kind.name;
  for (const FaultArgument& argument : kind.arguments) {
    text +=
        argument.optional ? fmt::format("[:{}]", argument.name) : fmt::format(":{}", argument.name);
  }
  return text;
}

tl::expected<const FaultKind*, std::string> find_kind(std::string_view name,
                                                      std::span<const FaultKind> kinds) {
  std::vector<std::string> names;
  for (const FaultKind& kind : kinds) {
    if (name == kind.name) return &kind;
    names.emplace_back(kind.name);
  }
  names.emplace_back("clear");
  const std::string nearest = nearest_name(name, names);
  return Error(fmt::format("unknown fault '{}'{}; there are: {}", name,
                           nearest.empty() ? "" : fmt::format(", did you mean '{}'?", nearest),
                           fmt::join(names, ", ")));
}

std::string written(double value, const FaultArgument& argument) {
  if (!argument.words.empty()) {
    return argument.words[static_cast<std::size_t>(value - argument.min)];
  }
  if (argument.hexadecimal) return fmt::format("0x{:02X}", static_cast<std::uint32_t>(value));
  return fmt::format("{}", value);
}

// "a whole number from 1 to 6", "one of 1, 2, 5, 6", "one of left, right".
std::string allowed(const FaultArgument& argument) {
  if (!argument.words.empty()) return fmt::format("one of {}", fmt::join(argument.words, ", "));
  if (argument.choices.empty()) {
    return fmt::format("a {} from {} to {}", argument.whole ? "whole number" : "number",
                       written(argument.min, argument), written(argument.max, argument));
  }
  std::vector<std::string> texts;
  for (const double choice : argument.choices) texts.push_back(written(choice, argument));
  return fmt::format("one of {}", fmt::join(texts, ", "));
}

tl::expected<double, std::string> parse_value(std::string_view text, const FaultKind& kind,
                                              const FaultArgument& argument) {
  const auto& choices = argument.choices;
  const auto& words = argument.words;
  const auto word = std::ranges::find(words, text);
  const std::optional<double> value =
      words.empty() ? to_number(text)
      : word == words.end()
          ? std::nullopt
          : std::optional(argument.min + static_cast<double>(word - words.begin()));
  if (!value || *value < argument.min || *value > argument.max ||
      (argument.whole && *value != std::round(*value)) ||
      (!choices.empty() && std::ranges::find(choices, *value) == choices.end())) {
    return Error(fmt::format("{}: {} is '{}', but must be {} ({})", usage(kind), argument.name,
                             text, allowed(argument), argument.meaning));
  }
  return *value;
}

tl::expected<Fault, std::string> parse_values(std::span<const std::string_view> texts,
                                              const FaultKind& kind, bool clear) {
  Fault fault{.kind = &kind, .values = {}, .clear = clear};
  const std::size_t most = clear ? kind.per_unit : kind.arguments.size();
  if (texts.size() > most) {
    return Error(fmt::format("too many arguments in '{}:{}', it is written {}{}", kind.name,
                             fmt::join(texts, ":"), clear ? "clear:" : "", usage(kind)));
  }
  for (std::size_t i = 0; i < most; ++i) {
    const FaultArgument& argument = kind.arguments[i];
    if (i < texts.size()) {
      const auto value = parse_value(texts[i], kind, argument);
      if (!value) return Error(value.error());
      fault.values.push_back(*value);
    } else if (clear) {
      break;
    } else if (argument.optional) {
      fault.values.push_back(argument.fallback);
    } else {
      return Error(fmt::format("'{}' needs {} ({}), it is written {}", kind.name, argument.name,
                               argument.meaning, usage(kind)));
    }
  }
  return fault;
}

std::optional<double> parse_time_s(std::string_view text) {
  struct Unit {
    std::string_view suffix;
    double seconds;
  };
  for (const Unit& unit : {Unit{"ms", 1e-3}, Unit{"min", 60}, Unit{"s", 1}}) {
    if (!text.ends_with(unit.suffix)) continue;
    const auto number = to_number(text.substr(0, text.size() - unit.suffix.size()));
    if (!number || *number < 0) return {};
    return *number * unit.seconds;
  }
  return {};
}

bool same_unit(const Fault& a, const Fault& b) {
  const std::size_t said = std::min({a.kind->per_unit, a.values.size(), b.values.size()});
  const auto count = static_cast<std::ptrdiff_t>(said);
  return a.kind == b.kind &&
         std::equal(a.values.begin(), a.values.begin() + count, b.values.begin());
}

}  // namespace

tl::expected<Fault, std::string> parse_fault(std::string_view text,
                                             std::span<const FaultKind> kinds) {
  const std::vector<std::string_view> parts = split(text);
  const bool clear = parts.front() == "clear";
  if (clear && parts.size() == 1) return Fault{.kind = nullptr, .values = {}, .clear = true};
  const std::size_t name = clear ? 1 : 0;
  const auto kind = find_kind(parts[name], kinds);
  if (!kind) return Error(kind.error());
  return parse_values(std::span(parts).subspan(name + 1), **kind, clear);
}

tl::expected<TimedFault, std::string> parse_timed_fault(std::string_view text,
                                                        std::span<const FaultKind> kinds) {
  const std::size_t colon = text.find(':');
  const std::optional<double> at_s = parse_time_s(text.substr(0, colon));
  if (!at_s || colon == std::string_view::npos) {
    return Error(fmt::format(
        "'{}' does not begin with a time: it is written TIME:KIND[:ARG...], for example 5s:{}",
        text, usage(kinds.front())));
  }
  const auto fault = parse_fault(text.substr(colon + 1), kinds);
  if (!fault) return Error(fault.error());
  return TimedFault{.at_s = *at_s, .fault = *fault};
}

std::string to_text(const Fault& fault) {
  std::string text = fault.clear ? "clear" : "";
  if (fault.kind != nullptr) text += (fault.clear ? ":" : "") + std::string(fault.kind->name);
  for (std::size_t i = 0; i < fault.values.size(); ++i) {
    text += ":" + written(fault.values[i], fault.kind->arguments[i]);
  }
  return text;
}

std::string describe(std::span<const FaultKind> kinds) {
  std::string text;
  for (const FaultKind& kind : kinds) {
    text += fmt::format("{:<28} {}\n", usage(kind), kind.meaning);
    for (const FaultArgument& argument : kind.arguments) {
      text += fmt::format("{:<28}   {}: {}, {}", "", argument.name, argument.meaning,
                          argument.choices.empty() && argument.words.empty()
                              ? fmt::format("{} to {}", written(argument.min, argument),
                                            written(argument.max, argument))
                              : allowed(argument));
      text += argument.optional
                  ? fmt::format(", default {}\n", written(argument.fallback, argument))
                  : "\n";
    }
  }
  return text;
}

std::string nearest_name(std::string_view wrong, std::span<const std::string> names) {
  std::string best;
  std::size_t least = wrong.size() / 2 + 1;  // a larger distance is not a typing error
  for (const std::string& name : names) {
    const std::size_t distance = edit_distance(wrong, name);
    if (distance < least) {
      least = distance;
      best = name;
    }
  }
  return best;
}

std::vector<Fault> FaultBoard::take_matching(const Fault& fault) {
  const std::lock_guard lock(mutex_);
  const auto kept = std::stable_partition(
      attached_.begin(), attached_.end(),
      [&](const Fault& attached) { return fault.kind != nullptr && !same_unit(attached, fault); });
  std::vector<Fault> taken(std::make_move_iterator(kept), std::make_move_iterator(attached_.end()));
  attached_.erase(kept, attached_.end());
  return taken;
}

bool WireFaults::set(const Fault& fault, bool attach) {
  std::string_view name = fault.kind->name;
  constexpr std::string_view kNumbered = "line-";
  if (name.starts_with(kNumbered)) name.remove_prefix(kNumbered.size());
  const double value = attach && !fault.values.empty() ? fault.values.back() : 0;
  if (name == "noise") {
    noise = value;
  } else if (name == "drop") {
    drop = value;
  } else if (name == "duplicate") {
    duplicate = value;
  } else if (name == "late") {
    late_ns = static_cast<TimeNs>(value * kMillisecond);
  } else if (name == "bus-cut" || name == "cut") {
    cut = attach;
  } else {
    return false;
  }
  return true;
}

void FaultBoard::inject(const Fault& fault) {
  for (const Fault& old : take_matching(fault)) act_(old, false);
  if (fault.clear) return;
  act_(fault, true);
  if (fault.kind->momentary) return;
  const std::lock_guard lock(mutex_);
  attached_.push_back(fault);
}

std::vector<std::string> FaultBoard::attached() {
  const std::lock_guard lock(mutex_);
  std::erase_if(attached_, [&](const Fault& fault) { return !in_force_(fault); });
  std::vector<std::string> texts;
  for (const Fault& fault : attached_) texts.push_back(to_text(fault));
  return texts;
}

}  // namespace lss::sim
