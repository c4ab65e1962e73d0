#pragma once

// Notices that the wall clock was set. Frames are not affected: their time is monotonic; UTC stamps
// in status, events and logs jump. Time is data.

#include "drivers/time.h"

namespace lss {

class ClockStep {
 public:
  static constexpr TimeNs kLimit = 100 * kMillisecond;  // NTP slews smaller differences

  // Both clocks read together. By how much the wall clock was set since the last call, 0: not.
  TimeNs look(TimeNs monotonic_ns, std::int64_t utc_ns) noexcept {
    const TimeNs difference = utc_ns - monotonic_ns;
    const TimeNs step = known_ ? difference - difference_ : 0;
    known_ = true;
    difference_ = difference;  // slewing is followed
    return step >= kLimit || step <= -kLimit ? step : 0;
  }

 private:
  bool known_ = false;
  TimeNs difference_ = 0;
};

}  // namespace lss
