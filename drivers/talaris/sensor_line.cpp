#include "drivers/talaris/sensor_line.h"

namespace lss::talaris {

SensorLine::SensorLine(const SerialFormat& format) noexcept
    : format_(format), byte_ns_(byte_time_ns(format)) {}

void SensorLine::keep(const TalarisSample& sample) noexcept {
  if (!samples_.put(sample)) ++status_.counters.overflows;
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
  samples_.clear();
  ticked_ = false;
}

}  // namespace lss::talaris
