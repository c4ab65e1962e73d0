#pragma once

// The unit that the end of a name says: "position_rad" is in rad. And the unit in which people read
// it: an angle in degrees. Pure data.

#include <string_view>

#include "idl/angles.h"

namespace lss {

struct Unit {
  std::string_view suffix, text;  // "_rad", "rad"; empty: none
  std::string_view shown = text;  // "deg"
  double factor = 1;              // from one to the other
};

// An index at the end of the name does not matter.
constexpr Unit unit_in(std::string_view name) {
  constexpr Unit kUnits[] = {
      {"_thruster_s", "thruster s"},
      {"_rad_s", "rad/s", "deg/s", 1 / kDegree},
      {"_m_s2", "m/s²"},
      {"_degC", "°C"},
      {"_rad", "rad", "deg", 1 / kDegree},
      {"_m_s", "m/s"},
      {"_rpm", "1/min"},
      {"_Nm", "N m"},
      {"_Pa", "Pa", "bar", 1e-5},
      {"_ns", "ns", "ms", 1e-6},
      {"_ms", "ms"},
      {"_m", "m"},
      {"_s", "s"},
      {"_A", "A"},
      {"_V", "V"},
      {"_N", "N"},
  };
  if (name.ends_with(']')) name = name.substr(0, name.rfind('['));
  for (const Unit& unit : kUnits) {
    if (name.ends_with(unit.suffix)) return unit;
  }
  return {};
}
constexpr std::string_view unit_of(std::string_view name) { return unit_in(name).text; }

// Without its unit: "position" of "position_rad".
constexpr std::string_view without_unit(std::string_view name) {
  return name.substr(0, name.size() - unit_in(name).suffix.size());
}

}  // namespace lss
