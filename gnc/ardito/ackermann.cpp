#include "gnc/ardito/ackermann.h"

#include <cmath>

#include "gnc/math.h"

namespace lss::gnc::ardito {
namespace {

// From the middle of the middle axle.
struct Place {
  double ahead_m;
  double left_m;
};

Place place(std::size_t wheel, const Geometry& g) noexcept {
  const double side = is_left(wheel) ? 0.5 : -0.5;
  if (wheel < 2) return {g.d_m, side * g.a_m};
  if (wheel < 4) return {0, side * g.b_m};
  return {-g.e_m, side * g.c_m};
}

// Curved radius of the wheel times sin(sigma) / f: its hub's speed along the steered wheel, as a
// multiple of v / f. With R = f cos / sin: R + left and ahead, both times sin.
struct Radius {
  double across_m;  // f cos + left sin
  double along_m;   // ahead sin
};

Radius radius(std::size_t wheel, const Direction& direction, const Geometry& g) noexcept {
  const Place p = place(wheel, g);
  return {g.f_m * direction.cos + p.left_m * direction.sin, p.ahead_m * direction.sin};
}

double signed_length(const Radius& r) noexcept {
  return std::copysign(std::sqrt(r.across_m * r.across_m + r.along_m * r.along_m), r.across_m);
}

}  // namespace

double sigma_rad(const Direction& direction) noexcept {
  if (direction.sin == 0) return 0;
  return direction.cos != 0 ? math::atan(direction.sin / direction.cos) : kPi / 2;
}

double yaw_rate_rad_s(const PlaneMotion& motion, const Geometry& geometry) noexcept {
  return motion.v_m_s * motion.direction.sin / geometry.f_m;
}

PerWheel<double> steering_angles_rad(const Direction& direction,
                                     const Geometry& geometry) noexcept {
  PerWheel<double> angles{};
  for (const std::size_t i : kWheelOfSteered) {
    angles[i] = steering_angle_rad(i, direction, geometry);
  }
  return angles;
}

double steering_angle_rad(std::size_t wheel, const Direction& direction,
                          const Geometry& geometry) noexcept {
  const Radius r = radius(wheel, direction, geometry);
  // -pi/2..pi/2: a wheel that would have to turn further rolls backward instead
  return r.along_m != 0 ? math::atan(-r.along_m / r.across_m) : 0;
}

PerWheel<double> hub_speeds_m_s(const PlaneMotion& motion, const Geometry& geometry) noexcept {
  PerWheel<double> speeds = hub_ratios(motion.direction, geometry);
  for (double& speed : speeds) speed *= motion.v_m_s;
  return speeds;
}

PlaneWheels ackermann(const PlaneMotion& motion, const Geometry& geometry) noexcept {
  return {steering_angles_rad(motion.direction, geometry), hub_speeds_m_s(motion, geometry)};
}

Direction direction_from_steering(std::size_t wheel, const Direction& steering,
                                  const Geometry& geometry) noexcept {
  // tan(alpha) (f cos + left sin) = -ahead sin, solved for (sin, cos)
  const Place p = place(wheel, geometry);
  const double s = geometry.f_m * steering.sin;
  const double c = -p.ahead_m * steering.cos - p.left_m * steering.sin;
  const double length = std::sqrt(s * s + c * c);
  if (!(length > 0)) return {};
  const double scale = (c < 0 || (c == 0 && s < 0) ? -1.0 : 1.0) / length;
  return {s * scale, c * scale};
}

PerWheel<double> hub_ratios(const Direction& direction, const Geometry& geometry) noexcept {
  PerWheel<double> ratios{};
  for (std::size_t i = 0; i < kWheels; ++i) ratios[i] = hub_ratio(i, direction, geometry);
  return ratios;
}

double hub_ratio(std::size_t wheel, const Direction& direction, const Geometry& geometry) noexcept {
  return signed_length(radius(wheel, direction, geometry)) / geometry.f_m;
}

double hub_speed_m_s(std::size_t wheel, const PlaneMotion& motion, const Direction& steering,
                     const Geometry& geometry) noexcept {
  const Radius r = radius(wheel, motion.direction, geometry);
  return motion.v_m_s / geometry.f_m * (r.across_m * steering.cos - r.along_m * steering.sin);
}

double v_from_hub_m_s(std::size_t wheel, double hub_m_s, const Direction& direction,
                      const Geometry& geometry) noexcept {
  const double ratio = hub_ratio(wheel, direction, geometry);
  return std::abs(ratio) < 1e-5 ? 0 : hub_m_s / ratio;
}

}  // namespace lss::gnc::ardito
