#include "gnc/talaris/contact.h"

#include <algorithm>
#include <cmath>

namespace lss::gnc::talaris {

void Contact::step(const Batch& batch, double lift_m_s2) noexcept {
  if (shock_frames_ > 0) --shock_frames_;
  double sum = 0, squares = 0, most = 0;
  int count = 0;
  for (const ImuSample& s : batch.imu) {
    const double extra = s.force_B_m_s2.x() - lift_m_s2;
    if (!std::isfinite(extra)) continue;
    most = std::max(most, extra);
    sum += extra;
    squares += extra * extra;
    ++count;
  }
  if (count == 0) return;  // a held frame gives no information
  const double mean = sum / count;
  const double variance = std::max(squares / count - mean * mean, 0.0);
  const double scatter = parameters_.shock_sigma * std::sqrt(std::max(variance_, 0.0));
  if (variance_ >= 0 && most > std::max(parameters_.shock_m_s2, scatter)) shock_frames_ = 2;
  variance_ =
      variance_ < 0 ? variance : variance_ + parameters_.scatter_share * (variance - variance_);
  supported_ = mean > parameters_.support_m_s2 ? supported_ + 1 : 0;
}

}  // namespace lss::gnc::talaris
