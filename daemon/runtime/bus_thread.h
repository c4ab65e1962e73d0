#pragma once

// The body of a bus thread: received bytes or frames to samples, orders to what is sent, by file
// descriptor and by the driver's schedule. Opens the line and opens it again when it is lost. FIFO
// thread: nothing here allocates, locks or logs.
//
// Line (can_bus.h, serial_bus.h): Driver, Orders, Sample, Report, kMaxSamples; driver(); probe();
// open() -> status, begin(now) after it, close(), is_open(); fd(), events(), next_wake(), coming()
// in simulated time; serve(readable, now) -> false when the port is gone; describe(report,
// samples that the thread dropped so far).
// Driver: restart(now), next_wake(), take(samples) -> how many; with orders release(orders, now).
// For an emergency stop that bypasses the cycle: all_stop(now), and stops_all(orders), whether no
// order moves anything. Optional: published(), called when the samples of a turn can be popped;
// reopened(now), instead of restart(now) when the line came back and the driver's memory is good;
// begin_again(parameters of the line, status reported last, last orders, now) when it is not.

#include <poll.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cstdint>
#include <type_traits>
#include <utility>

#include "daemon/cycle/twins.h"
#include "daemon/runtime/clock.h"
#include "daemon/runtime/latest.h"
#include "daemon/runtime/sample_queue.h"
#include "daemon/runtime/stop_latch.h"
#include "daemon/runtime/wake_up.h"
#include "drivers/lockstep/lockstep.h"

namespace lss {

// Of a line that only listens, or polls by itself.
struct NoOrders {};

// The line was opened (again), or came back from bus-off.
template <class Driver>
void came_back(Driver& driver, TimeNs now) noexcept {
  if constexpr (requires { driver.reopened(now); }) {
    driver.reopened(now);
  } else {
    driver.restart(now);
  }
}

template <class Line>
class BusThread {
 public:
  using Orders = typename Line::Orders;
  using Sample = typename Line::Sample;
  using Report = typename Line::Report;

  template <class... Arguments>
  explicit BusThread(Arguments&&... arguments) : line_(std::forward<Arguments>(arguments)...) {}
  BusThread(const BusThread&) = delete;
  BusThread& operator=(const BusThread&) = delete;

  // Before the thread runs.
  Line& line() noexcept { return line_; }
  // Start-up: whether the port can be used, or what is wrong with the configuration.
  auto probe() { return line_.probe(); }

  // Actuate thread: new orders; wakes the bus.
  void release(const Orders& orders) noexcept {
    orders_.put(orders);
    wake_up_.wake();
  }

  // Any thread, never waits: the bus stops everything at once. Orders pass again when the cycle has
  // stopped everything, too.
  void all_stop() noexcept {
    latch_.ask(now_ns());
    wake_up_.wake();
  }

  // Frame thread: the oldest sample stamped before `end`.
  bool pop(Sample& sample, TimeNs end) noexcept { return samples_.pop(sample, end); }
  const Report& report() noexcept { return report_.get(); }
  // Frame thread. Both copies of the driver's memory were damaged since the last call.
  bool take_memory_lost() noexcept {
    return memory_lost_.exchange(false, std::memory_order_relaxed);
  }
  std::uint64_t turns() const noexcept { return turns_.load(std::memory_order_relaxed); }

  void stop() noexcept {
    stop_.store(true, std::memory_order_relaxed);
    wake_up_.wake();
  }

  // Bus thread.
  void run() noexcept {
    while (!stop_.load(std::memory_order_relaxed)) {
      TimeNs now = now_ns();
      if (!line_.is_open()) reopen(now);
      twin_.seal(bytes_of(line_.driver()));
      const bool readable = wait(now);
      now = now_ns();
      if (twin_.check(bytes_of(line_.driver())) == MemoryCheck::lost) forget(now);
      if (line_.is_open()) turn(readable, now);
      if (now - reported_.time_ns >= kReportEvery || reported_.open != line_.is_open()) report(now);
      turns_.fetch_add(1, std::memory_order_relaxed);
    }
    line_.close();
  }

 private:
  static constexpr TimeNs kReopenEvery = 100 * kMillisecond;
  static constexpr TimeNs kReportEvery = 5 * kMillisecond;
  static constexpr TimeNs kIdleTurn = 250 * kMillisecond;  // a thread with nothing to do is seen

  void reopen(TimeNs now) noexcept {
    if (now < reopen_ns_) return;
    reopen_ns_ = now + kReopenEvery;
    const auto status = line_.open();
    if (status != decltype(status)::ok) return;
    line_.begin();
    came_back(line_.driver(), now);
    reported_.was_open = true;
  }

  // Nobody knows what the driver was about to do: it begins again and stops everything, which the
  // cycle notices by the all-stop of a driver that has one. TALARIS' goes on in the air.
  void forget(TimeNs now) noexcept {
    auto& driver = line_.driver();
    if constexpr (requires {
                    driver.begin_again(line_.parameters(), reported_.status, orders_.value(), now);
                  }) {
      driver.begin_again(line_.parameters(), reported_.status, orders_.value(), now);
    } else {
      driver.restart(now);
      latch_.ask(now);
    }
    memory_lost_.store(true, std::memory_order_relaxed);
  }

  // True when there is something to receive, or the port is gone.
  bool wait(TimeNs now) noexcept {
    const TimeNs wake_ns =
        std::min(line_.is_open() ? line_.next_wake() : reopen_ns_, now + kIdleTurn);
    const short events = wake_up_.wait(wake_ns, line_.fd(), line_.events());
    return lockstep::on() ? line_.coming() : (events & ~POLLOUT) != 0;
  }

  void turn(bool readable, TimeNs now) noexcept {
    auto& driver = line_.driver();
    if constexpr (!std::is_same_v<Orders, NoOrders>) {
      const Orders* orders = orders_.update() ? &orders_.value() : nullptr;
      if constexpr (requires { driver.all_stop(now); }) {
        latch_.obey(driver, orders, now);
      } else if (orders != nullptr) {
        driver.release(*orders, now);
      }
    }
    if (!line_.serve(readable, now)) {
      line_.close();
      reopen_ns_ = 0;
      return;
    }
    const std::size_t count = driver.take(taken_);
    for (std::size_t i = 0; i < count; ++i) samples_.push(taken_[i]);
    if constexpr (requires { driver.published(); }) driver.published();
  }

  void report(TimeNs now) noexcept {
    line_.describe(reported_, samples_.dropped());
    reported_.time_ns = now;
    reported_.open = line_.is_open();
    reported_.all_stop_pending = latch_.pending();
    report_.put(reported_);
  }

  Line line_;
  Twin<sizeof(typename Line::Driver)> twin_;  // of the driver, while the thread waits
  WakeUp wake_up_;
  // Of one turn. A member, since initialising it takes longer than a frame.
  std::array<Sample, Line::kMaxSamples> taken_{};
  TimeNs reopen_ns_ = 0;
  Report reported_{};
  std::atomic<std::uint64_t> turns_{0};
  std::atomic<bool> stop_{false}, memory_lost_{false};

  StopLatch latch_;
  Latest<Orders> orders_;
  Latest<Report> report_;
  SampleQueue<Sample> samples_;
};

}  // namespace lss
