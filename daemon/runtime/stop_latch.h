#pragma once

// An all-stop that does not wait for the next frame. The thread that receives the request calls
// ask(); the thread that writes to the actuators obeys by itself (bus thread; actuate thread of
// TALARIS), and from then on orders of the cycle do not pass until it has confirmed: with orders
// that stop everything, computed after the request. Wait-free.

#include <atomic>

#include "drivers/time.h"

namespace lss {

class StopLatch {
 public:
  // Any thread.
  void ask(TimeNs now) noexcept { asked_ns_.store(now, std::memory_order_release); }

  // That thread. True once for every request: stop everything, now.
  bool fell() noexcept {
    const TimeNs asked_ns = asked_ns_.load(std::memory_order_acquire);
    if (asked_ns == obeyed_ns_) return false;
    obeyed_ns_ = asked_ns;
    pending_ = true;
    return true;
  }
  // That thread. Whether orders computed from `boundary_ns` on may be obeyed.
  bool passes(bool stops_all, TimeNs boundary_ns) noexcept {
    if (stops_all && boundary_ns > obeyed_ns_) pending_ = false;
    return stops_all || !pending_;
  }
  // That thread, in each turn: the stop first, then new `orders` that pass.
  template <class Driver, class Orders>
  void obey(Driver& driver, const Orders* orders, TimeNs now) noexcept {
    if (fell()) driver.all_stop(now);
    if (orders != nullptr && passes(stops_all(*orders), orders->issued_ns))
      driver.release(*orders, now);
  }
  bool pending() const noexcept { return pending_; }  // not confirmed yet

 private:
  std::atomic<TimeNs> asked_ns_{0};
  TimeNs obeyed_ns_ = 0;
  bool pending_ = false;
};

}  // namespace lss
