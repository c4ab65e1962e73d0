#include "gnc/talaris/phase_plane.h"

#include <algorithm>
#include <cmath>

namespace lss::gnc::talaris {

double wanted_roll_rate(double error_rad, double acceleration_rad_s2, const Gains& g) noexcept {
  const double beyond = std::max(std::abs(error_rad) - g.roll_dead_band_rad, 0.0);
  const double rate = std::min({std::sqrt(2 * g.roll_brake_share * acceleration_rad_s2 * beyond),
                                g.roll_slope_1_s * beyond, g.roll_rate_limit_rad_s});
  return error_rad > 0 ? -rate : rate;
}

RollFire phase_plane(double error_rad, double rate_rad_s, double force_N, const Body& body,
                     const Thrusters& t, const Gains& g) noexcept {
  if (!std::isfinite(error_rad) || !std::isfinite(rate_rad_s)) return {};
  const double couple = 2 * force_N * t.side_y_m / body.inertia_x_kg_m2;
  const double single = couple / 2;
  const double change = wanted_roll_rate(error_rad, couple, g) - rate_rad_s;
  const double size = std::abs(change);
  const bool inside = std::abs(error_rad) <= g.roll_dead_band_rad;
  if (size <= (inside ? 0.6 : 0.5) * single * t.min_on_s) return {};

  RollFire fire;
  fire.couple = size >= couple * t.min_on_s;
  const double on =
      std::clamp(g.roll_share * size / (fire.couple ? couple : single), t.min_on_s, t.long_on_s);
  // between the longest pulse and the whole frame the pause would be too short for a valve
  const double fits = on > t.max_on_s && on < t.long_on_s ? t.max_on_s : on;
  fire.on_s = std::copysign(fits, change);
  return fire;
}

}  // namespace lss::gnc::talaris
