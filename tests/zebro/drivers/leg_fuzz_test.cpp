// The bus under arbitrary bytes, orders and times, and its forbidden actions: allocate, run ahead
// of the wire, send a motion order that an emergency stop has ended.

#include <gtest/gtest.h>
#include <rapidcheck.h>
#include <rapidcheck/gtest.h>

#include "drivers/zebro/leg_bus.h"
#include "tests/support/allocations.h"
#include "tests/support/bus_time.h"

namespace lss::zebro {
namespace {

using Kind = ModuleOrder::Kind;
using Bytes = std::vector<std::uint8_t>;

// Drives a bus without modules and checks each frame that it wants to send.
class Watched {
 public:
  explicit Watched(const LegBusParameters& p)
      : parameters_(p), bus_(p), frame_ns_(frame_time_ns(p.baud, p.stop)) {
    bus_.restart(now_);
  }

  void restart() {
    end_motion();
    wire_free_ns_ = now_;  // a port just opened has nothing on its wire
    bus_.restart(now_);
  }

  void release(const BusOrders& orders) {
    if (orders.emergency_serial != orders_.emergency_serial) end_motion();
    orders_ = orders;
    bus_.release(orders_, now_);
    pump();
  }

  void receive(const Bytes& bytes) {
    bus_.receive(bytes, now_);
    pump();
  }

  void advance(TimeNs duration) {
    pump();
    testing_support::advance(bus_, now_, now_ + duration, [this] { pump(); });
  }

  const BusOrders& orders() const { return orders_; }
  TimeNs now() const { return now_; }
  const Bytes& last_reply() const { return last_reply_; }

 private:
  // Orders of these numbers are over.
  void end_motion() {
    for (std::size_t m = 0; m < kBusModules; ++m) ended_[m] = orders_.module[m].serial;
  }

  void pump() {
    for (int n = 0;; ++n) {
      RC_ASSERT(n < 4);  // the wire is full after two
      const std::uint64_t safe = bus_.counters().safe_commands;
      const auto bytes = bus_.transmit(now_);
      if (bus_.counters().safe_commands != safe) end_motion();
      if (bytes.empty()) return;
      const TimeNs start = std::max(now_, wire_free_ns_);
      RC_ASSERT(start - now_ <= frame_ns_);
      wire_free_ns_ = start + frame_ns_;
      check(bytes);
    }
  }

  void check(std::span<const std::uint8_t> bytes) {
    Receiver receiver(parameters_.check, parameters_.stop);
    receiver.receive(bytes, 0);
    const auto received = receiver.take();
    RC_ASSERT(received.has_value());
    const Frame& frame = received->frame;
    const auto code = static_cast<Code>(frame.code);
    RC_ASSERT(frame.code >= 1 && frame.code <= 7);
    RC_ASSERT(frame.address <= kBusModules);
    if (frame.address == kBroadcast) {
      RC_ASSERT(code == Code::emergency_stop);
      return;
    }
    const std::size_t m = frame.address - 1u;
    if (code == Code::request_data) {
      reply_to(frame);
    } else if (code != Code::emergency_stop) {
      RC_ASSERT(orders_.module[m].serial != ended_[m]);
      RC_ASSERT(now_ - orders_.issued_ns <= parameters_.stale_after_ns);
    }
    if (code == Code::rotate_forward || code == Code::rotate_backward) {
      RC_ASSERT(frame.data[2] != 0 || frame.data[3] != 0);
    }
  }

  void reply_to(const Frame& asked) {
    const Frame reply{asked.address, static_cast<std::uint8_t>(0x40 + asked.data[0]), {0, 1}};
    std::array<std::uint8_t, kMaxFrameCharacters> buffer{};
    const auto bytes = encode(reply, parameters_.check, parameters_.stop, buffer);
    last_reply_.assign(bytes.begin(), bytes.end());
  }

  LegBusParameters parameters_;
  LegBus bus_;
  BusOrders orders_{};
  TimeNs now_ = kSecond, frame_ns_, wire_free_ns_ = 0;
  std::array<std::uint32_t, kBusModules> ended_{};
  Bytes last_reply_;
};

BusOrders changed(BusOrders orders, TimeNs now) {
  orders.issued_ns = now - *rc::gen::element<TimeNs>(0, 0, 0, kMillisecond, kSecond);
  if (*rc::gen::inRange(0, 10) == 0) ++orders.emergency_serial;
  ModuleOrder& order = orders.module[*rc::gen::inRange<std::size_t>(0, kBusModules)];
  if (*rc::gen::inRange(0, 3) == 0) {
    order.kind = static_cast<Kind>(*rc::gen::inRange(0, 7));
    order.position_cdeg = static_cast<std::uint16_t>(*rc::gen::inRange(0, int{kTurn_cdeg}));
    order.arrive_ns = now + *rc::gen::inRange(-100, 100'000) * kMillisecond;
    ++order.serial;
  }
  return orders;
}

// [Env-2]
RC_GTEST_PROP(LegFuzz, NothingThatComesInMakesTheBusSendWhatItMustNot, ()) {
  LegBusParameters p;
  p.baud = *rc::gen::element(9'600, 115'200, 1'000'000);
  p.half_duplex = *rc::gen::arbitrary<bool>();
  p.check = *rc::gen::element(Check::lrc, Check::crc8);
  p.stop = *rc::gen::element(Stop::lf, Stop::crlf);
  p.reply_timeout_ns = *rc::gen::element<TimeNs>(0, kMillisecond, 5 * kMillisecond, kSecond);
  p.resend_limit = *rc::gen::inRange(0, 5);
  Watched bus(p);
  const int steps = *rc::gen::inRange(0, 300);
  for (int n = 0; n < steps; ++n) {
    switch (*rc::gen::inRange(0, 10)) {
      case 0: bus.receive(*rc::gen::arbitrary<Bytes>()); break;
      case 1:
      case 2: bus.receive(bus.last_reply()); break;
      case 3:
        bus.advance(*rc::gen::element<TimeNs>(1, 3 * kMillisecond, 90 * kMillisecond, 3 * kSecond));
        break;
      case 4:
        if (*rc::gen::inRange(0, 10) == 0) bus.restart();
        break;
      case 5:
      case 6: bus.advance(*rc::gen::inRange<TimeNs>(1, 20 * kMillisecond)); break;
      default: bus.release(changed(bus.orders(), bus.now()));
    }
  }
}

TEST(LegBus, AllocatesNothing) {
  std::optional<LegBus> bus;
  std::array<ModuleReply, 8> replies;
  std::array<std::uint8_t, kMaxFrameCharacters> buffer{};
  BusOrders orders;
  TimeNs now = kSecond;
  std::size_t heard = 0;
  {
    const std::uint64_t before = testing_support::allocations();
    bus.emplace(LegBusParameters{});
    bus->restart(now);
    for (int n = 0; n < 4'000; ++n, now += kMillisecond) {
      if (n % 20 == 0) {
        orders.issued_ns = now;
        orders.module[static_cast<std::size_t>(n / 20 % kBusModules)] = {
            Kind::rotate_forward, 9'000, now + kSecond, static_cast<std::uint32_t>(n + 1)};
        if (n % 500 == 0) ++orders.emergency_serial;
        bus->release(orders, now);
      }
      for (auto out = bus->transmit(now); !out.empty(); out = bus->transmit(now)) {
        Receiver receiver(Check::lrc, Stop::lf);
        receiver.receive(out, now);
        const Frame asked = receiver.take()->frame;
        if (asked.code != static_cast<std::uint8_t>(Code::request_data)) continue;
        const Frame reply{asked.address, static_cast<std::uint8_t>(0x40 + asked.data[0]), {}};
        bus->receive(encode(reply, Check::lrc, Stop::lf, buffer), now);
      }
      bus->receive(std::span(buffer).first(5), now);  // noise
      now = std::max(now, std::min(bus->next_wake(), now + kMillisecond));
      heard += bus->take(replies);
    }
    EXPECT_EQ(testing_support::allocations(), before);
  }
  EXPECT_GT(heard, 1'000u);
  const std::uint64_t before = testing_support::allocations();
  ::operator delete(::operator new(1));
  EXPECT_EQ(testing_support::allocations(), before + 1) << "the counter counts";
}

}  // namespace
}  // namespace lss::zebro
