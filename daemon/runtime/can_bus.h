#pragma once

// A CAN bus for a bus thread (bus_thread.h). The driver knows only frames and time
// (drivers/ardito/rover_bus.h is one): besides what the thread asks of it, receive(frames),
// transmit(now, frame) -> bool, status(), kMaxSamples.

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <tl/expected.hpp>

#include "daemon/runtime/bus_thread.h"
#include "drivers/can/can_port.h"

namespace lss {

template <class BusDriver, class Parameters, class BusOrders, class BusSample, class Status>
class CanLine {
 public:
  using Driver = BusDriver;
  using Orders = BusOrders;
  using Sample = BusSample;
  struct Report {
    Status status{};
    CanCounters port{};
    CanState state = CanState::active;
    TimeNs time_ns = 0;  // when the thread wrote this
    bool open = false;
    bool was_open = false;          // ever
    bool all_stop_pending = false;  // obeyed; the cycle has not confirmed it yet
  };
  static constexpr std::size_t kMaxSamples = Driver::kMaxSamples;

  CanLine(const Parameters& parameters, std::string path, std::span<const CanFilter> filters)
      : parameters_(parameters), driver_(parameters), path_(std::move(path)), filters_(filters) {}

  // Before the thread runs: lets a second thread send on the bus.
  void attach(CanSender& sender) noexcept { port_.attach(&sender); }

  // Start-up: opens the port once. An absent interface is waited for; an error of the configuration
  // is reported with its remedy.
  tl::expected<void, std::string> probe() {
    const CanStatus status = open();
    close();
    if (status == CanStatus::ok || status == CanStatus::absent || status == CanStatus::down)
      return {};
    return tl::unexpected(fmt::format("port {}: {}", path_, text(status)));
  }

  Driver& driver() noexcept { return driver_; }
  const Parameters& parameters() const noexcept { return parameters_; }  // of the start
  CanStatus open() noexcept { return port_.open(path_.c_str(), filters_); }
  void begin() noexcept {}
  void close() noexcept {
    port_.close();
    more_ = false;
  }
  bool is_open() const noexcept { return port_.is_open(); }
  int fd() const noexcept { return port_.fd(); }
  short events() const noexcept { return POLLIN; }
  TimeNs next_wake() const noexcept {
    return more_ ? 0 : std::min(driver_.next_wake(), port_.next_wake());
  }
  bool coming() noexcept { return port_.coming(); }

  bool serve(bool readable, TimeNs now) noexcept {
    more_ = more_ || readable;  // bounded: a flood must not delay the orders
    for (int reads = 0; more_ && reads < kMostReads; ++reads) {
      const CanPort::Received in = port_.receive(frames_);
      if (in.lost) return false;
      driver_.receive(std::span(frames_).first(in.frames));
      more_ = in.more;
    }
    // Back from bus-off: any node may have missed any message.
    if (port_.counters().restarts != restarts_) {
      restarts_ = port_.counters().restarts;
      came_back(driver_, now);
    }
    for (CanFrame frame; driver_.transmit(now, frame);) port_.send(frame, now);
    return port_.flush(now);
  }

  void describe(Report& report, std::uint64_t dropped) noexcept {
    report.status = driver_.status();
    report.port = port_.counters();
    report.port.overflows += dropped;
    report.state = port_.state();
  }

 private:
  static constexpr int kMostReads = 8;

  const Parameters parameters_;
  Driver driver_;
  std::string path_;
  std::span<const CanFilter> filters_;
  CanPort port_;
  std::array<CanFrame, 64> frames_{};  // of one turn
  bool more_ = false;                  // frames were left, which poll may not report
  std::uint64_t restarts_ = 0;
};

template <class Driver, class Parameters, class Orders, class Sample, class Status>
using CanBus = BusThread<CanLine<Driver, Parameters, Orders, Sample, Status>>;

}  // namespace lss
