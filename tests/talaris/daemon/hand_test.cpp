// Valves and fans by hand (TALARIS thesis 4.4.6, 4.4.8).

#include <gtest/gtest.h>

#include "idl/talaris/codes.h"
#include "world.h"

namespace lss::talaris {
namespace {

TEST(TalarisHand, AValveIsOpenForItsTimeAndThenShutsByItself) {
  World w;
  ASSERT_TRUE(w.start());
  ASSERT_EQ(w.why(Kind::valve, {0b101, 1, 1.5}), Reason::none);
  const TimeNs opened_ns = w.orders().release_ns;
  EXPECT_TRUE(w.orders().hold[0].open && w.orders().hold[2].open);
  EXPECT_FALSE(w.orders().hold[1].open);
  EXPECT_EQ(w.orders().hold[0].until_ns, opened_ns + 1500 * kMillisecond);
  ASSERT_TRUE(w.run_until([&] { return w.shut(); }, 3));
  EXPECT_EQ(w.orders().release_ns, opened_ns + 1600 * kMillisecond);
  w.step();
  ASSERT_NE(w.heard(events::valve_timed_out), nullptr);
  EXPECT_EQ(w.heard(events::valve_timed_out)->argument[0], 0b101);
}

TEST(TalarisHand, AValveIsShutByHandAtOnce) {
  World w;
  ASSERT_TRUE(w.start());
  ASSERT_EQ(w.why(Kind::valve, {0xFF, 1, 30}), Reason::none);
  ASSERT_EQ(w.why(Kind::valve, {0x0F, 0, 1}), Reason::none);
  EXPECT_FALSE(w.orders().hold[3].open);
  EXPECT_TRUE(w.orders().hold[4].open);
  w.run(2);
  EXPECT_EQ(w.heard(events::valve_timed_out), nullptr);
}

TEST(TalarisHand, GasIsCountedByHandToo) {
  World w;
  ASSERT_TRUE(w.start());
  const double before_s = w.out_.telemetry.gas_left_thruster_s;
  ASSERT_EQ(w.why(Kind::valve, {0b11, 1, 2.5}), Reason::none);
  w.run(4);
  EXPECT_NEAR(w.out_.telemetry.gas_left_thruster_s, before_s - 5, 1e-6);
  EXPECT_NEAR(w.gas_s, 5, 0.02);
}

TEST(TalarisHand, PulsesAreRepeatedForTheFramesAskedFor) {
  World w;
  ASSERT_TRUE(w.start());
  ASSERT_EQ(w.why(Kind::duty_cycle), Reason::none);
  ASSERT_EQ(w.why(Kind::pulse, {0b1001, 0.12, 0.05, 3}), Reason::none);
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(w.orders().pulse[0].on_ns, 120 * kMillisecond);
    EXPECT_EQ(w.orders().pulse[0].delay_ns, 50 * kMillisecond);
    EXPECT_EQ(w.orders().pulse[3].on_ns, 120 * kMillisecond);
    EXPECT_EQ(w.orders().pulse[1].on_ns, 0);
    w.step();
  }
  EXPECT_TRUE(w.shut());
}

// Each of both is rounded to ms; an accepted pulse must not become longer than the frame.
TEST(TalarisHand, APulseThatEndsWithTheFrameStaysWithinIt) {
  for (const auto& [on_s, delay_s] : {std::pair{0.1995, 0.0005}, {0.0405, 0.1595}}) {
    World w;
    ASSERT_TRUE(w.start());
    ASSERT_EQ(w.why(Kind::duty_cycle), Reason::none);
    ASSERT_EQ(w.why(Kind::pulse, {1, on_s, delay_s, 1}), Reason::none);
    EXPECT_EQ(w.state(), State::operational);
    EXPECT_EQ(w.orders().pulse[0].delay_ns + w.orders().pulse[0].on_ns, kFrame);
    EXPECT_EQ(w.supervisor_.state().safe_commands, 0u);
  }
}

TEST(TalarisHand, AValveThatIsDisabledWhileItIsOpenShuts) {
  World w;
  ASSERT_TRUE(w.start());
  ASSERT_EQ(w.why(Kind::valve, {0b11, 1, 30}), Reason::none);
  ASSERT_EQ(w.why(Kind::enable, {0b10}), Reason::none);
  EXPECT_FALSE(w.orders().hold[0].open);
  EXPECT_TRUE(w.orders().hold[1].open);
  w.run(1);
  EXPECT_EQ(w.state(), State::operational);
  EXPECT_EQ(w.supervisor_.state().safe_commands, 0u);
}

TEST(TalarisHand, PulsesOfAValveThatIsDisabledEnd) {
  World w;
  ASSERT_TRUE(w.start());
  ASSERT_EQ(w.why(Kind::duty_cycle), Reason::none);
  ASSERT_EQ(w.why(Kind::pulse, {0b11, 0.1, 0, 100}), Reason::none);
  ASSERT_EQ(w.why(Kind::enable, {0b10}), Reason::none);
  EXPECT_EQ(w.orders().pulse[0], ValvePulse{});
  EXPECT_EQ(w.orders().pulse[1].on_ns, 100 * kMillisecond);
  ASSERT_EQ(w.why(Kind::enable, {0b100}), Reason::none);
  EXPECT_TRUE(w.shut());
  ASSERT_EQ(w.why(Kind::enable, {0xFF}), Reason::none);
  EXPECT_TRUE(w.shut()) << "they are over";
  EXPECT_EQ(w.state(), State::operational);
}

// 2 ms for 380 ms, then 1 ms (TALARIS thesis 4.4.8); frames are whole.
TEST(TalarisHand, TheStartUpOfTheFansIsFullThrottleForTwoFrames) {
  World w;
  ASSERT_TRUE(w.start());
  ASSERT_EQ(w.why(Kind::edf_arm, {0}), Reason::none);
  for (int i = 0; i < 2; ++i) {
    for (const std::uint16_t us : w.orders().fan_us) EXPECT_EQ(us, 2000);
    EXPECT_FALSE(w.out_.telemetry.fans[0].armed);
    w.step();
  }
  EXPECT_TRUE(w.shut());
  w.step();
  EXPECT_TRUE(w.out_.telemetry.fans[0].armed);
  EXPECT_NE(w.heard(events::fans_armed), nullptr);
  EXPECT_EQ(w.last(lss::Phase::completed)->kind, 306);
  EXPECT_EQ(w.supervisor_.state().safe_commands, 0u);
}

TEST(TalarisHand, FansComeToTheSpeedAskedFor) {
  World w;
  ASSERT_TRUE(w.start());
  ASSERT_TRUE(w.arm());
  w.run(2);
  ASSERT_EQ(w.why(Kind::edf_rpm, {0b0011, 12000, 4000}), Reason::none);
  EXPECT_LT(w.rpm[0], 4000) << "by a ramp";
  w.run(8);
  EXPECT_NEAR(w.rpm[0], 12000, 200);
  EXPECT_NEAR(w.rpm[1], 12000, 200);
  EXPECT_EQ(w.orders().fan_us[2], 1000);
  EXPECT_EQ(w.out_.telemetry.fans[0].target_rpm, 12000);
  ASSERT_EQ(w.why(Kind::edf_rpm, {0b0001, 0, 4000}), Reason::none);
  w.step();
  EXPECT_EQ(w.orders().fan_us[0], 1000);
  EXPECT_GT(w.orders().fan_us[1], 1200);
}

TEST(TalarisHand, AThrottleGoesUpAsFastAsTheConfigAllowsAndDownAtOnce) {
  Parameters p = quick();
  p.fan_slew_us_s = 1000;
  World w(p);
  ASSERT_TRUE(w.start());
  ASSERT_TRUE(w.arm());
  ASSERT_EQ(w.why(Kind::edf_throttle, {15, 0.5}), Reason::none);
  EXPECT_EQ(w.orders().fan_us[0], 1200);
  w.step();
  EXPECT_EQ(w.orders().fan_us[0], 1400);
  w.step();
  EXPECT_EQ(w.orders().fan_us[0], 1500);
  ASSERT_EQ(w.why(Kind::edf_throttle, {15, 0}), Reason::none);
  EXPECT_EQ(w.orders().fan_us[0], 1000);
  EXPECT_EQ(w.supervisor_.state().safe_commands, 0u);
}

TEST(TalarisHand, LeavingManualShutsWhatWasOpen) {
  for (const auto next : {Kind::duty_cycle, Kind::gnc}) {
    World w;
    ASSERT_TRUE(w.start());
    ASSERT_TRUE(w.arm());
    ASSERT_EQ(w.why(Kind::valve, {1, 1, 30}), Reason::none);
    ASSERT_EQ(w.why(Kind::edf_throttle, {15, 0.3}), Reason::none);
    EXPECT_FALSE(w.shut());
    ASSERT_EQ(w.why(next, {0}), Reason::none);
    EXPECT_TRUE(w.shut());
    w.run(1);
    EXPECT_TRUE(w.shut());
  }
}

}  // namespace
}  // namespace lss::talaris
