#pragma once

// An all-stop that does not wait for the next frame. Whoever takes the request asks here; the
// actuate thread obeys by itself, and from then on orders of the cycle do not pass until it has
// confirmed: with orders that stop everything, computed after the request. Wait-free.

#include <atomic>

#include "drivers/time.h"

namespace lss {

class StopLatch {
 public:
  // Any thread.
  void ask(TimeNs now) noexcept { asked_ns_.store(now, std::memory_order_release); }

  // Actuate thread. True once for every request: stop everything, now.
  bool fell() noexcept {
    const TimeNs asked_ns = asked_ns_.load(std::memory_order_acquire);
    if (asked_ns == obeyed_ns_) return false;
    obeyed_ns_ = asked_ns;
    pending_ = true;
    return true;
  }
  // Actuate thread. Whether orders may be obeyed that were computed from `boundary_ns` on.
  bool passes(bool stops_all, TimeNs boundary_ns) noexcept {
    if (stops_all && boundary_ns > obeyed_ns_) pending_ = false;
    return stops_all || !pending_;
  }
  bool pending() const noexcept { return pending_; }  // not confirmed yet

 private:
  std::atomic<TimeNs> asked_ns_{0};
  TimeNs obeyed_ns_ = 0;
  bool pending_ = false;
};

}  // namespace lss
