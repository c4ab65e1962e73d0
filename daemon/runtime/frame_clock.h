#pragma once

// The grid of frames: frame k begins at T_k = epoch + k * period and its command is released at T_k
// + offset (TALARIS thesis 4.3 and 5.1.3). An overrun skips frames and never shifts the phase. Pure
// arithmetic.

#include <cstdint>

#include "drivers/time.h"

namespace lss {

class FrameClock {
 public:
  FrameClock(TimeNs epoch_ns, TimeNs period_ns, TimeNs offset_ns) noexcept
      : epoch_ns_(epoch_ns), period_ns_(period_ns), offset_ns_(offset_ns) {}

  TimeNs period_ns() const noexcept { return period_ns_; }
  TimeNs offset_ns() const noexcept { return offset_ns_; }
  TimeNs boundary(std::uint64_t frame) const noexcept {
    return epoch_ns_ + static_cast<TimeNs>(frame) * period_ns_;
  }
  TimeNs release(std::uint64_t frame) const noexcept { return boundary(frame) + offset_ns_; }

  // The frame to run after `frame` at time `now`: the next one, or the first whose boundary is
  // still ahead.
  std::uint64_t after(std::uint64_t frame, TimeNs now) const noexcept {
    if (now <= boundary(frame + 1)) return frame + 1;
    return static_cast<std::uint64_t>((now - epoch_ns_ + period_ns_ - 1) / period_ns_);
  }

 private:
  TimeNs epoch_ns_, period_ns_, offset_ns_;
};

// Counts commands that were not ready at their release. One is repeated; `limit` in a row are a
// fault.
class OverrunCounter {
 public:
  explicit OverrunCounter(int limit) noexcept : limit_(static_cast<std::uint64_t>(limit)) {}

  // `frames` in a row. True when the limit is reached.
  bool late(std::uint64_t frames = 1) noexcept {
    total_ += frames;
    consecutive_ += frames;
    return consecutive_ >= limit_;
  }
  void in_time() noexcept { consecutive_ = 0; }
  std::uint64_t total() const noexcept { return total_; }
  std::uint64_t consecutive() const noexcept { return consecutive_; }

 private:
  std::uint64_t limit_, consecutive_ = 0, total_ = 0;
};

}  // namespace lss
