#pragma once

// A serial port for a bus thread (bus_thread.h). The driver knows only bytes and time
// (drivers/zebro/leg_bus.h is one): besides what the thread asks of it, receive(bytes, now),
// transmit(now) -> bytes, counters() with overflows, kMaxReplies. Optional: Byte, the type of
// received bytes (LineByte: with the marks of parity errors).

#include <fmt/format.h>

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <tl/expected.hpp>

#include "daemon/runtime/bus_thread.h"
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

// Of the driver's counters, which may be a part of its status.
template <class Counters>
std::uint64_t& overflows_of(Counters& counters) noexcept {
  if constexpr (requires { counters.overflows; }) {
    return counters.overflows;
  } else {
    return counters.counters.overflows;
  }
}

template <class BusDriver, class Parameters, class BusOrders, class Reply, class Counters>
class SerialLine {
 public:
  using Driver = BusDriver;
  using Orders = BusOrders;
  using Sample = Reply;
  struct Report {
    Counters counters{};
    TimeNs time_ns = 0;  // when the thread wrote this
    bool open = false;
    bool was_open = false;          // ever
    bool all_stop_pending = false;  // obeyed; the cycle has not confirmed it yet
  };
  static constexpr std::size_t kMaxSamples = Driver::kMaxReplies;

  SerialLine(const Parameters& parameters, const SerialSettings& settings)
      : driver_(parameters), settings_(settings) {}

  // Start-up: opens the port once. An absent port is waited for; an error of the configuration is
  // reported with its remedy.
  tl::expected<void, std::string> probe() {
    const SerialPort::Status status = open();
    close();
    if (status == SerialPort::Status::ok || status == SerialPort::Status::absent) return {};
    return tl::unexpected(fmt::format("port {}: {}", settings_.path, text(status)));
  }

  Driver& driver() noexcept { return driver_; }
  SerialPort::Status open() noexcept {
    return port_.open(settings_.path.c_str(), settings_.format());
  }
  void begin() { wire_.open(lockstep::line_name(settings_.path)); }
  void close() noexcept {
    port_.close();
    wire_.close();
    pending_ = {};
    more_ = false;
  }
  bool is_open() const noexcept { return port_.is_open(); }
  int fd() const noexcept { return port_.fd(); }
  short events() const noexcept {
    return static_cast<short>(POLLIN | (pending_.empty() ? 0 : POLLOUT));
  }
  // While the kernel's queue is full the driver is not called, so its wake time does not count.
  TimeNs next_wake() const noexcept {
    if (more_) return 0;
    return pending_.empty() ? driver_.next_wake() : blocked_ns_ + kBlockedLimit;
  }
  bool coming() noexcept { return wire_.coming(); }

  bool serve(bool readable, TimeNs now) noexcept {
    std::array<typename ByteOf<Driver>::Type, 512> bytes;
    more_ = more_ || readable;  // bounded: a flood must not delay the orders
    for (std::size_t taken = 0; more_ && taken < kMostBytes;) {
      const SerialPort::Transfer in = port_.read(bytes);
      if (in.lost) return false;
      driver_.receive(std::span(bytes.data(), in.bytes), now);
      wire_.took(in.bytes);
      taken += in.bytes;
      more_ = in.bytes == bytes.size() || wire_.awaits(port_.fd());  // else poll reports
    }
    for (;;) {
      if (pending_.empty()) {
        pending_ = driver_.transmit(now);
        blocked_ns_ = now;
      }
      if (pending_.empty()) return true;
      const SerialPort::Transfer out = port_.write(pending_);
      if (out.lost) return false;
      wire_.sent(out.bytes);
      pending_ = pending_.subspan(out.bytes);
      if (!pending_.empty()) break;  // the kernel's queue is full: wait for poll
    }
    // The bytes are not taken, for example by a stopped USB adapter: reopen rather than send stale
    // bytes.
    return now - blocked_ns_ < kBlockedLimit;
  }

  void describe(Report& report, std::uint64_t dropped) noexcept {
    report.counters = driver_.counters();
    overflows_of(report.counters) += dropped;
  }

 private:
  static constexpr TimeNs kBlockedLimit = 100 * kMillisecond;
  static constexpr std::size_t kMostBytes = 2048;  // in one turn: 20 ms of a line of 1 Mbaud

  Driver driver_;
  SerialSettings settings_;
  SerialPort port_;
  lockstep::Wire wire_{lockstep::Wire::Side::daemon};
  std::span<const std::uint8_t> pending_;
  TimeNs blocked_ns_ = 0;  // since when pending_ waits
  bool more_ = false;      // bytes were left
};

template <class Driver, class Parameters, class Orders, class Reply, class Counters>
using SerialBus = BusThread<SerialLine<Driver, Parameters, Orders, Reply, Counters>>;

}  // namespace lss
