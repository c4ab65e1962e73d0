#include "gnc/talaris/contact.h"

#include <cmath>

namespace lss::gnc::talaris {

bool Contact::step(const Batch& batch, double lift_m_s2) noexcept {
  double sum = 0;
  if (shock_frames_ > 0) --shock_frames_;
  int count = 0;
  for (const ImuSample& s : batch.imu) {
    const double extra = s.force_B_m_s2.x() - lift_m_s2;
    if (!std::isfinite(extra)) continue;
    if (extra > parameters_.shock_m_s2) {
      touched_ = true;
      shock_frames_ = 2;
    }
    sum += extra;
    ++count;
  }
  if (count == 0) return touched_;  // a held frame gives no information
  supported_ = sum / count > parameters_.support_m_s2 ? supported_ + 1 : 0;
  if (supported_ >= parameters_.support_frames) touched_ = true;
  return touched_;
}

}  // namespace lss::gnc::talaris
