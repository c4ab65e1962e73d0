#pragma once

// When lss/status is sent. It is large, and at rest the same again is no news: then clients know by
// the heartbeats of the daemon that it lives. Publish thread; time is data.

#include "daemon/cycle/messages.h"

namespace lss {

class StatusPace {
 public:
  static constexpr TimeNs kEvery = kSecond;
  static constexpr TimeNs kAtRest = 8 * kSecond;  // in Idle

  // Asked every kEvery with the newest report, and at once after an event. `asked`: since the last
  // call there was an event, or somebody spoke to the vehicle or got an answer of it.
  bool is_due(const StatusReport& report, bool asked) noexcept {
    const bool may_wait = report.state == State::idle && !report.simulated_time && !asked;
    if (may_wait && report.time_ns - sent_.time_ns < kAtRest && is_same(report)) return false;
    sent_ = report;
    return true;
  }

 private:
  // But for clocks, and for what a busy machine drops of telemetry.
  bool is_same(StatusReport report) const noexcept {
    report.time_ns = sent_.time_ns;
    report.frame_index = sent_.frame_index;
    report.obc_age_ms = sent_.obc_age_ms;
    report.telemetry_dropped = sent_.telemetry_dropped;
    return report == sent_;
  }

  StatusReport sent_{.time_ns = -kAtRest};
};

}  // namespace lss
