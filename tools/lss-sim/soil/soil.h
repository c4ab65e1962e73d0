#pragma once

// Soils that give way, and where each constant comes from: the one table of them (docs/soil.md).
// Pressure under a plate by Bekker, strength by Mohr and Coulomb, shear displacement by Janosi and
// Hanamoto. SI units. Pure functions; any thread.

#include <span>
#include <string>
#include <string_view>

namespace lss::sim::soil {

inline constexpr double kEarth_m_s2 = 9.81, kMoon_m_s2 = 1.625;

struct Soil {
  std::string_view name;
  std::string_view source;
  double measured_m_s2 = kEarth_m_s2;  // gravity where the constants are valid
  double exponent = 1;                 // n
  double cohesive = 0;                 // kc, N/m^(n+1)
  double frictional = 0;               // kphi, N/m^(n+2)
  double cohesion_Pa = 0;              // c
  double friction_rad = 0;             // phi
  double shear_m = 0;                  // K, displacement at 63 % of the strength
  double factor = 1;                   // of all stresses, from the command line
};

std::span<const Soil> soils();

// "NAME" or "NAME:FACTOR", FACTOR 0.05 to 20 (of the soil's stiffness and strength). Throws
// std::invalid_argument that lists the known names.
Soil parse_soil(const std::string& text);

// The soil in another gravity: what friction carries scales with it, what cohesion carries does not
// (J. Slonaker et al., "General scaling relations for locomotion in granular media").
Soil in_gravity(const Soil& soil, double gravity_m_s2);

// Pressure under a plate of this width at this depth, Pa: (kc / b + kphi) z^n. 0 above the surface.
double pressure_Pa(const Soil& soil, double width_m, double depth_m);

// Slope of the line from 0 to the pressure at 1 cm under a plate of this width, Pa/m: the stress
// per depth that resistive force theory scales with (factor zeta; 1 N/cm3 is 1e6 Pa/m).
double stiffness_Pa_m(const Soil& soil, double width_m);

}  // namespace lss::sim::soil
