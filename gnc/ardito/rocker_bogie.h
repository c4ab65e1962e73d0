#pragma once

// Positions of the wheels relative to the CM when rockers and bogies turn, and back (Ardito thesis
// 13, with E2 to E6, E23); and their effect on the speed of a wheel on uneven ground (12.1.2,
// 17.6). Pure functions, callable from every thread. x forward, z down, origin in the CM.

#include "gnc/ardito/direction.h"
#include "gnc/ardito/parameters.h"

namespace lss::gnc::ardito {

struct RockerAngles {
  double beta_rad = 0;  // left rocker; the right one is at -beta
  double rho1_rad = 0;  // left bogie
  double rho2_rad = 0;  // right bogie
};

// Relative to its pivot.
struct Point {
  double x_m = 0;
  double z_m = 0;

  template <class Self>
  static constexpr auto members(Self& self) noexcept {
    return std::tie(self.x_m, self.z_m);
  }
};

// Points on rocker and bogie at zero angles (13.1); the same on both sides. Computed once, since it
// needs sines.
struct Linkage {
  double pivot_x_m = 0;  // of the rocker, from the CM
  Point front_on_rocker;
  Point bogie_on_rocker;
  Point middle_on_bogie;
  Point rear_on_bogie;

  template <class Self>
  static constexpr auto members(Self& self) noexcept {
    return std::tie(self.pivot_x_m, self.front_on_rocker, self.bogie_on_rocker,
                    self.middle_on_bogie, self.rear_on_bogie);
  }
};
Linkage linkage(const Geometry& geometry) noexcept;

struct WheelPoses {
  PerWheel<double> x_m{};
  PerWheel<double> z_m{};

  template <class Self>
  static constexpr auto members(Self& self) noexcept {
    return std::tie(self.x_m, self.z_m);
  }
};

WheelPoses wheel_poses(const RockerAngles& angles, const Linkage& linkage) noexcept;
inline WheelPoses wheel_poses(const RockerAngles& angles, const Geometry& geometry) noexcept {
  return wheel_poses(angles, linkage(geometry));
}

// Speed at the rim so that the CM moves as in the plane while the suspension moves the hub by (vx,
// vz) relative to it: V = sign(u) sqrt((u cos(alpha) + vx)^2 + (u sin(alpha))^2 + vz^2). sign: +1
// right, -1 as printed (E7, E1).
double rim_speed_m_s(double plane_m_s, const Direction& steering, double vx_m_s, double vz_m_s,
                     double sign) noexcept;
// Its exact inverse (E11). A rim slower than its hub has slipped; then 0 along the ground.
double plane_speed_m_s(double rim_m_s, const Direction& steering, double vx_m_s, double vz_m_s,
                       double sign) noexcept;

}  // namespace lss::gnc::ardito
