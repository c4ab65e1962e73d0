#pragma once

// The body of a bus thread on a serial port: bytes to samples, orders to bytes, by file descriptor
// and by the driver's schedule. Opens the port and opens it again when it is lost. FIFO thread:
// nothing here allocates, locks or logs. The driver knows only bytes and time
// (drivers/zebro/leg_bus.h is one).
//
// Driver: restart(now), receive(bytes, now), transmit(now) -> bytes, next_wake(), take(replies) ->
// how many, counters(), kMaxReplies; with orders release(orders, now); for an emergency stop that
// bypasses the cycle all_stop(now), and stops_all(orders), whether no order moves anything.
// Optional: Byte, the type of received bytes (LineByte: with the marks of parity errors);
// published(), called when the replies of a turn can be popped.

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
#include <type_traits>

#include "daemon/runtime/clock.h"
#include "daemon/runtime/latest.h"
#include "daemon/runtime/ring.h"
#include "daemon/runtime/stop_latch.h"
#include "drivers/lockstep/wire.h"
#include "drivers/serial/serial_port.h"

namespace lss {

struct SerialSettings {
  std::string path;
  int baud = 115'200;
  bool half_duplex = false;
  SerialFormat::Parity parity = SerialFormat::Parity::none;
  int stop_bits = 1;

  SerialFormat format() const {
    return {.baud = baud, .parity = parity, .stop_bits = stop_bits, .half_duplex = half_duplex};
  }
};

// Start-up: an absent port is waited for; an error of the configuration is reported with its
// remedy.
inline tl::expected<void, std::string> check_port(const SerialSettings& settings,
                                                  SerialPort::Status status) {
  if (status == SerialPort::Status::ok || status == SerialPort::Status::absent) return {};
  return tl::unexpected(fmt::format("port {}: {}", settings.path, text(status)));
}

// Of a line that only listens, or polls by itself.
struct NoOrders {};

// Received bytes for a driver: plain, or with the marks of parity errors.
template <class Driver>
struct ByteOf {
  using Type = std::uint8_t;
};
template <class Driver>
requires requires { typename Driver::Byte; }
struct ByteOf<Driver> {
  using Type = typename Driver::Byte;
};

template <class Driver, class Parameters, class Orders, class Reply, class Counters>
class SerialBus {
 public:
  struct Report {
    Counters counters{};
    TimeNs time_ns = 0;  // when the thread wrote this
    bool open = false;
    bool was_open = false;          // ever
    bool all_stop_pending = false;  // obeyed; the cycle has not confirmed it yet
  };

  SerialBus(const Parameters& parameters, const SerialSettings& settings)
      : driver_(parameters),
        settings_(settings),
        wake_fd_(::eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC)) {}
  ~SerialBus() { ::close(wake_fd_); }
  SerialBus(const SerialBus&) = delete;
  SerialBus& operator=(const SerialBus&) = delete;

  // Start-up: opens the port once, closes it and returns the status.
  SerialPort::Status probe() {
    const SerialPort::Status status = port_.open(settings_.path.c_str(), settings_.format());
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

  // Frame thread: the oldest reply stamped before `end`.
  bool pop(Reply& reply, TimeNs end) noexcept {
    return replies_.pop_if(reply, [end](const Reply& r) { return r.time_ns < end; });
  }
  const Report& report() noexcept { return report_.get(); }
  std::uint64_t dropped() const noexcept { return replies_.dropped(); }
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
        if constexpr (requires { driver_.all_stop(now); }) {
          latch_.obey(driver_, orders_.update() ? &orders_.value() : nullptr, now);
        } else if constexpr (!std::is_same_v<Orders, NoOrders>) {
          if (orders_.update()) driver_.release(orders_.value(), now);
        }
        serve(readable, now);
      }
      if (now - reported_.time_ns >= kReportEvery || reported_.open != port_.is_open()) report(now);
      turns_.fetch_add(1, std::memory_order_relaxed);
    }
    port_.close();
    wire_.close();
  }

 private:
  static constexpr TimeNs kReopenEvery = 100 * kMillisecond;
  static constexpr TimeNs kBlockedLimit = 100 * kMillisecond;
  static constexpr TimeNs kReportEvery = 5 * kMillisecond;
  static constexpr TimeNs kIdleTurn = 250 * kMillisecond;  // a thread with nothing to do is seen

  void wake() noexcept {
    if (lockstep::on()) return waiter_.wake();
    const std::uint64_t one = 1;
    [[maybe_unused]] const auto written = ::write(wake_fd_, &one, sizeof one);
  }

  void reopen(TimeNs now) noexcept {
    if (now < reopen_ns_) return;
    reopen_ns_ = now + kReopenEvery;
    if (port_.open(settings_.path.c_str(), settings_.format()) != SerialPort::Status::ok) return;
    pending_ = {};
    wire_.open(lockstep::line_name(settings_.path));
    driver_.restart(now);
    reported_.was_open = true;
  }

  // True when the port has bytes, or is gone.
  bool wait(TimeNs now) noexcept {
    // While the kernel's queue is full the driver is not called, so its wake time does not count.
    TimeNs wake_ns = !port_.is_open()   ? reopen_ns_
                     : pending_.empty() ? driver_.next_wake()
                                        : blocked_ns_ + kBlockedLimit;
    wake_ns = std::min(wake_ns, now + kIdleTurn);
    if (lockstep::on()) {
      waiter_.wait(wake_ns);
      return wire_.coming();
    }
    const short events = static_cast<short>(POLLIN | (pending_.empty() ? 0 : POLLOUT));
    std::array<pollfd, 2> fds{{{wake_fd_, POLLIN, 0}, {port_.fd(), events, 0}}};
    const timespec timeout = to_timespec(wake_ns > now ? wake_ns - now : 0);
    ::ppoll(fds.data(), fds.size(), &timeout, nullptr);
    if (fds[0].revents) {
      std::uint64_t count = 0;
      [[maybe_unused]] const auto got = ::read(wake_fd_, &count, sizeof count);
    }
    return (fds[1].revents & ~POLLOUT) != 0;
  }

  // Bytes in, bytes out, replies up.
  void serve(bool readable, TimeNs now) noexcept {
    std::array<typename ByteOf<Driver>::Type, 512> bytes;
    while (readable) {
      const SerialPort::Transfer in = port_.read(bytes);
      if (in.lost) return lost();
      driver_.receive(std::span(bytes.data(), in.bytes), now);
      wire_.took(in.bytes);
      readable = in.bytes == bytes.size() || wire_.awaits(port_.fd());  // else poll reports
    }
    for (;;) {
      if (pending_.empty()) {
        pending_ = driver_.transmit(now);
        blocked_ns_ = now;
      }
      if (pending_.empty()) break;
      const SerialPort::Transfer out = port_.write(pending_);
      if (out.lost) return lost();
      wire_.sent(out.bytes);
      pending_ = pending_.subspan(out.bytes);
      if (!pending_.empty()) break;  // the kernel's queue is full: wait for poll
    }
    // The bytes are not taken, for example by a stopped USB adapter: reopen rather than send stale
    // bytes.
    if (!pending_.empty() && now - blocked_ns_ >= kBlockedLimit) return lost();
    std::array<Reply, Driver::kMaxReplies> replies;
    const std::size_t count = driver_.take(replies);
    for (std::size_t i = 0; i < count; ++i) replies_.push(replies[i]);
    if constexpr (requires { driver_.published(); }) driver_.published();
  }

  void lost() noexcept {
    port_.close();
    wire_.close();
    pending_ = {};
    reopen_ns_ = 0;
  }

  void report(TimeNs now) noexcept {
    reported_.counters = driver_.counters();
    reported_.time_ns = now;
    reported_.open = port_.is_open();
    reported_.all_stop_pending = latch_.pending();
    report_.put(reported_);
  }

  Driver driver_;
  SerialSettings settings_;
  SerialPort port_;
  int wake_fd_;
  lockstep::Waiter waiter_;  // in simulated time
  lockstep::Wire wire_{lockstep::Wire::Side::daemon};
  std::span<const std::uint8_t> pending_;
  TimeNs reopen_ns_ = 0;
  TimeNs blocked_ns_ = 0;  // since when pending_ waits
  Report reported_{};
  std::atomic<std::uint64_t> turns_{0};
  std::atomic<bool> stop_{false};

  StopLatch latch_;
  Latest<Orders> orders_;
  Latest<Report> report_;
  Ring<Reply, 256> replies_;
};

}  // namespace lss
