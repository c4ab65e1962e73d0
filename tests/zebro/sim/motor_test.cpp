// The motor against the measurements of the Zebro thesis (appendix A).

#include "tools/lss-sim/zebro/motor.h"

#include <gtest/gtest.h>

namespace lss::sim::zebro {
namespace {

double leg_speed_rad_s(double rpm) { return rpm * motor::kRpm_rad_s / motor::kGear; }

TEST(GearMotor, DrawsTheMeasuredCurrentWithoutLoad) {
  EXPECT_NEAR(motor::current_A(0, leg_speed_rad_s(24'172)), 0.189, 1e-6);
}

TEST(GearMotor, HasNoTorqueLeftAtItsNoLoadSpeed) {
  EXPECT_NEAR(motor::torque_limit_Nm(leg_speed_rad_s(24'172)), 0, 1e-6);
  EXPECT_GT(motor::torque_limit_Nm(leg_speed_rad_s(20'000)), 0.05);
}

TEST(GearMotor, StallsNearTheMeasuredTorque) {
  EXPECT_NEAR(motor::torque_limit_Nm(0), 0.860, 0.05);
  EXPECT_GT(motor::current_A(motor::torque_limit_Nm(0), 0), motor::kCurrentLimit_A);
}

TEST(GearMotor, TurnsALegOnceInThreeSecondsAtItsLimit) {
  EXPECT_NEAR(motor::kMaxSpeed_rad_s * 180 / std::numbers::pi, 117.2, 0.1);
}

Heat after_half_an_hour(double rpm) {
  Heat heat;
  for (int i = 0; i < 18'000; ++i) heat.step(0, leg_speed_rad_s(rpm), 0.1);
  return heat;
}

TEST(Heat, ReachesTheTemperaturesOfTableA1) {
  const Heat slow = after_half_an_hour(5'000);
  EXPECT_NEAR(slow.motor_degC(), 33.5, 0.3);
  EXPECT_NEAR(slow.gear_degC(), 31.5, 0.3);
  const Heat fast = after_half_an_hour(10'000);
  EXPECT_NEAR(fast.motor_degC(), 39.2, 0.3);
  EXPECT_NEAR(fast.gear_degC(), 32.4, 0.3);
}

TEST(Heat, AStalledMotorWarmsFasterThanATurningOne) {
  Heat stalled, turning;
  for (int i = 0; i < 600; ++i) {
    stalled.step(0.8, 0, 0.1);
    turning.step(0, motor::kMaxSpeed_rad_s, 0.1);
  }
  EXPECT_GT(stalled.motor_degC(), turning.motor_degC() + 20);
}

}  // namespace
}  // namespace lss::sim::zebro
