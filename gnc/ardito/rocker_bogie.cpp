#include "gnc/ardito/rocker_bogie.h"

#include <algorithm>
#include <cmath>

namespace lss::gnc::ardito {
namespace {

struct Point {
  double x_m;
  double z_m;
};

// About y, by an angle that lifts what is in front (z is down).
Point turned(double angle_rad, const Point& p) noexcept {
  const double s = std::sin(angle_rad), c = std::cos(angle_rad);
  return {c * p.x_m + s * p.z_m, -s * p.x_m + c * p.z_m};
}

// Front wheel on the rocker, from the rocker's pivot: E2.
Point front_on_rocker(const Geometry& g) noexcept {
  return {g.l1_m * std::cos(g.k1_rad), g.l6_m + g.l1_m * std::sin(g.k1_rad)};
}
Point bogie_on_rocker(const Geometry& g) noexcept { return {-g.l2_m, g.l3_m}; }
// Middle wheel on the bogie: E3.
Point middle_on_bogie(const Geometry& g) noexcept {
  return {g.l4_m * std::cos(g.k3_rad), g.l4_m * std::sin(g.k3_rad)};
}
Point rear_on_bogie(const Geometry& g) noexcept { return {-g.l5_m, g.l6_m}; }

void place_side(double rocker_rad, double bogie_rad, std::size_t side, const Geometry& g,
                WheelPoses& poses) noexcept {
  const auto put = [&](std::size_t wheel, const Point& p) {
    poses.x_m[wheel] = p.x_m - g.f_m;
    poses.z_m[wheel] = p.z_m;
  };
  const Point front = turned(rocker_rad, front_on_rocker(g));
  const Point bogie = turned(rocker_rad, bogie_on_rocker(g));
  const Point middle = turned(rocker_rad + bogie_rad, middle_on_bogie(g));
  const Point rear = turned(rocker_rad + bogie_rad, rear_on_bogie(g));
  put(side, front);
  put(side + 2, {bogie.x_m + middle.x_m, bogie.z_m + middle.z_m});
  put(side + 4, {bogie.x_m + rear.x_m, bogie.z_m + rear.z_m});
}

// The bogie's own angle, from where its middle wheel is: E6.
double bogie_rad(double rocker_rad, double x_m, double z_m, const Geometry& g) noexcept {
  const Point bogie = turned(rocker_rad, bogie_on_rocker(g));
  const double x = x_m + g.f_m - bogie.x_m, z = z_m - bogie.z_m;
  // the arm points k3 below the bogie's x axis; turning by an angle lifts it by as much
  return std::remainder(g.k3_rad - rocker_rad - std::atan2(z, x), 2 * kPi);
}

double squared(double x) noexcept { return x * x; }

}  // namespace

WheelPoses wheel_poses(const RockerAngles& angles, const Geometry& geometry) noexcept {
  WheelPoses poses;
  place_side(angles.beta_rad, angles.rho1_rad, 0, geometry, poses);
  place_side(-angles.beta_rad, angles.rho2_rad, 1, geometry, poses);
  return poses;
}

RockerAngles rocker_angles(const WheelPoses& poses, const Geometry& geometry) noexcept {
  // E4, E5
  const Point arm = front_on_rocker(geometry);
  const double x = poses.x_m[0] + geometry.f_m, z = poses.z_m[0];
  RockerAngles angles;
  angles.beta_rad = std::atan2(arm.z_m * x - arm.x_m * z, arm.x_m * x + arm.z_m * z);
  angles.rho1_rad = bogie_rad(angles.beta_rad, poses.x_m[2], poses.z_m[2], geometry);
  angles.rho2_rad = bogie_rad(-angles.beta_rad, poses.x_m[3], poses.z_m[3], geometry);
  return angles;
}

double rim_speed_m_s(double plane_m_s, double steering_rad, double vx_m_s, double vz_m_s,
                     double sign) noexcept {
  if (plane_m_s == 0) return 0;
  const double x = plane_m_s * std::cos(steering_rad) + sign * vx_m_s;
  const double y = plane_m_s * std::sin(steering_rad);
  return std::copysign(std::sqrt(squared(x) + squared(y) + squared(vz_m_s)), plane_m_s);
}

double plane_speed_m_s(double rim_m_s, double steering_rad, double vx_m_s, double vz_m_s,
                       double sign) noexcept {
  if (rim_m_s == 0) return 0;
  const double along =
      squared(rim_m_s) - squared(vz_m_s) - squared(std::sin(steering_rad) * vx_m_s);
  return -sign * std::cos(steering_rad) * vx_m_s +
         std::copysign(std::sqrt(std::max(along, 0.0)), rim_m_s);
}

}  // namespace lss::gnc::ardito
