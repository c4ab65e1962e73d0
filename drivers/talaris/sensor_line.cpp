#include "drivers/talaris/sensor_line.h"

#include <algorithm>

namespace lss::talaris {

void SensorLine::keep(const TalarisSample& sample) noexcept {
  if (count_ == kMaxSamples) {
    ++status_.counters.overflows;
    first_ = (first_ + 1) % kMaxSamples;
    --count_;
  }
  sample_[(first_ + count_++) % kMaxSamples] = sample;
}

std::size_t SensorLine::take(std::span<TalarisSample> out) noexcept {
  const std::size_t count = std::min(out.size(), count_);
  for (std::size_t i = 0; i < count; ++i) out[i] = sample_[(first_ + i) % kMaxSamples];
  first_ = (first_ + count) % kMaxSamples;
  count_ -= count;
  return count;
}

void SensorLine::tick(std::uint64_t count, TimeNs time_ns, int packets_per_frame,
                      TimeNs period_ns) noexcept {
  const auto packets = static_cast<std::uint64_t>(packets_per_frame);
  const std::uint64_t frame = count / packets;
  if (frame <= tick_.index) return;
  const auto behind = static_cast<TimeNs>(count % packets);
  tick_ = {frame, time_ns - behind * period_ns};
  ticked_ = true;
}

bool SensorLine::take_tick(FrameTick& tick) noexcept {
  if (!ticked_) return false;
  ticked_ = false;
  tick = tick_;
  return true;
}

void SensorLine::clear() noexcept {
  count_ = 0;
  ticked_ = false;
}

}  // namespace lss::talaris
