#include "tools/lss-sim/soil/soil.h"

#include <array>
#include <charconv>
#include <cmath>
#include <stdexcept>

#include "idl/angles.h"

namespace lss::sim::soil {
namespace {

constexpr double kLeastFactor = 0.05, kMostFactor = 20;

constexpr std::array<Soil, 3> kSoils = {{
    {.name = "sand",
     .source = "dry sand, Land Locomotion Laboratory, in J. Y. Wong, Theory of Ground Vehicles; K: "
               "upper end for loose sand",
     .measured_m_s2 = kEarth_m_s2,
     .exponent = 1.1,
     .cohesive = 0.99e3,
     .frictional = 1528.43e3,
     .cohesion_Pa = 1040,
     .friction_rad = 28 * kDegree,
     .shear_m = 0.025},
    {.name = "loam",
     .source =
         "sandy loam with 15 % of moisture, Land Locomotion Laboratory, in J. Y. Wong, Theory "
         "of Ground Vehicles; K as for sand",
     .measured_m_s2 = kEarth_m_s2,
     .exponent = 0.7,
     .cohesive = 5.27e3,
     .frictional = 1515.04e3,
     .cohesion_Pa = 1720,
     .friction_rad = 29 * kDegree,
     .shear_m = 0.025},
    {.name = "regolith",
     .source = "lunar regolith, Lunar Sourcebook, chapter 9, on the Moon",
     .measured_m_s2 = kMoon_m_s2,
     .exponent = 1.0,
     .cohesive = 1.4e3,
     .frictional = 820e3,
     .cohesion_Pa = 170,
     .friction_rad = 35 * kDegree,
     .shear_m = 0.0178},
}};

[[noreturn]] void complain(const std::string& text) {
  std::string known;
  for (const Soil& soil : kSoils) known += std::string(known.empty() ? "" : ", ") += soil.name;
  throw std::invalid_argument("'" + text + "' is no soil: " + known +
                              ", each with :FACTOR of its strength, 0.05 to 20, if wanted");
}

}  // namespace

std::span<const Soil> soils() { return kSoils; }

Soil parse_soil(const std::string& text) {
  const std::size_t colon = text.find(':');
  const std::string name = text.substr(0, colon);
  for (const Soil& known : kSoils) {
    if (name != known.name) continue;
    Soil soil = known;
    if (colon == std::string::npos) return soil;
    const char* end = text.data() + text.size();
    const auto [last, error] = std::from_chars(text.data() + colon + 1, end, soil.factor);
    if (error != std::errc() || last != end || !(soil.factor >= kLeastFactor) ||
        soil.factor > kMostFactor)
      complain(text);
    return soil;
  }
  complain(text);
}

Soil in_gravity(const Soil& soil, double gravity_m_s2) {
  Soil there = soil;
  there.frictional *= gravity_m_s2 / soil.measured_m_s2;
  there.measured_m_s2 = gravity_m_s2;
  return there;
}

double pressure_Pa(const Soil& soil, double width_m, double depth_m) {
  if (depth_m <= 0) return 0;
  return soil.factor * (soil.cohesive / width_m + soil.frictional) *
         std::pow(depth_m, soil.exponent);
}

double stiffness_Pa_m(const Soil& soil, double width_m) {
  constexpr double kAt_m = 0.01;
  return pressure_Pa(soil, width_m, kAt_m) / kAt_m;
}

}  // namespace lss::sim::soil
