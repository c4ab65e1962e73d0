#include "gnc/talaris/contact.h"

#include <algorithm>
#include <cmath>

namespace lss::gnc::talaris {
namespace {

constexpr std::int64_t kTogether_ns = 25'000'000;  // of five samples: none is missing

}  // namespace

// The rates before and after a step of them, two samples each and one between: one wrong sample
// makes none.
bool Contact::jolts() const noexcept {
  if (turns_.back().time_ns - turns_.front().time_ns > kTogether_ns) return false;
  for (const std::size_t before : {0u, 1u}) {
    for (const std::size_t after : {3u, 4u}) {
      const double turned = (turns_[after].rate_rad_s - turns_[before].rate_rad_s).norm();
      if (!(turned > parameters_.jolt_rad_s)) return false;
    }
  }
  return true;
}

void Contact::step(const Batch& batch, double lift_m_s2) noexcept {
  if (shock_frames_ > 0) --shock_frames_;
  jolted_ = false;
  for (const ImuSample& s : batch.imu) {
    std::rotate(turns_.begin(), turns_.begin() + 1, turns_.end());
    turns_.back() = {s.time_ns, s.rate_B_rad_s.tail<2>()};
    jolted_ = jolted_ || jolts();
  }
  double sum = 0, steps = 0, before = 0, pair = 0;
  int count = 0;
  for (const ImuSample& s : batch.imu) {
    const double extra = s.force_B_m_s2.x() - lift_m_s2;
    if (!std::isfinite(extra)) continue;
    if (count > 0) {
      steps += (extra - before) * (extra - before);
      // two in a row, one of them half as hard: one alone may be wrong
      pair = std::max(pair, std::min(std::max(before, extra), 2 * std::min(before, extra)));
    }
    before = extra;
    sum += extra;
    ++count;
  }
  if (count < 2) return;  // a held frame gives no information
  // From sample to sample: pulses of the valves move all samples of theirs.
  const double variance = steps / (2 * (count - 1));
  const double scatter = parameters_.shock_sigma * std::sqrt(std::max(variance_, 0.0));
  if (variance_ >= 0 && pair > std::max(parameters_.shock_m_s2, scatter)) shock_frames_ = 2;
  variance_ =
      variance_ < 0 ? variance : variance_ + parameters_.scatter_share * (variance - variance_);
  supported_ = sum / count > parameters_.support_m_s2 ? supported_ + 1 : 0;
}

}  // namespace lss::gnc::talaris
