// Execution of orders: verification, repetition, broken and missing replies.

#include <gtest/gtest.h>

#include "tests/zebro/drivers/leg_bus_world.h"

namespace lss::zebro {
namespace {

using Kind = ModuleOrder::Kind;

const ModuleLink& link(const World& world, std::size_t module) {
  return world.bus.counters().module[module];
}

World& on(World& world) {
  world.settle();
  for (int m = 0; m < kBusModules; ++m) world.order(m, Kind::motion_on);
  world.run_frames(3);
  world.sent.clear();
  return world;
}

class LegsOn : public testing::Test {
 protected:
  LegsOn() { on(world); }
  World world;
};

TEST_F(LegsOn, AnObeyedOrderIsSentOnce) {
  const TimeNs arrive_ns = world.now + 500 * kMillisecond;
  for (int m = 0; m < kBusModules; ++m) world.order(m, Kind::rotate_forward, 9'000, arrive_ns);
  world.run_frames(50);
  EXPECT_EQ(world.sent_with(Code::rotate_forward).size(), 7u);
  for (int m = 0; m < kBusModules; ++m) world.order(m, Kind::motion_off);
  world.run_frames(50);
  EXPECT_EQ(world.sent_with(Code::stop_motion_control).size(), 7u);
  for (int m = 0; m < kBusModules; ++m) world.order(m, Kind::reset);
  world.run_frames(100);
  EXPECT_EQ(world.sent_with(Code::reset).size(), 7u);
  for (const ModuleLink& l : world.bus.counters().module) {
    EXPECT_EQ(l.resends, 0u);
    EXPECT_FALSE(l.disobeys);
  }
}

// The release may fall anywhere between a request and its reply.
TEST(LegOrders, AReplyToARequestFromBeforeTheCommandIsNoContradiction) {
  for (TimeNs offset = 0; offset < 20 * kMillisecond; offset += 300 * kMicrosecond) {
    World world;
    world.settle();
    world.release();
    world.run_for(offset);
    for (int m = 0; m < kBusModules; ++m) world.order(m, Kind::motion_on);
    world.run_frames(3);
    for (const ModuleLink& l : world.bus.counters().module) EXPECT_EQ(l.resends, 0u) << offset;
  }
}

TEST(LegOrders, ALostStartIsSentAgainUntilTheModuleSaysThatItIsOn) {
  World world;
  world.settle();
  world.module[2].deaf = 2;
  world.order(2, Kind::motion_on);
  world.run_frames(10);
  EXPECT_TRUE(world.module[2].on);
  EXPECT_EQ(world.sent_to(3, Code::start_motion_control).size(), 3u);
  EXPECT_EQ(link(world, 2).resends, 2u);
  EXPECT_FALSE(link(world, 2).disobeys);
}

TEST(LegOrders, AfterTheResendLimitTheModuleDisobeysUntilANewOrder) {
  for (const Kind kind : {Kind::motion_on, Kind::motion_off, Kind::rotate_backward}) {
    World world;
    on(world);
    if (kind == Kind::motion_on) world.module[4].on = false;
    world.module[4].deaf = -1;
    world.order(4, kind, 18'000, world.now + 5 * kSecond);
    world.run_frames(50);
    EXPECT_TRUE(link(world, 4).disobeys);
    EXPECT_EQ(link(world, 4).resends, 5u);
    EXPECT_EQ(world.sent.size() - world.sent_with(Code::request_data).size(), 6u);
    EXPECT_FALSE(link(world, 3).disobeys);

    world.module[4].deaf = 0;
    world.order(4, Kind::motion_off);
    world.run_frames(1);
    EXPECT_FALSE(link(world, 4).disobeys);
  }
}

TEST_F(LegsOn, ALostRotateIsSentAgainWithTheTimeThatIsLeft) {
  world.module[0].deaf = 1;
  const TimeNs arrive_ns = world.now + 2 * kSecond;
  world.order(0, Kind::rotate_backward, 34'000, arrive_ns);
  world.run_frames(10);
  EXPECT_EQ(world.module[0].set_point_cdeg, 34'000);
  EXPECT_LE(std::abs(world.module[0].arrival_ns - arrive_ns), kMillisecond);
  EXPECT_EQ(world.sent_to(1, Code::rotate_backward).size(), 2u);
  EXPECT_EQ(link(world, 0).resends, 1u);
}

TEST_F(LegsOn, ARotateToTheSamePositionAtAnotherTimeIsNoticedWhenItIsLost) {
  world.order(0, Kind::rotate_forward, 9'000, world.now + 100 * kMillisecond);
  world.run_frames(20);
  world.module[0].deaf = 1;
  const TimeNs arrive_ns = world.now + 3 * kSecond;
  world.order(0, Kind::rotate_forward, 9'000, arrive_ns);
  world.run_frames(10);
  EXPECT_LE(std::abs(world.module[0].arrival_ns - arrive_ns), kMillisecond);
}

TEST_F(LegsOn, ARepeatedRotateHasAtLeastATenthOfASecond) {
  world.module[0].deaf = 1;
  world.order(0, Kind::rotate_forward, 9'000, world.now + 10 * kMillisecond);
  world.run_frames(10);
  const auto sent = world.sent_to(1, Code::rotate_forward);
  ASSERT_EQ(sent.size(), 2u);
  EXPECT_EQ(sent[1].frame, rotate(1, Code::rotate_forward, 9'000, 100));
}

TEST_F(LegsOn, AnEmergencyStopThatIsNotObeyedIsRepeatedFastThenOnceASecondWithoutEnd) {
  world.module[5].deaf = -1;
  world.emergency();
  world.run_frames(500);  // 10 s
  EXPECT_TRUE(world.module[5].on);
  EXPECT_TRUE(link(world, 5).disobeys);
  const auto stops = world.sent_to(6, Code::emergency_stop);
  EXPECT_GE(stops.size(), 6u + 9u);
  EXPECT_LE(stops.size(), 6u + 10u);
  EXPECT_LE(stops[5].end_ns - stops[0].end_ns, 6 * world.parameters.period_ns);
  for (const int address : {1, 2, 3, 4, 5, 7}) {
    EXPECT_EQ(world.sent_to(static_cast<std::uint8_t>(address), Code::emergency_stop).size(), 1u);
  }
  world.module[5].deaf = 0;
  world.run_frames(51);
  EXPECT_FALSE(world.module[5].on);
}

TEST_F(LegsOn, ASilentModuleIsStoppedAgainAndAgainButDoesNotDisobey) {
  world.module[5].dead = true;
  world.emergency();
  world.run_frames(500);
  EXPECT_GE(world.sent_to(6, Code::emergency_stop).size(), 6u + 9u);
  EXPECT_FALSE(link(world, 5).disobeys);
  world.module[5].dead = false;
  world.run_frames(60);
  EXPECT_FALSE(world.module[5].on);
}

TEST_F(LegsOn, ASilentModuleIsNotSentMotionAgain) {
  world.module[5].dead = true;
  world.order(5, Kind::rotate_forward, 9'000, world.now + kSecond);
  world.run_frames(100);
  EXPECT_EQ(world.sent_to(6, Code::rotate_forward).size(), 1u);
  EXPECT_FALSE(link(world, 5).disobeys);
}

// [Oper-4]
TEST(LegOrders, ALostResetIsSentAgainOnlyAfterASecond) {
  World world;
  world.settle();
  world.module[1].deaf = 1;
  const TimeNs ordered_ns = world.now;
  world.order(1, Kind::reset);
  world.run_frames(100);
  const auto resets = world.sent_to(2, Code::reset);
  ASSERT_EQ(resets.size(), 2u);
  EXPECT_GE(resets[1].start_ns - ordered_ns, kSecond);
  EXPECT_GT(world.module[1].boot_ns, ordered_ns);
  EXPECT_FALSE(link(world, 1).disobeys);
  EXPECT_EQ(link(world, 1).resets, 1u) << "the one that was seen";
}

// Its status with the flag was lost; milliseconds are rounded, and its clock is not ours.
TEST(LegOrders, AResetThatTheUptimeShowsIsNotSentAgain) {
  for (const double clock : {0.99, 1.0, 1.01}) {
    World world;
    world.settle();
    world.module[1].tells_resets = false;
    world.module[1].clock = clock;
    world.order(1, Kind::reset);
    world.run_frames(100);
    EXPECT_EQ(world.sent_to(2, Code::reset).size(), 1u) << clock;
    EXPECT_EQ(link(world, 1).resets, 1u) << clock;
  }
}

// --- replies that go wrong ---

TEST(LegReplies, AnUnansweredModuleCostsTheOthersNothing) {
  for (const bool half_duplex : {false, true}) {
    LegBusParameters p;
    p.half_duplex = half_duplex;
    p.period_ns = (half_duplex ? 40 : 20) * kMillisecond;
    World world(p);
    world.settle();
    world.module[3].dead = true;
    world.run_frames(2);
    const BusCounters before = world.bus.counters();
    world.run_frames(50);
    const BusCounters& after = world.bus.counters();
    for (std::size_t m = 0; m < kBusModules; ++m) {
      const auto replies = after.module[m].replies - before.module[m].replies;
      if (m == 3) {
        EXPECT_EQ(replies, 0u);
      } else {
        EXPECT_GE(replies, 50u);
      }
    }
    EXPECT_EQ(after.module[3].requests - before.module[3].requests, 50u);
    EXPECT_FALSE(world.collision);
  }
}

TEST(LegReplies, AReplyIsStampedWithTheArrivalOfItsFirstCharacter) {
  World world;
  world.settle();
  world.release();
  world.run_for(world.parameters.period_ns);
  const auto replies = world.take_all();
  ASSERT_GE(replies.size(), 7u);
  const TimeNs character_ns = world.frame_ns / 24;
  for (std::size_t i = 0; i < 7; ++i) {
    EXPECT_EQ(replies[i].module, i);
    EXPECT_EQ(replies[i].time_ns,
              world.sent[i].end_ns + 2 * character_ns);  // turn-around, then ':'
  }
}

struct Mangled {
  const char* what;
  std::function<std::vector<std::string>(const Frame&, std::string)> filter;
  std::uint64_t BusCounters::*cause;
  bool reply_is_lost;
};

TEST(LegReplies, ABrokenReplyIsDroppedCountedAndHarmsNoOther) {
  const Mangled cases[] = {
      {"duplicate",
       [](const Frame&, const std::string& s) {
         return std::vector{s, s};
       },
       &BusCounters::unexpected, false},
      {"truncated",
       [](const Frame&, const std::string& s) { return std::vector{s.substr(0, 9) + "\n"}; },
       &BusCounters::bad_length, true},
      {"merged", [](const Frame&, const std::string& s) { return std::vector{s.substr(0, 23)}; },
       &BusCounters::bad_length, true},
      {"corrupted",
       [](const Frame&, std::string s) {
         s[9] = s[9] == '0' ? '1' : '0';
         return std::vector{s};
       },
       &BusCounters::bad_check, true},
      {"noisy",
       [](const Frame&, std::string s) {
         s[9] = '\x7F';
         return std::vector{s};
       },
       &BusCounters::bad_character, true},
      {"foreign",
       [](const Frame&, const std::string&) {
         return std::vector<std::string>{":09400000000000000000B7\n"};
       },
       &BusCounters::unexpected, true},
  };
  for (const Mangled& c : cases) {
    World world;
    world.settle();
    const BusCounters before = world.bus.counters();
    world.reply_filter = [&c](const Frame& frame, const std::string& s) {
      return frame.address == 2 && frame.code == 0x40 ? c.filter(frame, s) : std::vector{s};
    };
    world.run_frames(20);
    const BusCounters& after = world.bus.counters();
    const auto replies = [&](std::size_t m) {
      return after.module[m].replies - before.module[m].replies;
    };
    EXPECT_EQ(after.*c.cause - before.*c.cause, 20u) << c.what;
    EXPECT_EQ(after.frames_dropped - before.frames_dropped, 20u) << c.what;
    for (const std::size_t m : {0u, 2u, 3u, 4u, 5u, 6u}) EXPECT_GE(replies(m), 20u) << c.what << m;
    if (c.reply_is_lost) {
      EXPECT_LE(replies(1), 4u) << c.what;  // health and identity
    } else {
      EXPECT_GE(replies(1), 20u) << c.what;
    }
  }
}

TEST(LegReplies, ALateReplyIsUnexpected) {
  World world;
  world.settle();
  const std::uint64_t before = world.bus.counters().unexpected;
  world.module[6].dead = true;
  world.release();
  world.run_for(world.parameters.period_ns);  // the time-out is over
  world.take_all();
  world.deliver(":07400000000000000000B9\n");
  EXPECT_EQ(world.bus.counters().unexpected, before + 1);
  EXPECT_TRUE(world.take_all().empty());
}

TEST(LegReplies, TheMastersOwnEchoIsUnexpectedAndHarmless) {
  World world;
  on(world);
  const BusCounters before = world.bus.counters();
  world.deliver(":01010000000000000000FE\n:07050000000000000000F4\n");
  EXPECT_EQ(world.bus.counters().unexpected, before.unexpected + 2);
}

}  // namespace
}  // namespace lss::zebro
