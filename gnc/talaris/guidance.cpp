#include "gnc/talaris/guidance.h"

#include <algorithm>

namespace lss::gnc::talaris {

Coefficients e_guidance(const Vector3& position_m, const Vector3& velocity_m_s,
                        const Target& target, double time_to_go_s) noexcept {
  const double T = time_to_go_s;
  const Vector3 dr = target.position_m - position_m - velocity_m_s * T;
  const Vector3 dv = target.velocity_m_s - velocity_m_s;
  Coefficients c;
  c.c0_m_s2 = 6 * dr / (T * T) - 2 * dv / T;
  c.c1_m_s3 = -12 * dr / (T * T * T) + 6 * dv / (T * T);
  return c;
}

void Guidance::aim(const Target& target) noexcept {
  target_ = target;
  left_s_ = target.time_to_go_s;
  anew_ = true;
}

Vector3 Guidance::step(const Vector3& position_m, const Vector3& velocity_m_s,
                       double ahead_s) noexcept {
  const bool near = left_s_ < kMinTimeToGo_s;
  if (anew_ || near || since_s_ >= kGuidancePeriod_s - kFrame_s / 2) {
    // with T frozen the target moves on at its own speed, else it would never be overtaken
    Target target = target_;
    const double T = std::max(left_s_, kMinTimeToGo_s);
    target.position_m += target.velocity_m_s * (T - left_s_);
    now_ = e_guidance(position_m, velocity_m_s, target, T);
    since_s_ = 0;
    anew_ = false;
  }
  const Vector3 acceleration = now_.c0_m_s2 + now_.c1_m_s3 * (since_s_ + ahead_s);
  since_s_ += kFrame_s;
  left_s_ -= kFrame_s;
  return acceleration;
}

Vector3 gas_force_N(const Vector3& acceleration_m_s2, double mass_kg,
                    const Vector3& fan_force_N) noexcept {
  return mass_kg * (acceleration_m_s2 + Vector3(kGravity_m_s2, 0, 0)) - fan_force_N;
}

}  // namespace lss::gnc::talaris
