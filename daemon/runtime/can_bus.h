#pragma once

// The body of a bus thread on a CAN bus: frames to samples, orders to frames, by file descriptor
// and by the driver's schedule. Opens the port and opens it again when it is lost. FIFO thread:
// nothing here allocates, locks or logs. The driver knows only frames and time
// (drivers/ardito/rover_bus.h is one).
//
// Driver: restart(now), release(orders, now), receive(frames), transmit(now, frame) -> bool,
// next_wake(), take(samples) -> how many, status(), kMaxSamples. For an emergency stop that
// bypasses the cycle: all_stop(now), and stops_all(orders), whether no order moves anything.

#include <fmt/format.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cstdint>
#include <span>
#include <string>
#include <tl/expected.hpp>

#include "daemon/runtime/clock.h"
#include "daemon/runtime/latest.h"
#include "daemon/runtime/ring.h"
#include "daemon/runtime/stop_latch.h"
#include "drivers/can/can_port.h"

namespace lss {

// Start-up: an absent interface is waited for; an error of the configuration is reported with its
// remedy.
inline tl::expected<void, std::string> check_can(const std::string& path, CanStatus status) {
  if (status == CanStatus::ok || status == CanStatus::absent || status == CanStatus::down)
    return {};
  return tl::unexpected(fmt::format("port {}: {}", path, text(status)));
}

template <class Driver, class Parameters, class Orders, class Sample, class Status>
class CanBus {
 public:
  struct Report {
    Status status{};
    CanCounters port{};
    CanState state = CanState::active;
    TimeNs time_ns = 0;  // when the thread wrote this
    bool open = false;
    bool was_open = false;          // ever
    bool all_stop_pending = false;  // obeyed; the cycle has not confirmed it yet
  };

  CanBus(const Parameters& parameters, std::string path, std::span<const CanFilter> filters)
      : driver_(parameters),
        path_(std::move(path)),
        filters_(filters),
        wake_fd_(::eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC)) {}
  ~CanBus() { ::close(wake_fd_); }
  CanBus(const CanBus&) = delete;
  CanBus& operator=(const CanBus&) = delete;

  // Before the thread runs: lets a second thread send on the bus.
  void attach(CanSender& sender) noexcept { port_.attach(&sender); }

  // Start-up: opens the port once, closes it and returns the status.
  CanStatus probe() {
    const CanStatus status = port_.open(path_.c_str(), filters_);
    port_.close();
    return status;
  }

  // Actuate thread: new orders; wakes the bus.
  void release(const Orders& orders) noexcept {
    orders_.put(orders);
    wake();
  }

  // Any thread, never waits: the bus stops everything at once. Orders pass again when the cycle has
  // stopped everything, too.
  void all_stop() noexcept {
    latch_.ask(now_ns());
    wake();
  }

  // Frame thread: the oldest sample stamped before `end`.
  bool pop(Sample& sample, TimeNs end) noexcept {
    return samples_.pop_if(sample, [end](const Sample& s) { return s.time_ns < end; });
  }
  const Report& report() noexcept { return report_.get(); }
  std::uint64_t dropped() const noexcept { return samples_.dropped(); }
  std::uint64_t turns() const noexcept { return turns_.load(std::memory_order_relaxed); }

  void stop() noexcept {
    stop_.store(true, std::memory_order_relaxed);
    wake();
  }

  // Bus thread.
  void run() noexcept {
    while (!stop_.load(std::memory_order_relaxed)) {
      TimeNs now = now_ns();
      if (!port_.is_open()) reopen(now);
      const bool readable = wait(now);
      now = now_ns();
      if (port_.is_open()) {
        const Orders* orders = orders_.update() ? &orders_.value() : nullptr;
        if constexpr (requires { driver_.all_stop(now); }) {
          latch_.obey(driver_, orders, now);
        } else if (orders != nullptr) {
          driver_.release(*orders, now);
        }
        serve(readable, now);
      }
      if (now - reported_.time_ns >= kReportEvery || reported_.open != port_.is_open()) report(now);
      turns_.fetch_add(1, std::memory_order_relaxed);
    }
    port_.close();
  }

 private:
  static constexpr TimeNs kReopenEvery = 100 * kMillisecond;
  static constexpr TimeNs kReportEvery = 5 * kMillisecond;
  static constexpr int kMostReads = 8;

  void wake() noexcept {
    if (lockstep::on()) return waiter_.wake();
    const std::uint64_t one = 1;
    [[maybe_unused]] const auto written = ::write(wake_fd_, &one, sizeof one);
  }

  void reopen(TimeNs now) noexcept {
    if (now < reopen_ns_) return;
    reopen_ns_ = now + kReopenEvery;
    if (port_.open(path_.c_str(), filters_) != CanStatus::ok) return;
    driver_.restart(now);
    reported_.was_open = true;
  }

  // True when the port has frames, or is gone.
  bool wait(TimeNs now) noexcept {
    TimeNs wake_ns = reopen_ns_;
    if (port_.is_open()) wake_ns = std::min(driver_.next_wake(), port_.next_wake());
    if (more_) wake_ns = now;
    wake_ns = std::min(wake_ns, now + kSecond);  // to notice a stop request
    if (lockstep::on()) {
      waiter_.wait(wake_ns);
      return port_.coming() || more_;
    }
    std::array<pollfd, 2> fds{{{wake_fd_, POLLIN, 0}, {port_.fd(), POLLIN, 0}}};
    const timespec timeout = to_timespec(wake_ns > now ? wake_ns - now : 0);
    ::ppoll(fds.data(), fds.size(), &timeout, nullptr);
    if (fds[0].revents) {
      std::uint64_t count = 0;
      [[maybe_unused]] const auto got = ::read(wake_fd_, &count, sizeof count);
    }
    return fds[1].revents != 0 || more_;
  }

  // Frames in, frames out, samples up.
  void serve(bool readable, TimeNs now) noexcept {
    more_ = readable;  // bounded: a flood must not delay the orders
    for (int reads = 0; more_ && reads < kMostReads; ++reads) {
      const CanPort::Received in = port_.receive(frames_);
      if (in.lost) return lost();
      driver_.receive(std::span(frames_).first(in.frames));
      more_ = in.more;
    }
    // Back from bus-off: any node may have missed any message.
    if (port_.counters().restarts != restarts_) {
      restarts_ = port_.counters().restarts;
      driver_.restart(now);
    }
    for (CanFrame frame; driver_.transmit(now, frame);) port_.send(frame, now);
    if (!port_.flush(now)) return lost();
    const std::size_t count = driver_.take(taken_);
    for (std::size_t i = 0; i < count; ++i) samples_.push(taken_[i]);
  }

  void lost() noexcept {
    port_.close();
    more_ = false;
    reopen_ns_ = 0;
  }

  void report(TimeNs now) noexcept {
    reported_.status = driver_.status();
    reported_.port = port_.counters();
    reported_.state = port_.state();
    reported_.time_ns = now;
    reported_.open = port_.is_open();
    reported_.all_stop_pending = latch_.pending();
    report_.put(reported_);
  }

  Driver driver_;
  std::string path_;
  std::span<const CanFilter> filters_;
  CanPort port_;
  int wake_fd_;
  lockstep::Waiter waiter_;  // in simulated time
  // Of one turn. Members, since they are large: initialising them takes longer than a frame.
  std::array<CanFrame, 64> frames_{};
  std::array<Sample, Driver::kMaxSamples> taken_{};
  bool more_ = false;  // frames were left, which poll may not report
  TimeNs reopen_ns_ = 0;
  std::uint64_t restarts_ = 0;
  Report reported_{};
  std::atomic<std::uint64_t> turns_{0};
  std::atomic<bool> stop_{false};

  StopLatch latch_;
  Latest<Orders> orders_;
  Latest<Report> report_;
  Ring<Sample, 256> samples_;
};

}  // namespace lss
