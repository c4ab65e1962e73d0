// The schedule of the bus: messages, order, times.

#include "drivers/zebro/leg_bus.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "tests/zebro/drivers/leg_bus_world.h"

namespace lss::zebro {
namespace {

using Kind = ModuleOrder::Kind;

LegBusParameters with(int baud, bool half_duplex) {
  LegBusParameters p;
  p.baud = baud;
  p.half_duplex = half_duplex;
  p.period_ns = (half_duplex ? 40 : 20) * kMillisecond;
  return p;
}

struct Line {
  int baud;
  bool half_duplex;
};

class LegBusTiming : public ::testing::TestWithParam<Line> {};

TEST_P(LegBusTiming, ACycleOfSevenModulesTakesTheTimeOfItsBytesOnTheWire) {
  const Line line = GetParam();
  const double tolerance = line.baud > 500'000 ? 0.07 : 0.015;
  for (const TimeNs turn_around_characters : {0, 1}) {
    World world(with(line.baud, line.half_duplex), turn_around_characters);
    world.settle();
    const TimeNs exchanges = line.half_duplex ? 7 : 1;
    const TimeNs frames = line.half_duplex ? 14 : 8;
    const TimeNs turn_around_ns = turn_around_characters * 10 * kSecond / line.baud;
    const auto formula_ns =
        static_cast<double>(frames * world.frame_ns + exchanges * turn_around_ns);
    for (int n = 0; n < 70; ++n) {
      world.run_frames(1);
      EXPECT_NEAR(static_cast<double>(world.bus.counters().cycle_ns), formula_ns,
                  tolerance * formula_ns);
    }
    EXPECT_FALSE(world.collision);
    EXPECT_FALSE(world.too_far_ahead);
    EXPECT_FALSE(world.stuck);
    EXPECT_EQ(world.bus.counters().frames_dropped, 0u);
  }
}

INSTANTIATE_TEST_SUITE_P(Lines, LegBusTiming,
                         ::testing::Values(Line{115'200, false}, Line{1'000'000, false},
                                           Line{115'200, true}, Line{1'000'000, true}),
                         [](const auto& line) {
                           return std::to_string(line.param.baud) +
                                  (line.param.half_duplex ? "half" : "full");
                         });

// [P-Int-2]
TEST(LegBus, BeginsWithAnEmergencyStopToAllAndToEach) {
  World world;
  for (TestModule& m : world.module) m.on = true;
  world.run_for(100 * kMillisecond);
  ASSERT_GT(world.sent.size(), 8u);
  for (std::uint8_t address = 0; address <= kBusModules; ++address) {
    EXPECT_EQ(world.sent[address].frame, command(address, Code::emergency_stop));
  }
  for (const TestModule& m : world.module) EXPECT_FALSE(m.on);
  EXPECT_EQ(world.sent_with(Code::emergency_stop).size(), 8u);  // confirmed: not repeated
  EXPECT_EQ(world.bus.counters().safe_commands, 0u);
}

TEST(LegBus, BeginsWithTheStopAlsoWithoutARestart) {
  LegBus bus{LegBusParameters{}};
  const auto first = bus.transmit(0);
  EXPECT_EQ(std::string(first.begin(), first.end()), ":00060000000000000000FA\n");
}

TEST(LegBus, StopsGoBeforeOtherCommands) {
  World world;
  world.settle();
  world.order(0, Kind::motion_on);
  world.order(1, Kind::reset);
  world.order(6, Kind::emergency_stop);
  world.run_frames(1);
  EXPECT_EQ(world.sent[0].frame, command(7, Code::emergency_stop));
}

TEST(LegBus, PollsBeforeTheFirstOrdersCome) {
  World world;
  world.run_for(kSecond);
  std::set<int> heard;
  for (const ModuleReply& reply : world.take_all()) heard.insert(reply.module);
  EXPECT_EQ(heard.size(), 7u);
}

TEST(LegBus, EachCycleAsksSevenStatusAndOneHealthInTurn) {
  World world;
  world.settle();
  for (int n = 0; n < 14; ++n) {
    world.sent.clear();
    world.run_frames(1);
    std::vector<std::uint8_t> status, health;
    for (const Sent& s : world.sent_with(Code::request_data)) {
      if (s.frame.data[0] == 0) status.push_back(s.frame.address);
      if (s.frame.data[0] == 1) health.push_back(s.frame.address);
    }
    EXPECT_EQ(status, (std::vector<std::uint8_t>{1, 2, 3, 4, 5, 6, 7}));
    EXPECT_EQ(health.size(), 1u);
  }
  std::multiset<std::uint8_t> health;
  world.sent.clear();
  world.run_frames(14);
  for (const Sent& s : world.sent_with(Code::request_data)) {
    if (s.frame.data[0] == 1) health.insert(s.frame.address);
  }
  for (std::uint8_t address = 1; address <= 7; ++address) EXPECT_EQ(health.count(address), 2u);
}

TEST(LegBus, AsksForIdentityAtFirstContactThenSeldomAndAfterAReset) {
  World world;
  const auto identities = [&world](std::uint8_t address) {
    const auto all = world.sent_to(address, Code::request_data);
    return std::count_if(all.begin(), all.end(),
                         [](const Sent& s) { return s.frame.data[0] == 2; });
  };
  world.run_frames(10);
  for (std::uint8_t address = 1; address <= 7; ++address) EXPECT_EQ(identities(address), 1);
  world.run_frames(54);
  world.sent.clear();
  world.run_frames(64);
  for (std::uint8_t address = 1; address <= 7; ++address) EXPECT_EQ(identities(address), 1);
  world.sent.clear();
  world.module[2].boot_ns = world.now;
  world.module[2].reset_since_status = true;
  world.run_frames(3);
  EXPECT_EQ(identities(3), 1);
}

TEST(LegBus, CommandsGoBeforePolls) {
  World world;
  world.settle();
  world.order(4, Kind::motion_on);
  world.run_frames(1);
  EXPECT_EQ(world.sent[0].frame, command(5, Code::start_motion_control));
}

// [S-Int-1] [S-Int-2]
TEST(LegBus, AddressesAreThoseOfTheConfiguration) {
  LegBusParameters p;
  p.address = {17, 16, 15, 14, 13, 12, 11};
  World world(p);
  world.settle();
  world.order(0, Kind::motion_on);
  world.run_frames(2);
  EXPECT_EQ(world.sent[0].frame.address, 17);
  EXPECT_TRUE(world.module[0].on);
}

TEST(LegBus, TheDeltaTimeEndsAtTheArrivalWheneverTheFrameGoesOut) {
  World world;
  world.settle();
  for (TestModule& m : world.module) m.on = true;
  const TimeNs arrive_ns = world.now + 3 * kSecond;
  for (int m = 0; m < kBusModules; ++m) world.order(m, Kind::rotate_forward, 9'000, arrive_ns);
  world.run_frames(1);
  const auto rotations = world.sent_with(Code::rotate_forward);
  ASSERT_EQ(rotations.size(), 7u);
  for (const Sent& s : rotations) {
    const TimeNs delta_ns = (s.frame.data[2] * 256 + s.frame.data[3]) * kMillisecond;
    EXPECT_LE(std::abs(s.end_ns + delta_ns - arrive_ns), kMillisecond);
  }
}

TEST(LegBus, TheDeltaTimeStaysInItsSixteenBits) {
  World world;
  world.settle();
  for (TestModule& m : world.module) m.on = true;
  world.order(0, Kind::rotate_forward, 9'000, world.now - kSecond);
  world.order(1, Kind::rotate_backward, 9'000, world.now + 100 * kSecond);
  world.run_frames(1);
  EXPECT_EQ(world.sent[0].frame, rotate(1, Code::rotate_forward, 9'000, 1));
  EXPECT_EQ(world.sent[1].frame, rotate(2, Code::rotate_backward, 9'000, 65'535));
}

class LegBusEmergency : public ::testing::TestWithParam<bool> {};

// At any moment of the cycle.
TEST_P(LegBusEmergency, AnEmergencyOvertakesEverythingThatIsNotWritten) {
  const bool half_duplex = GetParam();
  const LegBusParameters p = with(115'200, half_duplex);
  for (TimeNs offset = 0; offset < p.period_ns; offset += 700 * kMicrosecond) {
    World world(p);
    world.settle();
    for (TestModule& m : world.module) m.on = true;
    world.release();
    world.run_for(offset);
    world.sent.clear();
    world.emergency();
    for (int m = 0; m < kBusModules; ++m) world.order(m, Kind::emergency_stop);
    const TimeNs ordered_ns = world.now;
    world.release();
    world.run_for(p.period_ns);
    ASSERT_GE(world.sent.size(), 8u);
    for (std::uint8_t address = 0; address <= kBusModules; ++address) {
      EXPECT_EQ(world.sent[address].frame, command(address, Code::emergency_stop));
    }
    const TimeNs reply_ns = half_duplex ? world.frame_ns + 100 * kMicrosecond : 0;
    EXPECT_LE(world.sent[0].start_ns - ordered_ns, 2 * world.frame_ns + reply_ns) << offset;
    EXPECT_LE(world.sent[7].end_ns - ordered_ns, 10 * world.frame_ns + reply_ns) << offset;
    for (const TestModule& m : world.module) EXPECT_FALSE(m.on);
    EXPECT_FALSE(world.too_far_ahead);
  }
}

INSTANTIATE_TEST_SUITE_P(Lines, LegBusEmergency, ::testing::Bool(), [](const auto& line) {
  return std::string(line.param ? "half" : "full");
});

// Its content was requested before the emergency; so late it may be from before a start.
TEST(LegBus, AnEmergencyStopGoesToEachModuleAlsoWhenItIsJustSayingThatItIsOff) {
  const LegBusParameters p = with(115'200, false);
  for (TimeNs offset = 0; offset < p.period_ns; offset += 700 * kMicrosecond) {
    World world(p, 110);
    world.settle();
    world.release();
    world.run_for(offset);
    world.sent.clear();
    world.emergency();
    for (int m = 0; m < kBusModules; ++m) world.order(m, Kind::emergency_stop);
    world.release();
    world.run_for(p.period_ns);
    ASSERT_GE(world.sent.size(), 8u);
    for (std::uint8_t address = 0; address <= kBusModules; ++address) {
      EXPECT_EQ(world.sent[address].frame, command(address, Code::emergency_stop)) << offset;
    }
  }
}

TEST(LegBus, AnEmergencyEndsOldMotionOrdersAndLetsNewOnesThrough) {
  World world;
  world.settle();
  world.order(0, Kind::motion_on);
  world.order(1, Kind::motion_on);
  world.run_frames(5);
  world.sent.clear();
  world.emergency();
  world.order(1, Kind::motion_on);  // given with the emergency: after it
  world.run_frames(5);
  EXPECT_EQ(world.sent[0].frame, command(kBroadcast, Code::emergency_stop));
  EXPECT_FALSE(world.module[0].on);
  EXPECT_TRUE(world.module[1].on);
  EXPECT_TRUE(world.sent_to(1, Code::start_motion_control).empty());
  EXPECT_EQ(world.bus.counters().module[1].resends, 0u);
}

TEST(LegBus, StaleOrdersStopEverythingOnceASecondAndPollingGoesOn) {
  World world;
  world.settle();
  for (int m = 0; m < kBusModules; ++m) world.order(m, Kind::motion_on);
  world.run_frames(5);
  for (const TestModule& m : world.module) ASSERT_TRUE(m.on);
  world.release();
  const TimeNs released_ns = world.now;
  world.sent.clear();
  world.run_for(3500 * kMillisecond);

  const auto broadcasts = world.sent_to(kBroadcast, Code::emergency_stop);
  ASSERT_EQ(broadcasts.size(), 4u);
  EXPECT_GT(broadcasts[0].start_ns - released_ns, world.parameters.stale_after_ns);
  EXPECT_LE(broadcasts[0].start_ns - released_ns,
            world.parameters.stale_after_ns + 2 * world.frame_ns);
  EXPECT_EQ(world.bus.counters().safe_commands, 4u);
  for (std::uint8_t address = 1; address <= 7; ++address) {
    EXPECT_EQ(world.sent_to(address, Code::emergency_stop).size(), 4u);
    EXPECT_GT(world.sent_to(address, Code::request_data).size(), 80u);  // every 40 ms
  }
  for (const TestModule& m : world.module) EXPECT_FALSE(m.on);
}

TEST(LegBus, AfterStaleOrdersTheSameOrdersDoNotMoveAnything) {
  World world;
  world.settle();
  world.order(0, Kind::motion_on);
  world.run_frames(5);
  world.run_for(200 * kMillisecond);
  world.sent.clear();
  world.run_frames(20);
  EXPECT_FALSE(world.module[0].on);
  EXPECT_TRUE(world.sent_with(Code::start_motion_control).empty());
  world.order(0, Kind::motion_on);
  world.run_frames(2);
  EXPECT_TRUE(world.module[0].on);
}

// Neither the first ones, nor those after the stop of the first.
TEST(LegBus, OrdersThatAreStaleWhenTheyComeAreNotSent) {
  World world;
  world.settle();
  for (int time = 0; time < 3; ++time) {
    world.order(0, Kind::motion_on);
    world.orders.issued_ns = world.now - 150 * kMillisecond;
    world.bus.release(world.orders, world.now);
    world.run_for(20 * kMillisecond);
    EXPECT_TRUE(world.sent_with(Code::start_motion_control).empty()) << time;
    EXPECT_EQ(world.sent[0].frame, command(kBroadcast, Code::emergency_stop));
  }
}

TEST(LegBus, WhenThePortComesBackItStopsAllAndStartsNoMotionAgain) {
  World world;
  world.settle();
  world.order(0, Kind::motion_on);
  world.run_frames(5);
  world.order(0, Kind::rotate_forward, 9'000, world.now + 5 * kSecond);
  world.run_frames(2);
  world.sent.clear();
  world.bus.restart(world.now);
  world.run_frames(50);
  EXPECT_EQ(world.sent[0].frame, command(kBroadcast, Code::emergency_stop));
  EXPECT_FALSE(world.module[0].on);
  EXPECT_TRUE(world.sent_with(Code::start_motion_control).empty());
  EXPECT_TRUE(world.sent_with(Code::rotate_forward).empty());
}

class LegBusTooShort : public ::testing::TestWithParam<bool> {};

TEST_P(LegBusTooShort, InAPeriodTooShortForAllNoModuleAndNoPageStarves) {
  LegBusParameters p = with(115'200, GetParam());
  p.period_ns = 10 * kMillisecond;
  World world(p);
  world.run_frames(700);
  std::array<int, 7> status{}, health{};
  for (const Sent& s : world.sent_with(Code::request_data)) {
    const TimeNs into_cycle_ns = (s.start_ns - kSecond) % p.period_ns;  // the world begins at 1 s
    EXPECT_LE(into_cycle_ns + (p.half_duplex ? 2 : 1) * world.frame_ns, p.period_ns);
    auto& count = s.frame.data[0] == 0 ? status : health;
    if (s.frame.data[0] < 2) ++count[s.frame.address - 1u];
  }
  const auto [status_min, status_max] = std::minmax_element(status.begin(), status.end());
  EXPECT_LE(*status_max - *status_min, 8);
  EXPECT_GT(*status_min, 100);
  EXPECT_GT(*std::min_element(health.begin(), health.end()), 20);
  EXPECT_FALSE(world.too_far_ahead);
}

INSTANTIATE_TEST_SUITE_P(Lines, LegBusTooShort, ::testing::Bool(), [](const auto& line) {
  return std::string(line.param ? "half" : "full");
});

TEST(LegBus, AtMostTheNewestRepliesAreKept) {
  World world;
  world.settle();
  const std::uint64_t before = world.bus.counters().frames_received;
  for (int n = 0; n < 10; ++n) {
    world.release();
    world.run_for(world.parameters.period_ns);
  }
  const auto replies = world.take_all();
  ASSERT_EQ(replies.size(), LegBus::kMaxReplies);
  EXPECT_GT(replies.front().time_ns, world.now - 5 * world.parameters.period_ns);
  EXPECT_EQ(world.bus.counters().overflows,
            world.bus.counters().frames_received - before - LegBus::kMaxReplies);
  EXPECT_EQ(world.bus.counters().frames_dropped, world.bus.counters().overflows);
}

}  // namespace
}  // namespace lss::zebro
