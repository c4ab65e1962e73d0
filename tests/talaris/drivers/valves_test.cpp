// Which valves are open when, in virtual time (docs/icd-talaris.md sections 7 and 8).

#include "drivers/talaris/valves.h"

#include <gtest/gtest.h>

#include <cstring>

#include "tests/support/allocations.h"
#include "tests/talaris/drivers/lines.h"

namespace lss::talaris {
namespace {

constexpr TimeNs kFrame = 200 * kMillisecond;

struct Said {
  TimeNs time_ns = 0;
  std::uint8_t bits = 0;
  bool operator==(const Said&) const = default;
};

class Valves : public ::testing::Test {
 protected:
  // Sends all messages due until `end`, like a thread that is never late.
  void run_until(TimeNs end) {
    while (true) {
      send();
      const TimeNs next = valves.next_wake();
      ASSERT_GT(next, now) << "asked to be woken in the past";
      if (next > end) break;
      now = next;
    }
    now = end;
  }
  void send() {
    CanFrame frame;
    for (int n = 0; valves.due(now, frame); ++n) {
      ASSERT_LT(n, 10);
      valves.sent(works, now);
      if (!works) continue;
      frames.push_back(frame);
      if (frame.id == 0x220) said.push_back({now, frame.data[0]});
    }
  }
  // Orders of the frame that begins now, released `offset` later.
  void release(TimeNs offset = 5 * kMillisecond) {
    orders.boundary_ns = now;
    orders.issued_ns = now + kMillisecond;
    orders.release_ns = now + offset;
    run_until(orders.release_ns);
    valves.release(orders, now);
    send();
  }
  // Changes only: when which bits began.
  std::vector<Said> edges() const {
    std::vector<Said> found;
    for (const Said& s : said) {
      if (found.empty() ? s.bits != 0 : s.bits != found.back().bits) found.push_back(s);
    }
    return found;
  }

  ValveSequencer valves;
  TalarisOrders orders{.enabled = 0xFF};
  TimeNs now = 10 * kSecond;
  bool works = true;
  std::vector<CanFrame> frames;
  std::vector<Said> said;
};

TEST_F(Valves, GoldenFrames) {
  const CanFrame open = valve_frame(0x20, 0x55, 6);
  EXPECT_EQ(open.id, 0x220u);
  EXPECT_EQ(open.size, 2);
  EXPECT_EQ(open.data[0], 0x55);
  EXPECT_EQ(open.data[1], 6);
  const CanFrame fans = fan_frame(0x21, {1700, 1700, 1710, 1690});
  EXPECT_EQ(fans.id, 0x221u);
  EXPECT_EQ(fans.size, 8);
  EXPECT_EQ(fans.data, (std::array<std::uint8_t, 8>{0xA4, 6, 0xA4, 6, 0xAE, 6, 0x9A, 6}));
  const CanFrame cut = fan_frame(0x21, {0, 999, 2001, 65535});
  EXPECT_EQ(cut.data, (std::array<std::uint8_t, 8>{0xE8, 3, 0xE8, 3, 0xD0, 7, 0xD0, 7}));
}

TEST_F(Valves, OrdersOfNothingAreTheSafeCommand) {
  const TalarisOrders nothing;
  EXPECT_EQ(nothing.enabled, 0);
  for (const std::uint16_t width : nothing.fan_us) EXPECT_EQ(width, 1000);
  valves.release(nothing, now);
  EXPECT_EQ(valves.bits_at(now), 0);
}

TEST_F(Valves, APulseBeginsAfterItsDelayAndLastsItsTime) {
  orders.pulse[2] = {30 * kMillisecond, 80 * kMillisecond};
  release();
  const TimeNs at = orders.release_ns;
  run_until(at + kFrame);
  EXPECT_EQ(edges(),
            (std::vector<Said>{{at + 30 * kMillisecond, 0x04}, {at + 110 * kMillisecond, 0x00}}));
  EXPECT_EQ(valves.counters().pulses[2], 1u);
  EXPECT_EQ(valves.counters().open_ns[2], 80 * kMillisecond);
  EXPECT_EQ(valves.counters().edges, 2u);
  EXPECT_EQ(valves.counters().worst_late_ns, 0);
}

TEST_F(Valves, EdgesOfOneMomentAreOneFrame) {
  for (const std::size_t v : {0u, 2u, 4u, 6u})
    orders.pulse[v] = {40 * kMillisecond, 40 * kMillisecond};
  orders.pulse[1] = {80 * kMillisecond, 40 * kMillisecond};  // opens as those shut
  release();
  const TimeNs at = orders.release_ns;
  run_until(at + kFrame);
  EXPECT_EQ(said, (std::vector<Said>{{at, 0x00},
                                     {at + 40 * kMillisecond, 0x55},
                                     {at + 80 * kMillisecond, 0x02},
                                     {at + 120 * kMillisecond, 0x00}}));
}

TEST_F(Valves, TheSequenceCountsEveryFrameAndNeverSaysZero) {
  orders.pulse[0] = {0, 160 * kMillisecond};
  for (int n = 0; n < 200; ++n) {
    release();
    run_until(orders.boundary_ns + kFrame);
  }
  ASSERT_GT(frames.size(), 600u);
  for (std::size_t i = 0; i < frames.size(); ++i) {
    ASSERT_EQ(frames[i].data[1], i % 255 + 1) << i;
  }
}

TEST_F(Valves, WhileOneIsOpenItIsSaidAgain) {
  orders.hold[3] = {true, now + 10 * kSecond};
  for (int n = 0; n < 20; ++n) {
    release();
    run_until(orders.boundary_ns + kFrame);
  }
  for (std::size_t i = 1; i < said.size(); ++i) {
    EXPECT_LE(said[i].time_ns - said[i - 1].time_ns, 50 * kMillisecond);
    EXPECT_EQ(said[i].bits, 0x08);
  }
}

TEST_F(Valves, ShutIsSaidAtEachReleaseOnly) {
  for (int n = 0; n < 10; ++n) {
    release();
    run_until(orders.boundary_ns + kFrame);
  }
  EXPECT_EQ(said.size(), 10u);
}

TEST_F(Valves, APulseThatIsOpenIsShutByTheNextFrame) {
  orders.pulse[0] = {100 * kMillisecond, 160 * kMillisecond};  // after the frame
  release();
  run_until(orders.boundary_ns + kFrame);
  orders.pulse[0] = {50 * kMillisecond, 40 * kMillisecond};
  release();
  run_until(orders.release_ns + kFrame / 2);
  const auto e = edges();
  ASSERT_EQ(e.size(), 4u);
  EXPECT_EQ(e[1], (Said{orders.release_ns, 0x00}));
  EXPECT_EQ(e[2], (Said{orders.release_ns + 50 * kMillisecond, 0x01}));
}

TEST_F(Valves, OpenThroughoutItDoesNotFlickerWhenTheNextReleaseIsLate) {
  orders.pulse[5] = {0, kFrame};
  release();
  for (int n = 0; n < 10; ++n) {
    run_until(orders.boundary_ns + kFrame + (n % 3) * 2 * kMillisecond);
    release();
  }
  EXPECT_EQ(edges().size(), 1u);
  EXPECT_EQ(valves.counters().pulses[5], 1u);
  // Without another release it ends shortly after its frame.
  run_until(now + kSecond);
  ASSERT_EQ(edges().size(), 2u);
  EXPECT_EQ(edges()[1].time_ns, orders.release_ns + kFrame + 10 * kMillisecond);
}

TEST_F(Valves, WhatIsNotEnabledStaysShut) {
  orders.enabled = 0xFD;
  orders.pulse[1] = {0, 100 * kMillisecond};
  orders.hold[1] = {true, now + kSecond};
  release();
  run_until(now + kFrame);
  EXPECT_TRUE(edges().empty());
}

TEST_F(Valves, AHoldOverridesThePulsesUntilItsTime) {
  orders.pulse[4] = {20 * kMillisecond, 40 * kMillisecond};
  orders.hold[4] = {true, now + 90 * kMillisecond};
  release();
  run_until(now + 150 * kMillisecond);
  EXPECT_EQ(edges(), (std::vector<Said>{{orders.release_ns, 0x10},
                                        {orders.boundary_ns + 90 * kMillisecond, 0x00}}));
}

TEST_F(Valves, AHoldThatIsTakenBackShutsAtTheRelease) {
  orders.hold[4] = {true, now + 10 * kSecond};
  release();
  run_until(orders.boundary_ns + kFrame);
  orders.hold[4] = {};
  release();
  EXPECT_EQ(edges().back(), (Said{orders.release_ns, 0x00}));
}

TEST_F(Valves, WithoutNewOrdersForMoreThanTwoFramesEverythingIsShut) {
  orders.hold[0] = {true, now + 10 * kSecond};
  release();
  run_until(now + 2 * kSecond);
  ASSERT_EQ(edges().size(), 2u);
  EXPECT_EQ(edges()[1].bits, 0);
  EXPECT_EQ(edges()[1].time_ns, orders.issued_ns + ValveParameters{}.stale_after_ns + 1);
  EXPECT_EQ(valves.counters().stale, 1u);
  EXPECT_EQ(valves.next_wake(), ValveSequencer::kNever);
}

TEST_F(Valves, OrdersThatAreOldOpenNothing) {
  orders.hold[0] = {true, now + 10 * kSecond};
  orders.issued_ns = now - ValveParameters{}.stale_after_ns - 1;
  orders.release_ns = now;
  valves.release(orders, now);
  run_until(now + kFrame);
  EXPECT_TRUE(edges().empty());
}

TEST_F(Valves, ACommandThatIsRepeatedOncePulsesAgainAndNotTwice) {
  orders.pulse[0] = {0, 100 * kMillisecond};
  release();
  run_until(orders.boundary_ns + kFrame);
  for (int n = 1; n <= 2; ++n) {  // the same, issued long ago, at another release
    TalarisOrders again = orders;
    again.release_ns = orders.release_ns + n * kFrame;
    run_until(again.release_ns);
    valves.release(again, now);
    send();
  }
  run_until(now + kFrame);
  EXPECT_EQ(valves.counters().pulses[0], 2u);
}

TEST_F(Valves, AnAllStopShutsAtOnceAndTurnsTheFansOff) {
  orders.hold[0] = {true, now + 10 * kSecond};
  orders.pulse[1] = {50 * kMillisecond, 100 * kMillisecond};
  release();
  run_until(now + 20 * kMillisecond);
  frames.clear();
  valves.all_stop(now);
  EXPECT_EQ(valves.next_wake(), now);
  send();
  ASSERT_EQ(frames.size(), 2u);
  EXPECT_EQ(frames[0].id, 0x220u);
  EXPECT_EQ(frames[0].data[0], 0);
  EXPECT_EQ(frames[1].id, 0x221u);
  EXPECT_EQ(frames[1].data, (std::array<std::uint8_t, 8>{0xE8, 3, 0xE8, 3, 0xE8, 3, 0xE8, 3}));
  run_until(now + kSecond);
  EXPECT_EQ(frames.size(), 2u);  // and nothing opens after it
}

TEST_F(Valves, OrdersThatSayAllStopOpenNothing) {
  orders.hold[0] = {true, now + 10 * kSecond};
  orders.all_stop = true;
  release();
  run_until(now + kSecond);
  EXPECT_TRUE(edges().empty());
}

TEST_F(Valves, APortThatWasOpenedAgainIsReportedShutFirst) {
  orders.hold[0] = {true, now + 10 * kSecond};
  release();
  run_until(now + 20 * kMillisecond);
  said.clear();
  valves.reopened(now);
  send();
  ASSERT_EQ(said.size(), 1u);
  EXPECT_EQ(said[0], (Said{now, 0}));
  run_until(orders.boundary_ns + kFrame);
  EXPECT_EQ(said.size(), 1u);  // earlier orders are dropped
  release();
  EXPECT_EQ(said.back().bits, 0x01);
}

TEST_F(Valves, AFrameThatCouldNotBeSentIsTriedAgainAMillisecondLater) {
  orders.pulse[0] = {50 * kMillisecond, 40 * kMillisecond};
  release();
  run_until(now + 60 * kMillisecond);
  works = false;
  run_until(orders.release_ns + 95 * kMillisecond);
  EXPECT_EQ(valves.open(), 0x01);
  EXPECT_GE(valves.counters().failed, 5u);
  works = true;
  run_until(now + 10 * kMillisecond);
  EXPECT_EQ(valves.open(), 0x00);
  EXPECT_LE(edges().back().time_ns, orders.release_ns + 97 * kMillisecond);
  EXPECT_GE(valves.counters().worst_late_ns, 5 * kMillisecond);
}

TEST_F(Valves, ALateThreadIsSeenAndShutsOnTime) {
  orders.pulse[0] = {50 * kMillisecond, 40 * kMillisecond};
  release();
  now = orders.release_ns + 58 * kMillisecond;  // slept too long
  send();
  run_until(now + kFrame / 2);
  EXPECT_EQ(valves.counters().worst_late_ns, 8 * kMillisecond);
  EXPECT_EQ(valves.counters().open_ns[0], 32 * kMillisecond);
  EXPECT_EQ(edges().back(), (Said{orders.release_ns + 90 * kMillisecond, 0}));
}

TEST_F(Valves, OfWhichTheMemoryIsDamagedShutAndBeginAgain) {
  orders.pulse[0] = {0, 150 * kMillisecond};
  release();
  ASSERT_EQ(valves.open(), 0x01);
  const ValveCounters counters = valves.counters();
  std::memset(static_cast<void*>(&valves), 0xA5, sizeof valves);
  now += 20 * kMillisecond;
  valves.begin_again({}, counters, 0x01, now);
  frames.clear();
  send();
  ASSERT_EQ(frames.size(), 1u);
  EXPECT_EQ(frames[0].id, 0x220u);
  EXPECT_EQ(frames[0].data[0], 0);
  EXPECT_EQ(frames[0].data[1], 0) << "the node obeys this after any sequence";
  EXPECT_EQ(valves.counters().edges, 2u);
  EXPECT_EQ(valves.counters().restarts, counters.restarts + 1);
  EXPECT_EQ(valves.counters().pulses[0], 1u);
  run_until(now + kFrame);
  EXPECT_EQ(valves.open(), 0) << "the rest of the pulse is void";
  release();
  EXPECT_EQ(valves.open(), 0x01);
}

TEST_F(Valves, ThatBeginAgainAtAReleaseOpenWithItAndNotAtTheNextEdge) {
  orders.pulse[2] = {0, 150 * kMillisecond};
  orders.boundary_ns = orders.issued_ns = orders.release_ns = now;
  valves.begin_again({}, {}, 0x01, now);
  valves.release(orders, now);
  send();
  EXPECT_EQ(said, (std::vector<Said>{{now, 0}, {now, 0x04}}));
  ASSERT_EQ(frames.size(), 2u);
  EXPECT_EQ(frames[0].data[1], 0);
  EXPECT_EQ(frames[1].data[1], 1) << "with sequence 0 the node would shut it";
  EXPECT_EQ(valves.open(), 0x04);
  EXPECT_EQ(valves.counters().pulses[2], 1u);
  run_until(now + kFrame);
  EXPECT_EQ(edges().back(), (Said{orders.release_ns + 150 * kMillisecond, 0}));
  EXPECT_EQ(valves.counters().open_ns[2], 150 * kMillisecond);
}

TEST_F(Valves, NothingAllocates) {
  orders.pulse[0] = {50 * kMillisecond, 40 * kMillisecond};
  CanFrame frame;
  const std::uint64_t before = testing_support::allocations();
  for (int n = 0; n < 100; ++n) {
    orders.issued_ns = orders.release_ns = now;
    valves.release(orders, now);
    for (const TimeNs end = now + kFrame; now < end; now += kMillisecond) {
      while (valves.due(now, frame)) valves.sent(n % 7 != 0, now);
    }
  }
  valves.all_stop(now);
  while (valves.due(now, frame)) valves.sent(true, now);
  EXPECT_EQ(testing_support::allocations(), before);
}

}  // namespace
}  // namespace lss::talaris
