#include "gnc/talaris/lateral.h"

#include <algorithm>
#include <cmath>

#include "gnc/talaris/pwm.h"

namespace lss::gnc::talaris {
namespace {
constexpr double kTooMuchCarry = 0.75;  // of the clamp: then pushing does not wait for roll
constexpr double kRollRoom_s = 0.03;    // of the longest pulse: turned, it would push along y
}  // namespace

double tilt_for_y(double y_m, double y_rate_m_s, const Gains& g, double push_m_s2) noexcept {
  const double wn = g.lateral_wn_rad_s;
  const double a = -wn * wn * y_m - 2 * g.lateral_zeta * wn * y_rate_m_s - push_m_s2;
  if (!std::isfinite(a)) return 0;
  return std::clamp(a / kGravity_m_s2, -g.lateral_max_tilt_rad, g.lateral_max_tilt_rad);
}

std::array<double, 4> SideJets::step(double force_N, double roll_acceleration_rad_s2,
                                     const RollFire& fire, const Body& body, const Thrusters& t,
                                     const Gains& g) noexcept {
  std::array<double, 4> on{};
  if (std::isfinite(force_N)) carry_N_s_ += force_N * kFrame_s;
  carry_N_s_ = std::clamp(carry_N_s_, -2 * t.force_N * t.max_on_s - g.lateral_carry_N_s,
                          2 * t.force_N * t.max_on_s + g.lateral_carry_N_s);

  const double asked = std::abs(carry_N_s_) / (2 * t.force_N);
  double d =
      kFrame_s * body.inertia_x_kg_m2 * roll_acceleration_rad_s2 / (2 * t.force_N * t.side_y_m);
  if (!std::isfinite(d)) d = 0;
  // room for half of what roll asks for: with less, roll would go first
  const double mean = std::min(asked, t.max_on_s - std::min(std::abs(d) / 2, kRollRoom_s));
  const double room = std::min(mean - t.min_on_s, t.max_on_s - mean);
  constexpr double kRounding_s = 1e-9;  // where the room is that half, it is not less
  const bool roll_first = fire.on_s != 0 && room + kRounding_s < std::abs(d) / 2 &&
                          std::abs(carry_N_s_) < kTooMuchCarry * g.lateral_carry_N_s;
  const int push = carry_N_s_ > 0 ? 1 : -1;
  if (mean >= t.min_on_s && !roll_first) {
    d = std::clamp(d, -room, room);
    for (std::size_t i = 0; i < 4; ++i) {
      if (kSidePush[i] == push) {
        on[i] = std::clamp(mean + kSideY[i] * kSidePush[i] * d, t.min_on_s, t.max_on_s);
        carry_N_s_ -= push * t.force_N * on[i];
      }
    }
  } else if (fire.on_s != 0) {
    const int sign = fire.on_s > 0 ? 1 : -1;
    for (std::size_t i = 0; i < 4; ++i) {
      // a single one is the one that pushes in the direction of the carry
      if (kSideY[i] * kSidePush[i] == sign && (fire.couple || kSidePush[i] == push)) {
        on[i] = std::abs(fire.on_s);
        carry_N_s_ -= kSidePush[i] * t.force_N * on[i];
      }
    }
  }
  carry_N_s_ = std::clamp(carry_N_s_, -g.lateral_carry_N_s, g.lateral_carry_N_s);
  return on;
}

}  // namespace lss::gnc::talaris
