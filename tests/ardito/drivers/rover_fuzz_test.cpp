// The bus under arbitrary frames, orders and times, and its forbidden actions: allocate, ask for
// the past, move a drive that no order in force moves.

#include <gtest/gtest.h>
#include <rapidcheck.h>
#include <rapidcheck/gtest.h>

#include <optional>

#include "tests/ardito/drivers/rover_world.h"
#include "tests/support/allocations.h"
#include "tests/support/any_frame.h"
#include "tests/support/bus_time.h"
#include "tests/support/can_frames.h"

namespace lss::ardito {
namespace {

using testing_support::frame;

// Drives a bus without nodes and checks each frame that it sends.
class Watched {
 public:
  Watched() : bus_(parameters_) { restart(); }

  void restart() {
    ended_ = orders_.serial;
    bus_.restart(now_);
    pump();
  }

  void release(const RoverOrders& orders) {
    const bool emergency = orders.emergency_serial != orders_.emergency_serial;
    orders_ = orders;
    if (emergency) ended_ = orders.serial;
    bus_.release(orders_, now_);
    pump();
  }

  void receive(const CanFrame& f) {
    bus_.receive({&f, 1});
    pump();
  }

  void advance(TimeNs duration) {
    testing_support::advance(bus_, now_, now_ + duration, [this] { pump(); });
  }

  // A possible answer of a node to the last message, so that boots advance.
  CanFrame answer() const {
    const std::uint32_t node = last_.id & 0x7F;
    if (last_.id == 0x000)
      return frame(0x700u + last_.data[1],
                   {last_.data[0] == 0x01 ? std::uint8_t{5} : std::uint8_t{0}}, now_);
    if (last_.data[0] == 0x40) {
      const std::uint8_t type = node <= 6 ? 2 : node < 0x20 ? 4 : node == 0x20 ? 7 : 1;
      const bool drive = node < 0x20;
      return frame(0x580 + node,
                   {0x43, 0x00, 0x10, 0,
                    static_cast<std::uint8_t>(drive          ? 0x92
                                              : node == 0x20 ? 0x91
                                                             : 0),
                    static_cast<std::uint8_t>(node == 0x21 ? 0 : 1), type, 0},
                   now_);
    }
    return frame(0x580 + node, {0x60, last_.data[1], last_.data[2], last_.data[3], 0, 0, 0, 0},
                 now_);
  }

  // Answers everything until all nodes are up.
  void boot() {
    advance(600 * kMillisecond);
    for (int n = 0; n < 2'000 && !asked_.empty(); ++n) {
      last_ = asked_.front();
      asked_.erase(asked_.begin());
      receive(answer());
    }
  }
  bool all_operational() {
    for (const RoverLink& link : bus_.status().link) {
      if (link.node.state != canopen::NodeState::operational) return false;
    }
    return true;
  }

  // Heartbeats of all nodes, and drives in the state of this statusword.
  void alive(std::uint16_t word) {
    for (const std::uint32_t node :
         {0x01u, 0x02u, 0x03u, 0x04u, 0x05u, 0x06u, 0x11u, 0x12u, 0x15u, 0x16u, 0x20u, 0x21u}) {
      receive(frame(0x700 + node, {5}, now_));
      if (node >= 0x20) continue;
      receive(frame(
          0x180u + node,
          {static_cast<std::uint8_t>(word), static_cast<std::uint8_t>(word >> 8), 0, 0, 0, 0, 0, 0},
          now_));
    }
  }

  const RoverOrders& orders() const { return orders_; }
  TimeNs now() const { return now_; }
  bool moved = false;

 private:
  void pump() {
    CanFrame f;
    for (int n = 0;; ++n) {
      RC_ASSERT(n < 200);
      const bool sends = bus_.transmit(now_, f);
      const auto safe = bus_.status().counters.safe_commands;
      if (safe != safe_) ended_ = orders_.serial;
      safe_ = safe;
      if (!sends) return;
      check(f);
      last_ = f;
      const std::uint32_t function = f.id & 0x780;
      if (f.id == 0x000 || function == 0x600) asked_.push_back(f);
    }
  }

  void check(const CanFrame& f) {
    RC_ASSERT(!f.extended && !f.remote && !f.error);
    RC_ASSERT(f.id <= kStandardIds && f.size <= 8);
    RC_ASSERT(f.time_ns == now_);
    const std::uint32_t function = f.id & 0x780, node = f.id & 0x7F;
    if (f.id == 0x000) {
      RC_ASSERT(f.size == 2);
      RC_ASSERT(f.data[0] == 0x81 || f.data[0] == 0x82 || f.data[0] == 0x01);
      RC_ASSERT(f.data[1] != 0);
    } else if (function == 0x200 && node == 0x20) {
      RC_ASSERT(f.size == 1);
      RC_ASSERT(f.data[0] < 0x80);
    } else if (function == 0x200) {
      RC_ASSERT(f.size == 6);
      if ((word_of(f) & 0x0F) == 0x0F) motion(f, node);
    } else {
      RC_ASSERT(f.id == 0x080 || f.id == 0x77F || (function == 0x600 && f.size == 8));
    }
  }

  // An RPDO that enables a drive.
  void motion(const CanFrame& f, std::uint32_t node) {
    moved = true;
    RC_ASSERT(static_cast<std::int32_t>(orders_.serial - ended_) > 0);
    RC_ASSERT(!orders_.quick_stop);
    RC_ASSERT(now_ - orders_.issued_ns <= parameters_.stale_after_ns);
    if (node <= 6) {
      RC_ASSERT(orders_.wheel[node - 1].enabled);
      RC_ASSERT(target_of(f) == static_cast<std::int32_t>(orders_.wheel[node - 1].motor_rpm));
    } else {
      const std::size_t s = node == 0x11 ? 0 : node == 0x12 ? 1 : node == 0x15 ? 2 : 3;
      RC_ASSERT(orders_.steering[s].enabled);
    }
  }

  RoverBusParameters parameters_;
  RoverBus bus_;
  RoverOrders orders_{};
  TimeNs now_ = kSecond;
  std::uint32_t ended_ = 0;
  std::uint64_t safe_ = 0;
  CanFrame last_;
  std::vector<CanFrame> asked_;
};

RoverOrders changed(RoverOrders orders, TimeNs now) {
  orders.issued_ns = now - *rc::gen::element<TimeNs>(0, 0, 0, 0, 100 * kMillisecond, kSecond);
  orders.next_frame_ns = *rc::gen::element<TimeNs>(0, now + 90 * kMillisecond, now + kSecond, 1);
  if (*rc::gen::inRange(0, 4) > 0) ++orders.serial;
  if (*rc::gen::inRange(0, 20) == 0) ++orders.emergency_serial;
  if (*rc::gen::inRange(0, 10) == 0) ++orders.fault_reset_serial;
  orders.quick_stop = *rc::gen::inRange(0, 10) == 0;
  if (*rc::gen::inRange(0, 20) == 0) ++orders.node_reset_serial;
  orders.reset_nodes = *rc::gen::arbitrary<std::uint16_t>();
  orders.standing = *rc::gen::arbitrary<bool>();
  for (WheelOrder& w : orders.wheel) {
    w.enabled = *rc::gen::inRange(0, 4) > 0;
    w.motor_rpm = *rc::gen::inRange(-4'000, 4'000);
  }
  for (SteeringOrder& s : orders.steering) {
    s.enabled = *rc::gen::inRange(0, 4) > 0;
    s.position_rad = *rc::gen::inRange(-100, 100) * 0.01;
  }
  return orders;
}

// Frames that our nodes could send, and any others.
CanFrame incoming(TimeNs now) {
  CanFrame f = *testing_support::any_frame();
  f.time_ns = now;
  if (*rc::gen::inRange(0, 4) == 0) return f;
  const auto node =
      *rc::gen::element<std::uint32_t>(1, 2, 3, 4, 5, 6, 0x11, 0x12, 0x15, 0x16, 0x20, 0x21);
  const auto word =
      *rc::gen::element<std::uint16_t>(0x250, 0x231, 0x233, 0x237, 0x1237, 0x217, 0x218, 0x21F);
  switch (*rc::gen::inRange(0, 6)) {
    case 0: return frame(0x700 + node, {*rc::gen::element<std::uint8_t>(0, 5, 5, 5, 0x7F, 4)}, now);
    case 1: return frame(0x080 + node, {0x30, 0x81, 0x11, 0, 0, 0, 0, 0}, now);
    default:
      return frame(
          0x180 + node,
          {static_cast<std::uint8_t>(word), static_cast<std::uint8_t>(word >> 8), 1, 2, 3, 4, 5, 6},
          now);
  }
}

RC_GTEST_PROP(RoverFuzz, NothingThatComesInMakesTheBusMoveWhatItMustNot, ()) {
  Watched bus;
  if (*rc::gen::inRange(0, 4) > 0) {
    bus.boot();
    RC_ASSERT(bus.all_operational());
  }
  const int steps = *rc::gen::inRange(0, 200);
  for (int n = 0; n < steps; ++n) {
    switch (*rc::gen::inRange(0, 12)) {
      case 0:
        bus.advance(*rc::gen::element<TimeNs>(1, 5 * kMillisecond, 400 * kMillisecond, kSecond));
        break;
      case 1:
        if (*rc::gen::inRange(0, 20) == 0) bus.restart();
        break;
      case 2: bus.receive(bus.answer()); break;
      case 3:
      case 4:
        bus.alive(*rc::gen::element<std::uint16_t>(0x237, 0x237, 0x1237, 0x233, 0x217, 0x218));
        break;
      case 5:
      case 6:
      case 7:
        bus.release(changed(bus.orders(), bus.now()));
        bus.advance(*rc::gen::inRange<TimeNs>(1, 20 * kMillisecond));
        break;
      default: bus.receive(incoming(bus.now()));
    }
  }
  RC_TAG(bus.moved ? "moved" : "stood");
}

TEST(RoverBus, AllocatesNothing) {
  std::optional<RoverBus> bus;
  std::array<RoverSample, RoverBus::kMaxSamples> samples;
  RoverOrders orders;
  for (WheelOrder& w : orders.wheel) w = {true, 500};
  orders.standing = true;
  const CanFrame motion = frame(0x181, {0x37, 0x02, 0, 0, 0, 0, 0, 0});
  const CanFrame emcy = frame(0x082, {0x10, 0x23, 0x03, 0, 0, 0, 0, 0});
  const CanFrame boot_up = frame(0x703, {0}), heartbeat = frame(0x701, {5});
  std::size_t heard = 0, sent = 0;
  const RoverBusParameters parameters;  // reads the descriptions
  const std::uint64_t before = testing_support::allocations();
  bus.emplace(parameters);
  bus->restart(kSecond);
  for (TimeNs now = kSecond; now < 20 * kSecond; now += 10 * kMillisecond) {
    orders.issued_ns = now;
    ++orders.serial;
    if (orders.serial % 500 == 0) ++orders.emergency_serial;
    bus->release(orders, now);
    CanFrame f;
    while (bus->transmit(now, f)) {
      ++sent;
      CanFrame answer = f;
      answer.time_ns = now;
      answer.id = f.id == 0 ? 0x700u + f.data[1] : f.id - 0x80;
      answer.size = f.id == 0 ? 1 : 8;
      answer.data[0] = f.id == 0 ? (f.data[0] == 1 ? 5 : 0) : f.data[0] == 0x40 ? 0x43 : 0x60;
      if (f.id == 0x601 && f.data[0] == 0x40) {
        answer.data[4] = 0x92, answer.data[5] = 1, answer.data[6] = 2;
      }
      bus->receive({&answer, 1});
    }
    for (CanFrame in : {heartbeat, motion, emcy, boot_up}) {
      in.time_ns = now;
      bus->receive({&in, 1});
    }
    heard += bus->take(samples);
    (void)bus->status();
  }
  EXPECT_EQ(testing_support::allocations(), before);
  EXPECT_GT(heard, 1'000u);
  EXPECT_GT(sent, 1'000u);
}

}  // namespace
}  // namespace lss::ardito
