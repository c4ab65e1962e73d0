#include "gnc/ardito/rocker_bogie.h"

#include <algorithm>
#include <cmath>

#include "gnc/math.h"

namespace lss::gnc::ardito {
namespace {

// About y, by an angle that lifts the front (z is down).
Point turned(const Direction& angle, const Point& p) noexcept {
  return {angle.cos * p.x_m + angle.sin * p.z_m, -angle.sin * p.x_m + angle.cos * p.z_m};
}

void place_side(const Direction& rocker, const Direction& bogie_on_it, std::size_t side,
                const Linkage& l, WheelPoses& poses) noexcept {
  const auto put = [&](std::size_t wheel, double x_m, double z_m) {
    poses.x_m[wheel] = x_m + l.pivot_x_m;
    poses.z_m[wheel] = z_m;
  };
  const Direction both = turned(rocker, bogie_on_it);
  const Point front = turned(rocker, l.front_on_rocker);
  const Point bogie = turned(rocker, l.bogie_on_rocker);
  const Point middle = turned(both, l.middle_on_bogie);
  const Point rear = turned(both, l.rear_on_bogie);
  put(side, front.x_m, front.z_m);
  put(side + 2, bogie.x_m + middle.x_m, bogie.z_m + middle.z_m);
  put(side + 4, bogie.x_m + rear.x_m, bogie.z_m + rear.z_m);
}

double squared(double x) noexcept { return x * x; }

}  // namespace

Linkage linkage(const Geometry& g) noexcept {
  return {
      .pivot_x_m = -g.f_m,
      // E2
      .front_on_rocker = {g.l1_m * math::cos(g.k1_rad), g.l6_m + g.l1_m * math::sin(g.k1_rad)},
      .bogie_on_rocker = {-g.l2_m, g.l3_m},
      // E3
      .middle_on_bogie = {g.l4_m * math::cos(g.k3_rad), g.l4_m * math::sin(g.k3_rad)},
      .rear_on_bogie = {-g.l5_m, g.l6_m},
  };
}

WheelPoses wheel_poses(const RockerAngles& angles, const Linkage& linkage) noexcept {
  WheelPoses poses;
  const Direction left = direction(angles.beta_rad);
  place_side(left, direction(angles.rho1_rad), 0, linkage, poses);
  place_side(opposite(left), direction(angles.rho2_rad), 1, linkage, poses);
  return poses;
}

double rim_speed_m_s(double plane_m_s, const Direction& steering, double vx_m_s, double vz_m_s,
                     double sign) noexcept {
  if (plane_m_s == 0) return 0;
  const double x = plane_m_s * steering.cos + sign * vx_m_s;
  const double y = plane_m_s * steering.sin;
  return std::copysign(std::sqrt(squared(x) + squared(y) + squared(vz_m_s)), plane_m_s);
}

double plane_speed_m_s(double rim_m_s, const Direction& steering, double vx_m_s, double vz_m_s,
                       double sign) noexcept {
  if (rim_m_s == 0) return 0;
  const double along = squared(rim_m_s) - squared(vz_m_s) - squared(steering.sin * vx_m_s);
  return -sign * steering.cos * vx_m_s + std::copysign(std::sqrt(std::max(along, 0.0)), rim_m_s);
}

}  // namespace lss::gnc::ardito
