#include "tools/lss-sim/soil/patch.h"

#include <charconv>
#include <optional>
#include <stdexcept>
#include <utility>

namespace lss::sim::soil {
namespace {

[[noreturn]] void complain(const std::string& text, const std::string& part,
                           const std::string& why) {
  throw std::invalid_argument("--patch " + text + ": " + why +
                              "; it is SOIL[:FACTOR]@NUMBERS[@FROM..TO], for example "
                              "sand:0.1@4@2..3, with " +
                              part + "s 1 to 6 and metres ahead of the start");
}

std::optional<double> metres(const std::string& number) {
  double value = 0;
  const char* end = number.data() + number.size();
  const auto [last, error] = std::from_chars(number.data(), end, value);
  if (error != std::errc() || last != end || !(std::abs(value) <= 1000)) return {};
  return value;
}

}  // namespace

Soil mixed(const Soil& one, const Soil& other, double share) {
  if (share <= 0) return one;
  if (share >= 1) return other;
  Soil soil = one;
  soil.exponent = std::lerp(one.exponent, other.exponent, share);
  soil.cohesive = std::lerp(one.cohesive, other.cohesive, share);
  soil.frictional = std::lerp(one.frictional, other.frictional, share);
  soil.cohesion_Pa = std::lerp(one.cohesion_Pa, other.cohesion_Pa, share);
  soil.friction_rad = std::lerp(one.friction_rad, other.friction_rad, share);
  soil.shear_m = std::lerp(one.shear_m, other.shear_m, share);
  soil.factor = one.factor * std::pow(other.factor / one.factor, share);
  return soil;
}

Patch parse_patch(const std::string& text, const std::string& part, double edge_m) {
  const auto refuse = [&](const std::string& why) { complain(text, part, why); };
  const std::size_t at = text.find('@');
  if (at == std::string::npos) refuse("it names no " + part + "s");
  const std::size_t second = text.find('@', at + 1);
  Patch patch;
  patch.edge_m = edge_m;
  try {
    patch.soil = parse_soil(text.substr(0, at));
  } catch (const std::invalid_argument& error) {
    refuse(error.what());
  }
  const std::string numbers = text.substr(at + 1, second - at - 1);
  if (numbers.empty()) refuse("it names no " + part + "s");
  for (const char digit : numbers) {
    if (digit < '1' || digit > '6')
      refuse("there is no " + part + " '" + std::string(1, digit) + "'");
    patch.parts[static_cast<std::size_t>(digit - '1')] = true;
  }
  if (second == std::string::npos) return patch;
  const std::string stretch = text.substr(second + 1);
  const std::size_t dots = stretch.find("..");
  if (dots == std::string::npos) refuse("'" + stretch + "' is no stretch FROM..TO");
  for (const auto& [number, to] : {std::pair(stretch.substr(0, dots), &patch.from_m),
                                   {stretch.substr(dots + 2), &patch.to_m}}) {
    const std::optional<double> value = metres(number);
    if (!value) refuse("'" + number + "' is no number of metres from -1000 to 1000");
    *to = *value;
  }
  if (!(patch.from_m < patch.to_m)) refuse("the stretch ends before it begins");
  return patch;
}

}  // namespace lss::sim::soil
