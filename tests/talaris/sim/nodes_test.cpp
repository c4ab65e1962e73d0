// Valves, fans and load cell by their frames (ICD sections 5 to 7).

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/talaris/sim/hopper_master.h"

namespace lss::sim::talaris {
namespace {

using testing::Contains;
using testing::Not;
using testing::StartsWith;

class TalarisNodes : public testing::Test {
 protected:
  void bring_up() {
    ASSERT_TRUE(master_.bring_up());
    master_.heard.clear();
  }
  unsigned outputs() const { return world_.valve_node().outputs(); }
  bool fans_off() const {
    return world_.fan_node().pulse_us() == std::array<std::uint16_t, 4>{1000, 1000, 1000, 1000};
  }
  void open_and_spin() {
    master_.valves(0x55);
    master_.fan_us.fill(1500);
    master_.run(100);
    ASSERT_EQ(outputs(), 0x55u);
    ASSERT_FALSE(fans_off());
  }

  void bring_up_and_spin() {
    bring_up();
    open_and_spin();
  }
  // The commanded valves are open after `open_ms` and shut after `shut_ms`.
  void expect_shut_between(int open_ms, int shut_ms) {
    master_.run(open_ms);
    EXPECT_EQ(outputs(), 0x55u);
    master_.run(shut_ms - open_ms);
    EXPECT_EQ(outputs(), 0u);
  }

  Talaris world_{{.fans = {.started = true}}};
  Master master_{world_};
};

TEST_F(TalarisNodes, BootAndSayWhatTheyAre) {
  master_.run(200);
  EXPECT_THAT(master_.heard, testing::AllOf(Contains("720 [1] 00"), Contains("721 [1] 00")));
  EXPECT_THAT(master_.heard, Not(Contains("722 [1] 00")));
  EXPECT_EQ(master_.ask("620 [8] 40 00 10 00 00 00 00 00"), "5A0 [8] 43 00 10 00 91 01 06 00");
  EXPECT_EQ(master_.ask("621 [8] 40 00 10 00 00 00 00 00"), "5A1 [8] 43 00 10 00 91 01 0C 00");
  EXPECT_EQ(master_.ask("620 [8] 40 FF 5F 00 00 00 00 00"), "5A0 [8] 80 FF 5F 00 00 00 02 06");
}

TEST_F(TalarisNodes, TheGoldenFramesOpenAndShutValves) {
  bring_up();
  master_.tell("220 [2] 55 06");
  EXPECT_EQ(outputs(), 0x55u);
  master_.tell("220 [2] 00 00");
  EXPECT_EQ(outputs(), 0u);
  master_.tell("220 [2] FF 00");  // sequence 0 shuts in any case
  EXPECT_EQ(outputs(), 0u);
  master_.tell("221 [8] A4 06 A4 06 AE 06 9A 06");
  EXPECT_EQ(world_.fan_node().pulse_us(), (std::array<std::uint16_t, 4>{1700, 1700, 1710, 1690}));
  master_.tell("221 [8] 00 00 FF FF E8 03 E8 03");  // cut
  EXPECT_EQ(world_.fan_node().pulse_us(), (std::array<std::uint16_t, 4>{1000, 2000, 1000, 1000}));
}

TEST_F(TalarisNodes, ARepetitionIsNotObeyedAndAGapIsCounted) {
  bring_up();
  master_.tell("220 [2] 01 FE");
  master_.tell("220 [2] 02 FE");
  EXPECT_EQ(outputs(), 0x01u);
  master_.tell("220 [2] 04 FF");
  master_.tell("220 [2] 08 01");  // 255 is followed by 1
  EXPECT_EQ(outputs(), 0x08u);
  EXPECT_EQ(world_.valve_node().gaps(), 0u);
  master_.tell("220 [2] 10 04");
  EXPECT_EQ(outputs(), 0x10u);
  EXPECT_EQ(world_.valve_node().gaps(), 2u);
}

TEST_F(TalarisNodes, NothingOpensBeforeTheyAreOperational) {
  master_.run(300);
  master_.tell("220 [2] 55 06");
  master_.run(5);
  EXPECT_EQ(outputs(), 0u);
}

TEST_F(TalarisNodes, ValvesShutWithin100msOfTheLastHeartbeat) {
  bring_up_and_spin();
  master_.heartbeat = false;
  expect_shut_between(74, 104);
  EXPECT_TRUE(fans_off());
  EXPECT_THAT(master_.heard, Contains("0A0 [8] 30 81 11 00 00 00 00 00"));
  master_.run(60);
  EXPECT_EQ(master_.last[0x720].data[0], 0x7F);
  EXPECT_EQ(world_.gas().open(), 0);
}

TEST_F(TalarisNodes, ValvesThatAreNotRenewedShutAfter250msAndObeyAgain) {
  bring_up_and_spin();
  master_.renew_valves = false;
  expect_shut_between(195, 255);
  EXPECT_FALSE(fans_off());
  EXPECT_THAT(master_.heard, Contains("0A0 [8] 50 82 11 00 00 00 00 00"));
  master_.valves(0x01);
  EXPECT_EQ(outputs(), 0x01u);
  master_.run(20);
  EXPECT_THAT(master_.heard, Contains("0A0 [8] 00 00 00 00 00 00 00 00"));
}

TEST_F(TalarisNodes, RepetitionsOfAFrameDoNotRenewIt) {
  bring_up();
  master_.renew_valves = false;
  for (int i = 0; i < 20; ++i) {
    master_.tell("220 [2] 01 33");
    master_.run(20);
  }
  EXPECT_EQ(outputs(), 0u);
}

TEST_F(TalarisNodes, FansThatAreNotRenewedGoOff) {
  bring_up_and_spin();
  master_.renew_fans = false;
  master_.run(280);
  EXPECT_TRUE(fans_off());
  EXPECT_EQ(outputs(), 0x55u);
  EXPECT_THAT(master_.heard, Contains("0A1 [8] 50 82 11 00 00 00 00 00"));
}

TEST_F(TalarisNodes, WithoutTheMasterFansSlowDownEvenlyAndObeyAgain) {
  bring_up();
  ASSERT_EQ(master_.write(0x21, 0x2202, 0, 2, 1'000), 0u);
  open_and_spin();
  master_.heartbeat = master_.renew_fans = false;
  master_.run(110);
  EXPECT_EQ(outputs(), 0u);
  const int begin_us = world_.fan_node().pulse_us()[0];
  EXPECT_GT(begin_us, 1'450);
  master_.run(300);
  EXPECT_NEAR(world_.fan_node().pulse_us()[0], begin_us - 300, 2);
  master_.run(300);
  EXPECT_TRUE(fans_off());
}

TEST_F(TalarisNodes, FansThatAreNotRenewedSlowDown) {
  bring_up();
  ASSERT_EQ(master_.write(0x21, 0x2202, 0, 2, 1'000), 0u);
  open_and_spin();
  master_.renew_fans = false;
  master_.run(380);
  EXPECT_NEAR(world_.fan_node().pulse_us()[0], 1'370, 40);
  master_.renew_fans = true;
  master_.run(60);
  EXPECT_EQ(world_.fan_node().pulse_us()[0], 1'500);
}

TEST_F(TalarisNodes, EveryWayOutOfOperationalShutsAndStops) {
  for (const char* command : {"02", "80", "81", "82"}) {
    Talaris world({.fans = {.started = true}});
    Master master(world);
    ASSERT_TRUE(master.bring_up());
    master.valves(0x55);
    master.fan_us.fill(1500);
    master.run(50);
    ASSERT_EQ(world.valve_node().outputs(), 0x55u);
    master.tell(fmt::format("000 [2] {} 00", command));
    EXPECT_EQ(world.valve_node().outputs(), 0u) << command;
    EXPECT_EQ(world.fan_node().pulse_us()[0], 1000) << command;
  }
}

TEST_F(TalarisNodes, PressuresComeFiveTimesASecondAndSpeedsFifty) {
  bring_up();
  master_.run(2'000);
  EXPECT_NEAR(master_.count("2A0 [8]"), 10, 1);
  EXPECT_NEAR(master_.count("1A1 [8]"), 100, 2);
  EXPECT_NEAR(u16_at(master_.last[0x2A0], 0), 31'026, 60);
  EXPECT_NEAR(u16_at(master_.last[0x2A0], 2), 4'137, 30);
  EXPECT_NEAR(u16_at(master_.last[0x2A0], 4), 5'180, 15);
  EXPECT_NEAR(i16_at(master_.last[0x2A0], 6), 215, 6);
}

TEST_F(TalarisNodes, SpeedsComeInStepsOf200) {
  bring_up();
  master_.fan_us = {1500, 1480, 1460, 1000};
  master_.run(3'000);
  const CanFrame& speeds = master_.last[0x1A1];
  EXPECT_NEAR(u16_at(speeds, 0), 16'500, 100);
  EXPECT_NEAR(u16_at(speeds, 2), 15'840, 100);
  EXPECT_EQ(u16_at(speeds, 6), 0);
  for (const std::size_t at : {0u, 2u, 4u}) EXPECT_EQ(u16_at(speeds, at) % 200, 0);
}

TEST(TalarisLoadCell, AtStandstillShowsAnOffsetThatWalksAndDependsOnTheSeed) {
  std::array<double, 2> force_N{};
  for (const unsigned seed : {0u, 1u}) {
    Talaris world({.plant = {.stand = Stand::load}, .seed = seed});
    Master master(world);
    ASSERT_TRUE(master.bring_up({0x20, 0x21, 0x22}));
    const auto before = world.load_cell().offset();
    double moment_Nm = 0;
    for (int i = 0; i < 500; ++i) {
      master.run(2);
      force_N[seed] += i16_at(master.last[0x1A2], 0) * 0.1 / 500;
      moment_Nm += i16_at(master.last[0x2A2], 2) * 0.01 / 500;
    }
    EXPECT_NEAR(force_N[seed], before[0], 0.15);
    EXPECT_NEAR(moment_Nm, before[4], 0.015);
    EXPECT_NE(world.load_cell().offset(), before);
  }
  EXPECT_NE(force_N[0], force_N[1]);
}

TEST(TalarisLoadCell, RingsAtSevenHertzAboutTheForce) {
  Talaris world({.plant = {.stand = Stand::load}});
  Master master(world);
  ASSERT_TRUE(master.bring_up({0x20, 0x21, 0x22}));
  master.valves(0x01);
  master.heard.clear();
  std::vector<double> force_N;
  for (int i = 0; i < 1'000; ++i) {
    master.run(2);
    force_N.push_back(i16_at(master.last[0x1A2], 0) * 0.1 - world.load_cell().offset()[0]);
  }
  EXPECT_NEAR(master.count("1A2 [6]"), 1'000, 1);
  EXPECT_NEAR(master.count("2A2 [6]"), 1'000, 1);
  EXPECT_GT(*std::ranges::max_element(force_N), 58 * 1.7);  // overshoot, hardly damped
  double last_s = 0;
  for (std::size_t i = 750; i < 1'000; ++i) last_s += force_N[i] / 250;
  EXPECT_NEAR(last_s, 58, 2);
  int crossings = 0;
  for (std::size_t i = 20; i < 500; ++i) {
    if ((force_N[i - 1] < 58) != (force_N[i] < 58)) ++crossings;
  }
  EXPECT_NEAR(crossings / 2.0 / 0.96, 7, 0.8);
  // Valve 1 at (-0.30, -0.40) lifts: moments about y and z.
  EXPECT_LT(i16_at(master.last[0x2A2], 2), 0);
  EXPECT_GT(i16_at(master.last[0x2A2], 4), 0);
}

}  // namespace
}  // namespace lss::sim::talaris
