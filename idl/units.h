#pragma once

// The unit that the end of a name says: "position_rad" is in rad. Pure data.

#include <string_view>

namespace lss {

// Empty: it has none. An index at the end of the name does not matter.
constexpr std::string_view unit_of(std::string_view name) {
  struct Unit {
    std::string_view suffix, text;
  };
  constexpr Unit kUnits[] = {
      {"_thruster_s", "thruster s"},
      {"_rad_s", "rad/s"},
      {"_m_s2", "m/s²"},
      {"_degC", "°C"},
      {"_rad", "rad"},
      {"_m_s", "m/s"},
      {"_rpm", "1/min"},
      {"_Nm", "N m"},
      {"_Pa", "Pa"},
      {"_ns", "ns"},
      {"_ms", "ms"},
      {"_m", "m"},
      {"_s", "s"},
      {"_A", "A"},
      {"_V", "V"},
      {"_N", "N"},
  };
  if (name.ends_with(']')) name = name.substr(0, name.rfind('['));
  for (const Unit& unit : kUnits) {
    if (name.ends_with(unit.suffix)) return unit.text;
  }
  return {};
}

}  // namespace lss
