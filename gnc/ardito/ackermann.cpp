#include "gnc/ardito/ackermann.h"

#include <cmath>

namespace lss::gnc::ardito {
namespace {

// Seen from the middle of the middle axle.
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
  return std::copysign(std::hypot(r.across_m, r.along_m), r.across_m);
}

}  // namespace

Direction direction(double sigma_rad) noexcept {
  return {std::sin(sigma_rad), std::cos(sigma_rad)};
}

double sigma_rad(const Direction& direction) noexcept {
  const bool backward = direction.cos < 0 || (direction.cos == 0 && direction.sin < 0);
  return backward ? std::atan2(-direction.sin, -direction.cos)
                  : std::atan2(direction.sin, direction.cos);
}

double yaw_rate_rad_s(const PlaneMotion& motion, const Geometry& geometry) noexcept {
  return motion.v_m_s * motion.direction.sin / geometry.f_m;
}

PerWheel<double> steering_angles_rad(const Direction& direction,
                                     const Geometry& geometry) noexcept {
  PerWheel<double> angles{};
  for (const std::size_t i : kWheelOfSteered) {
    const Radius r = radius(i, direction, geometry);
    // -pi/2..pi/2: a wheel that would turn further rolls backward instead
    if (r.along_m != 0) angles[i] = std::atan(-r.along_m / r.across_m);
  }
  return angles;
}

PerWheel<double> hub_speeds_m_s(const PlaneMotion& motion, const Geometry& geometry) noexcept {
  PerWheel<double> speeds{};
  for (std::size_t i = 0; i < kWheels; ++i) {
    const Radius r = radius(i, motion.direction, geometry);
    speeds[i] = motion.v_m_s * signed_length(r) / geometry.f_m;
  }
  return speeds;
}

PlaneWheels ackermann(const PlaneMotion& motion, const Geometry& geometry) noexcept {
  return {steering_angles_rad(motion.direction, geometry), hub_speeds_m_s(motion, geometry)};
}

Direction direction_from_steering(std::size_t wheel, double steering_rad,
                                  const Geometry& geometry) noexcept {
  // tan(alpha) (f cos + left sin) = -ahead sin, solved for (sin, cos)
  const Place p = place(wheel, geometry);
  const double s = geometry.f_m * std::sin(steering_rad);
  const double c = -p.ahead_m * std::cos(steering_rad) - p.left_m * std::sin(steering_rad);
  const double length = std::hypot(s, c);
  if (!(length > 0)) return {};
  const double sign = c < 0 || (c == 0 && s < 0) ? -1 : 1;
  return {sign * s / length, sign * c / length};
}

double hub_ratio(std::size_t wheel, const Direction& direction, const Geometry& geometry) noexcept {
  return signed_length(radius(wheel, direction, geometry)) / geometry.f_m;
}

double v_from_hub_m_s(std::size_t wheel, double hub_m_s, const Direction& direction,
                      const Geometry& geometry) noexcept {
  const double ratio = hub_ratio(wheel, direction, geometry);
  return std::abs(ratio) < 1e-5 ? 0 : hub_m_s / ratio;
}

}  // namespace lss::gnc::ardito
