#include "tools/lss-sim/ardito/patch.h"

#include <charconv>
#include <stdexcept>

namespace lss::sim::ardito {
namespace {

[[noreturn]] void complain(const std::string& text, const std::string& why) {
  throw std::invalid_argument("--patch " + text + ": " + why +
                              "; it is SOIL[:FACTOR]@WHEELS[@FROM..TO], for example "
                              "sand:0.1@4@2..3, with wheels 1 to 6 and metres ahead of the start");
}

double metres(const std::string& text, const std::string& number) {
  double value = 0;
  const char* end = number.data() + number.size();
  const auto [last, error] = std::from_chars(number.data(), end, value);
  if (error != std::errc() || last != end || !(std::abs(value) <= 1000))
    complain(text, "'" + number + "' is no number of metres from -1000 to 1000");
  return value;
}

}  // namespace

soil::Soil mixed(const soil::Soil& one, const soil::Soil& other, double share) {
  if (share <= 0) return one;
  if (share >= 1) return other;
  soil::Soil soil = one;
  soil.exponent = std::lerp(one.exponent, other.exponent, share);
  soil.cohesive = std::lerp(one.cohesive, other.cohesive, share);
  soil.frictional = std::lerp(one.frictional, other.frictional, share);
  soil.cohesion_Pa = std::lerp(one.cohesion_Pa, other.cohesion_Pa, share);
  soil.friction_rad = std::lerp(one.friction_rad, other.friction_rad, share);
  soil.shear_m = std::lerp(one.shear_m, other.shear_m, share);
  soil.factor = one.factor * std::pow(other.factor / one.factor, share);
  return soil;
}

Patch parse_patch(const std::string& text) {
  const std::size_t at = text.find('@');
  if (at == std::string::npos) complain(text, "it names no wheels");
  const std::size_t second = text.find('@', at + 1);
  Patch patch;
  try {
    patch.soil = soil::parse_soil(text.substr(0, at));
  } catch (const std::invalid_argument& error) {
    complain(text, error.what());
  }
  const std::string wheels = text.substr(at + 1, second - at - 1);
  if (wheels.empty()) complain(text, "it names no wheels");
  for (const char digit : wheels) {
    if (digit < '1' || digit > '6')
      complain(text, "there is no wheel '" + std::string(1, digit) + "'");
    patch.wheels[static_cast<std::size_t>(digit - '1')] = true;
  }
  if (second == std::string::npos) return patch;
  const std::string stretch = text.substr(second + 1);
  const std::size_t dots = stretch.find("..");
  if (dots == std::string::npos) complain(text, "'" + stretch + "' is no stretch FROM..TO");
  patch.from_m = metres(text, stretch.substr(0, dots));
  patch.to_m = metres(text, stretch.substr(dots + 2));
  if (!(patch.from_m < patch.to_m)) complain(text, "the stretch ends before it begins");
  return patch;
}

}  // namespace lss::sim::ardito
