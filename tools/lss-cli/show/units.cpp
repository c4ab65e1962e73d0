#include "tools/lss-cli/show/units.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <span>

#include "idl/angles.h"
#include "tools/lss-cli/show/failure.h"

namespace lss::cli {
namespace {

struct Suffix {
  std::string_view text;
  double factor;
};

constexpr Suffix kAngles[] = {{"", kDegree}, {"deg", kDegree}, {"°", kDegree}, {"rad", 1}};
constexpr Suffix kTimes[] = {{"", 1}, {"s", 1}, {"ms", 1e-3}, {"min", 60}, {"h", 3600}};
constexpr Suffix kSpeeds[] = {{"", 1}, {"m/s", 1}, {"cm/s", 1e-2}, {"mm/s", 1e-3}};

std::span<const Suffix> suffixes(std::string_view unit) {
  if (unit == "rad") return kAngles;
  if (unit == "s") return kTimes;
  if (unit == "m/s") return kSpeeds;
  return {};
}

[[noreturn]] void refuse(std::string_view what, std::string_view text, const std::string& why) {
  throw Failure(ExitCode::usage, fmt::format("{}: '{}' {}", what, text, why));
}

}  // namespace

double parse_quantity(std::string_view text, std::string_view unit, std::string_view what) {
  const std::string_view number = text.starts_with('+') ? text.substr(1) : text;
  double value = 0;
  const auto [end, error] = std::from_chars(number.data(), number.data() + number.size(), value);
  if (error != std::errc() || !std::isfinite(value)) refuse(what, text, "is not a number");
  std::string_view suffix(end, static_cast<std::size_t>(number.data() + number.size() - end));
  while (suffix.starts_with(' ')) suffix.remove_prefix(1);

  const std::span<const Suffix> known = suffixes(unit);
  if (known.empty()) {
    if (suffix.empty() || suffix == unit) return value;
    refuse(what, text,
           unit.empty() ? "must be a number without unit" : fmt::format("must be in {}", unit));
  }
  std::string list;
  for (const Suffix& s : known) {
    if (s.text == suffix) return value * s.factor;
    if (!s.text.empty()) list += fmt::format("{}{}", list.empty() ? "" : ", ", s.text);
  }
  refuse(what, text, fmt::format("has an unknown unit (known: {})", list));
}

double parse_set(std::string_view text, std::uint64_t all, std::string_view what) {
  std::uint64_t set = 0;
  for (std::string_view rest = text; !rest.empty();) {
    const std::string_view word = rest.substr(0, rest.find(','));
    rest.remove_prefix(std::min(rest.size(), word.size() + 1));
    unsigned number = 0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), number);
    const bool read = error == std::errc() && end == word.data() + word.size();
    if (!read || number < 1 || number > 32 || ((all >> (number - 1)) & 1u) == 0)
      refuse(what, text,
             fmt::format("must be numbers out of {}, divided by commas", format_set(all)));
    set |= std::uint64_t{1} << (number - 1);
  }
  if (set == 0) refuse(what, text, "names nothing");
  return static_cast<double>(set);
}

std::string format_set(std::uint64_t set) {
  std::string text;
  for (unsigned i = 0; i < 32; ++i) {
    if (((set >> i) & 1u) != 0) text += fmt::format("{}{}", text.empty() ? "" : ",", i + 1);
  }
  return text.empty() ? "none" : text;
}

double parse_duration_s(std::string_view text, std::string_view what) {
  const double seconds = parse_quantity(text, "s", what);
  if (seconds <= 0) refuse(what, text, "must be longer than nothing");
  return seconds;
}

std::string format_quantity(double value, std::string_view unit) {
  if (unit == "rad") return fmt::format("{:.4g} deg", value / kDegree);
  if (unit == "set") return format_set(static_cast<std::uint64_t>(value));
  if (unit.empty() || unit == "choice") return fmt::format("{:.6g}", value);
  return fmt::format("{:.4g} {}", value, unit);
}

std::string format_duration(double seconds) {
  if (seconds < 10) return fmt::format("{:.1f} s", seconds);
  const auto whole = static_cast<long long>(std::llround(seconds));
  if (whole < 60) return fmt::format("{} s", whole);
  if (whole < 3600) return fmt::format("{} min {} s", whole / 60, whole % 60);
  return fmt::format("{} h {} min", whole / 3600, whole % 3600 / 60);
}

}  // namespace lss::cli
