#include "gnc/zebro/leg.h"

#include <algorithm>
#include <cmath>

#include "gnc/math.h"

namespace lss::gnc::zebro {

namespace {
constexpr double kStepOnTheSpot = 0.05;  // share of full speed below which a side only steps
}

double wrap_rad(double angle_rad) noexcept {
  const double wrapped_rad = std::remainder(angle_rad, 2 * kPi);
  return wrapped_rad <= -kPi ? kPi : wrapped_rad;
}

double hip_height_m(double theta_rad, double diameter_m) noexcept {
  return theta_rad >= 0 ? diameter_m / 2 * (1 + math::cos(theta_rad))
                        : diameter_m * math::cos(theta_rad);
}

double contact_offset_m(double theta_rad, double diameter_m) noexcept {
  return (theta_rad >= 0 ? diameter_m / 2 : diameter_m) * math::sin(theta_rad);
}

double advance_m(double theta_rad, double diameter_m) noexcept {
  return theta_rad >= 0 ? -diameter_m / 2 * (theta_rad + math::sin(theta_rad))
                        : -diameter_m * math::sin(theta_rad);
}

double lowered_rad(double height_m, double diameter_m) noexcept {
  return math::acos(2 * height_m / diameter_m - 1);
}

double stride_m(double sweep_rad, double diameter_m) noexcept {
  return advance_m(-sweep_rad / 2, diameter_m) - advance_m(sweep_rad / 2, diameter_m);
}

double sweep_for_stride_rad(double stride_wanted_m, double diameter_m) noexcept {
  // The derivative at 0 is the stride per radian of a straight leg: a start below the root, from
  // which Newton on a concave function converges from one side after its first step.
  double sweep_rad = stride_wanted_m / diameter_m;
  for (int i = 0; i < 20; ++i) {
    const double half_rad = sweep_rad / 2;
    const double slope_m =
        (hip_height_m(half_rad, diameter_m) + hip_height_m(-half_rad, diameter_m)) / 2;
    const double step_rad = (stride_m(sweep_rad, diameter_m) - stride_wanted_m) / slope_m;
    sweep_rad -= step_rad;
    if (std::abs(step_rad) < 1e-14) break;
  }
  return sweep_rad;
}

SideSpeeds side_speeds(double direction, double heading_rad) noexcept {
  const double ahead = math::cos(heading_rad);
  const double turn = math::sin(heading_rad);
  const double left = ahead + turn;
  const double right = ahead - turn;
  const double scale =
      std::copysign(1.0, direction) / std::max({1.0, std::abs(left), std::abs(right)});
  return {left * scale, right * scale};
}

double half_sweep_rad(double side_speed, double full_sweep_rad, double diameter_m) noexcept {
  const double share = std::abs(side_speed);
  if (share < kStepOnTheSpot) return 0;
  const double sweep_rad =
      sweep_for_stride_rad(share * stride_m(full_sweep_rad, diameter_m), diameter_m);
  return std::copysign(sweep_rad / 2, side_speed);
}

double fall_rad(double from_rad, double to_rad) noexcept {
  const double fall = std::fmod(from_rad - to_rad, 2 * kPi);
  return fall < 0 ? fall + 2 * kPi : fall;
}

double lift_rad(double from_rad, double to_rad) noexcept {
  return from_rad >= 0 && from_rad < to_rad ? to_rad - from_rad : -fall_rad(from_rad, to_rad);
}

double travel_through_top_rad(double from_rad, double to_rad, bool forward) noexcept {
  const double direct_rad = wrap_rad(to_rad - from_rad);
  constexpr double kSame_rad = 1e-6;
  const bool falls = std::abs(direct_rad) < kSame_rad ? forward : direct_rad > 0;
  return falls ? direct_rad - 2 * kPi : direct_rad + 2 * kPi;
}

}  // namespace lss::gnc::zebro
