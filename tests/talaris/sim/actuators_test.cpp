// Cold gas and fans by themselves.

#include <gtest/gtest.h>

#include "tools/lss-sim/talaris/fans.h"
#include "tools/lss-sim/talaris/gas.h"

namespace lss::sim::talaris {
namespace {

// The impulse of a pulse of `ms` of these valves, along and about the axes of B.
Wrench impulse(ColdGas& gas, std::uint8_t valves, int ms) {
  Wrench sum;
  for (int i = 0; i < ms + 40; ++i) {
    gas.step(i < ms ? valves : 0);
    const Wrench now = gas.wrench();
    sum.force_N += now.force_N * kStep_s;
    sum.torque_Nm += now.torque_Nm * kStep_s;
  }
  return sum;
}

TEST(TalarisGas, TheImpulseOfAPulseIsThrustTimesOnTime) {
  for (const double thrust : {58.0, 40.0}) {
    for (const int ms : {40, 73, 160}) {
      ColdGas gas({.thrust_N = thrust});
      EXPECT_NEAR(impulse(gas, 0x01, ms).force_N.x(), thrust * ms * 1e-3, 1e-9);
    }
  }
}

TEST(TalarisGas, ForceComesAndGoesAfterTheLags) {
  ColdGas gas({.open_lag_ms = 8, .close_lag_ms = 12, .travel_ms = 1});
  int begin = -1, end = -1;
  for (int i = 0; i < 100; ++i) {
    gas.step(i < 40 ? 0x01 : 0x00);
    if (gas.open() != 0 && begin < 0) begin = i;
    if (gas.open() != 0) end = i;
  }
  EXPECT_EQ(begin, 8);
  EXPECT_EQ(end, 40 + 12 - 1);
}

TEST(TalarisGas, ValvesPushAndTurnAsTheyAreNumbered) {
  const auto of = [](std::uint8_t valves) {
    ColdGas gas({});
    return impulse(gas, valves, 100);
  };
  constexpr double kOne = 5.8;
  EXPECT_NEAR(of(0x55).force_N.x(), 4 * kOne, 1e-9);  // 1, 3, 5, 7 lift
  EXPECT_NEAR(of(0x55).torque_Nm.norm(), 0, 1e-9);
  EXPECT_NEAR(of(0x82).force_N.z(), 2 * kOne, 1e-9);           // 2, 8 ahead
  EXPECT_NEAR(of(0x28).force_N.z(), -2 * kOne, 1e-9);          // 4, 6 back
  EXPECT_NEAR(of(0x05).torque_Nm.z(), 2 * 0.30 * kOne, 1e-9);  // 1, 3: about +z
  EXPECT_NEAR(of(0x14).torque_Nm.y(), 2 * 0.40 * kOne, 1e-9);  // 3, 5: about +y
  EXPECT_NEAR(of(0x88).torque_Nm.x(), 2 * 0.30 * kOne, 1e-9);  // 8, 4: roll
  EXPECT_NEAR(of(0x22).torque_Nm.x(), -2 * 0.30 * kOne, 1e-9);
}

TEST(TalarisGas, TheTankLastsForItsThrusterSeconds) {
  ColdGas gas({});
  for (int i = 0; i < 9'000; ++i) gas.step(0x55);  // 4 x 9 s of 44
  EXPECT_NEAR(gas.used_s(), 36, 0.05);
  EXPECT_NEAR(gas.used_kg(), 2 * 36 / 44.0, 0.01);
  EXPECT_NEAR(gas.tank_kPa(), 31'026 * 8 / 44.0, 50);
  EXPECT_NEAR(gas.thrust_N(0), 58, 1e-9);
  for (int i = 0; i < 1'000; ++i) gas.step(0x55);
  EXPECT_LT(gas.thrust_N(0), 58);  // below the regulated pressure
  for (int i = 0; i < 10'000; ++i) gas.step(0x55);
  EXPECT_LT(gas.thrust_N(0), 5);
}

TEST(TalarisGas, ThrustMayFadeWithTheTank) {
  ColdGas gas({.fade = 0.2});
  for (int i = 0; i < 5'500; ++i) gas.step(0x55);  // half of it
  EXPECT_NEAR(gas.thrust_N(0), 58 * 0.9, 0.1);
}

TEST(TalarisGas, StuckValvesLeaksAndABadRegulator) {
  ColdGas gas({});
  gas.stuck_open[2] = true;
  gas.stuck_shut[0] = true;
  for (int i = 0; i < 50; ++i) gas.step(0x01);
  EXPECT_EQ(gas.open(), 0x04);
  gas.stuck_open[2] = false;
  for (int i = 0; i < 50; ++i) gas.step(0);
  const double used = gas.used_s();
  gas.leak_s_per_s = 2;
  for (int i = 0; i < 1'000; ++i) gas.step(0);
  EXPECT_NEAR(gas.used_s() - used, 2, 1e-6);
  gas.regulator = 0.5;
  for (int i = 0; i < 50; ++i) gas.step(0x02);
  EXPECT_NEAR(gas.thrust_N(1), 29, 1e-6);
}

class TalarisFans : public testing::Test {
 protected:
  void run(int ms, std::uint16_t us) {
    for (int i = 0; i < ms; ++i) fans_.step({us, us, us, us});
  }
  Fans fans_{FanOptions{}};
};

TEST_F(TalarisFans, NothingTurnsBeforeTheStartUpProcedure) {
  run(1'000, 1000);
  run(2'000, 1800);
  EXPECT_EQ(fans_.rpm(0), 0);
  EXPECT_FALSE(fans_.armed(0));
}

TEST_F(TalarisFans, TheStartUpProcedureTurnsNothingAndLeavesThemArmed) {
  run(380, 2000);
  EXPECT_EQ(fans_.rpm(0), 0);
  EXPECT_FALSE(fans_.armed(0));
  run(20, 1000);
  EXPECT_TRUE(fans_.armed(0));
  run(2'000, 1500);
  EXPECT_NEAR(fans_.rpm(0), 16'500, 20);
}

TEST_F(TalarisFans, BentSpeedIsNotLinearInTheThrottle) {
  Fans bent({.bend = 0.3, .started = true});
  for (int i = 0; i < 3'000; ++i) bent.step({1250, 1500, 1750, 2000});
  EXPECT_NEAR(bent.rpm(0), 33'000 * (0.25 + 0.3 * 3 / 16), 20);
  EXPECT_NEAR(bent.rpm(1), 33'000 * (0.5 + 0.3 / 4), 20);
  EXPECT_NEAR(bent.rpm(2), 33'000 * (0.75 + 0.3 * 3 / 16), 20);
  EXPECT_NEAR(bent.rpm(3), 33'000, 20);
}

TEST_F(TalarisFans, TooShortAStartUpIsNone) {
  run(300, 2000);
  run(1'000, 1000);
  EXPECT_FALSE(fans_.armed(0));
}

TEST_F(TalarisFans, DoneAgainItIsFullThrottle) {
  Fans started({.started = true});
  for (int i = 0; i < 380; ++i) started.step({2000, 2000, 2000, 2000});
  EXPECT_GT(started.rpm(0), 0.75 * 33'000);
}

TEST_F(TalarisFans, FiveSixthsOfTheWeightAt29384Rpm) {
  Fans fans({.max_rpm = 29'384, .started = true});
  for (int i = 0; i < 5'000; ++i) fans.step({2000, 2000, 2000, 2000});
  EXPECT_NEAR(fans.thrust_N(0), 91.97, 0.02);
  EXPECT_NEAR(fans.wrench().force_N.x(), 45 * kGravity_m_s2 * 5 / 6, 0.2);
  EXPECT_NEAR(fans.wrench().torque_Nm.norm(), 0, 1e-9);
}

TEST_F(TalarisFans, SpeedFollowsWithItsLag) {
  Fans fans({.lag_s = 0.25, .started = true});
  for (int i = 0; i < 250; ++i) fans.step({2000, 1000, 1000, 1000});
  EXPECT_NEAR(fans.rpm(0), 33'000 * (1 - std::exp(-1.0)), 50);
  EXPECT_EQ(fans.rpm(1), 0);
  EXPECT_LT(fans.wrench().torque_Nm.y(), -1);  // fan 1 at -y, -z
  EXPECT_GT(fans.wrench().torque_Nm.z(), 1);
}

TEST_F(TalarisFans, WithoutPulsesOrTorqueOrArmingTheyRunDown) {
  Fans fans({.started = true});
  for (int i = 0; i < 2'000; ++i) fans.step({1500, 1500, 1500, 1500});
  fans.dead[1] = true;
  fans.unarm(2);
  for (int i = 0; i < 2'000; ++i) fans.step({0, 1500, 1500, 1500});
  EXPECT_LT(fans.rpm(0), 50);
  EXPECT_LT(fans.rpm(1), 50);
  EXPECT_LT(fans.rpm(2), 50);
  EXPECT_NEAR(fans.rpm(3), 16'500, 20);
}

}  // namespace
}  // namespace lss::sim::talaris
