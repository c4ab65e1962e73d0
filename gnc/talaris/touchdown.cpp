#include "gnc/talaris/touchdown.h"

#include <algorithm>
#include <cmath>

namespace lss::gnc::talaris {

void Touchdown::step(const NavState& state, bool heard, double expected_m_s2) noexcept {
  const Quaternion turned = before_.conjugate() * state.q_NB;
  const Vector3 leant =
      state.q_NB.conjugate() * Vector3::UnitX() - before_.conjugate() * Vector3::UnitX();
  const bool known = heard && known_ && std::isfinite(expected_m_s2);
  const bool level = known && std::abs(state.acceleration_N_m_s2.x()) < parameters_.level_m_s2 &&
                     leant.norm() < parameters_.level_rad;
  const bool still = known && state.acceleration_N_m_s2.norm() < parameters_.still_m_s2 &&
                     2 * turned.vec().norm() < parameters_.still_rad;
  before_ = state.q_NB;
  known_ = heard;
  still_s_ = still ? still_s_ + kFrame_s : 0;
  if (!level) {
    level_s_ = lost_s_ = 0;
    return;
  }
  const double carried_m_s2 = state.acceleration_N_m_s2.x() - expected_m_s2;
  least_m_s2_ = level_s_ > 0 ? std::min(least_m_s2_, carried_m_s2) : carried_m_s2;
  lost_s_ = carried_m_s2 - least_m_s2_ >= parameters_.support_m_s2 ? lost_s_ + kFrame_s : 0;
  level_s_ += kFrame_s;
}

}  // namespace lss::gnc::talaris
