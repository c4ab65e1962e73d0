#include "tests/zebro/chain/bus_line.h"

#include <algorithm>
#include <stdexcept>

namespace lss::zebro {

using testing_support::bus_work;

namespace {

// As in daemon/runtime/serial_bus.h.
constexpr TimeNs kReopenEvery = 100 * kMillisecond;
constexpr TimeNs kReportEvery = 5 * kMillisecond;

constexpr int kMostTurnsAtOnce = 100;

}  // namespace

BusLine::BusLine(const LegBusParameters& parameters, sim::Uart& line)
    : Bus(parameters), line_(line) {}

void BusLine::plug(bool plugged, TimeNs now) {
  plugged_ = plugged;
  if (plugged) return;  // the next try will find it
  line_.forget();
  open_ = false;
  reopen_ns_ = now;
  tell(now);
}

TimeNs BusLine::next_wake() const {
  return std::max(open_ ? driver_.next_wake() : reopen_ns_, turned_ns_);
}

void BusLine::turn(TimeNs now, std::span<const std::uint8_t> bytes) {
  turns_at_once_ = now == turned_ns_ ? turns_at_once_ + 1 : 0;
  if (turns_at_once_ > kMostTurnsAtOnce) throw std::logic_error("the bus master never sleeps");
  turned_ns_ = now;
  const auto held = hold(now);
  if (!open_ && now >= reopen_ns_) {
    reopen_ns_ = now + kReopenEvery;
    if (plugged_) {
      open_ = true;
      driver_.restart(now);
      report_.was_open = true;
    }
  }
  if (open_) {
    obey(now);
    serve(now, bytes);
  }
  if (now - report_.time_ns >= kReportEvery || report_.open != open_) tell(now);
}

void BusLine::serve(TimeNs now, std::span<const std::uint8_t> bytes) {
  if (!bytes.empty()) bus_work([&] { driver_.receive(bytes, now); });
  // At most one frame is ahead of the wire, so the kernel's queue is never full.
  const auto next = [&] { return driver_.transmit(now); };
  for (auto out = bus_work(next); !out.empty(); out = bus_work(next)) {
    log(out, now);
    line_.from_master(out, now);
  }
  take_replies();
}

void BusLine::log(std::span<const std::uint8_t> frame, TimeNs now) {
  const TimeNs begin_ns = std::max(now, wire_free_ns_);
  wire_free_ns_ = begin_ns + frame_ns_;
  overheard_.receive(frame, now);
  const auto received = overheard_.take();
  if (!received) throw std::logic_error("the bus master wrote what is no frame");
  wire.push_back({begin_ns, wire_free_ns_, received->frame});
}

void BusLine::tell(TimeNs now) {
  bus_work([&] {
    report_.counters = driver_.counters();
    report_.time_ns = now;
    report_.open = open_;
    report_.all_stop_pending = latch_.pending();
  });
}

}  // namespace lss::zebro
