#include <gtest/gtest.h>

#include "tests/zebro/sim/bench.h"

namespace lss::sim::zebro {
namespace {

TEST(SimulatedModule, CountsFromZeroWhereItBootsAndIsNotCalibrated) {
  Bench bench(200);
  const Status status = bench.status();
  EXPECT_EQ(status.flags, kWasReset);
  EXPECT_NEAR(status.position_deg, 0, 0.01);
}

TEST(SimulatedModule, ReportsAResetOnceInTheFirstStatus) {
  Bench bench;
  EXPECT_TRUE(bench.status() & kWasReset);
  EXPECT_FALSE(bench.status() & kWasReset);
}

TEST(SimulatedModule, DoesNotMoveBeforeMotionControlIsOn) {
  Bench bench(200);
  bench.turn(+1, 90, 1, 2);
  EXPECT_NEAR(bench.shaft_deg(), 200, 0.01);
  EXPECT_FALSE(bench.status() & kMoving);
}

TEST(SimulatedModule, ArrivesWhenTheDeltaTimeIsOver) {
  Bench bench(200, kOn);
  bench.turn(+1, 90, 3, 1.5);
  EXPECT_NEAR(bench.status().position_deg, 45, 2);
  EXPECT_NEAR(bench.status().velocity_deg_s, 30, 3);
  EXPECT_TRUE(bench.status() & kMoving);
  bench.run(1.55);
  EXPECT_NEAR(bench.status().position_deg, 90, 0.5);
  EXPECT_FALSE(bench.status() & kMoving);
}

TEST(SimulatedModule, TurnsInTheCommandedSenseEvenWhenThatIsTheLongWay) {
  Bench bench(100, kOn);
  bench.turn(-1, 90, 4, 2);
  EXPECT_NEAR(bench.status().position_deg, 360 - 135, 3);
  bench.run(2.1);
  EXPECT_NEAR(bench.status().position_deg, 90, 0.5);
}

TEST(SimulatedModule, GoesBackInsteadOfOnceRoundWhenItPassedThePositionByLessThanFiveDegrees) {
  Bench bench(200, kOn);
  bench.turn(+1, 94, 2, 2.2);
  bench.turn(+1, 90, 2, 0.5);
  EXPECT_LT(bench.status().position_deg, 94.5);
  bench.run(2);
  EXPECT_NEAR(bench.status().position_deg, 90, 0.5);
}

TEST(SimulatedModule, MovesAtTheGearsLimitWhenTheTimeIsTooShort) {
  Bench bench(200, kOn);
  bench.turn(+1, 150, 0.2, 0.8);
  EXPECT_NEAR(bench.status().velocity_deg_s, 117.2, 8);
  bench.run(1.2);
  EXPECT_NEAR(bench.status().position_deg, 150, 0.5);
}

TEST(SimulatedModule, TakesOnTheTruePositionAtItsHallSensorAndGoesOnToTheSamePosition) {
  Bench bench(120);  // 60 deg before the sensor
  bench.start();
  bench.turn(+1, 100, 2, 0.5);
  EXPECT_FALSE(bench.status() & kCalibrated);
  bench.run(1.2);  // at 180 deg the position jumps from 60 to 180: 100 is 280 deg further on
  EXPECT_TRUE(bench.status() & kCalibrated);
  EXPECT_NEAR(bench.status().position_deg, bench.shaft_deg(), 0.5);
  bench.run(3);
  EXPECT_NEAR(bench.shaft_deg(), 100, 0.5);
  EXPECT_NEAR(bench.status().position_deg, 100, 0.5);
}

TEST(SimulatedModule, CalibratesBackwardsToo) {
  Bench bench(220, kOn);
  bench.turn(-1, 300, 1, 1.0);
  EXPECT_TRUE(bench.status() & kCalibrated);
  EXPECT_NEAR(bench.status().position_deg, bench.shaft_deg(), 0.5);
}

TEST(SimulatedModule, NeverCalibratesWithALostSensor) {
  Bench bench(120);
  bench.module.set_hall_broken(true);
  bench.start();
  bench.turn(+1, 200, 2, 2.1);
  bench.turn(+1, 10, 2, 2.1);
  EXPECT_FALSE(bench.status() & kCalibrated);
}

TEST(SimulatedModule, ThePanelIsCalibratedWhereItIsRetracted) {
  Bench bench(0, Power::off, 0);
  EXPECT_TRUE(bench.status() & kCalibrated);
  EXPECT_TRUE(bench.status() & kHallLevel);
}

TEST(SimulatedModule, EmergencyStopHoldsAtOnceAndAnyCommandMayFollow) {
  Bench bench(200, kOn);
  bench.turn(+1, 150, 3, 1);
  bench.module.handle(0x06, {}, false);  // to all
  const double stopped_deg = bench.shaft_deg();
  bench.run(1);
  EXPECT_NEAR(bench.shaft_deg(), stopped_deg, 0.01);
  EXPECT_FALSE(bench.status() & kMotionControl);
  bench.start();
  bench.turn(+1, 150, 1, 1.2);
  EXPECT_NEAR(bench.status().position_deg, 150, 0.5);
}

TEST(SimulatedModule, ObeysNothingButTheEmergencyStopWhenAllAreAddressed) {
  Bench bench;
  bench.module.handle(0x01, {}, false);
  EXPECT_FALSE(bench.status() & kMotionControl);
}

TEST(SimulatedModule, StopsItselfWhenNobodySpeaksToItForEightSeconds) {
  Bench bench(200, kOn);
  bench.run(7.9, false);
  EXPECT_TRUE(bench.module.motion_control());
  bench.run(0.2, false);
  EXPECT_FALSE(bench.module.motion_control());
  EXPECT_TRUE(bench.status() & kWatchdog);
  bench.start();
  EXPECT_FALSE(bench.status() & kWatchdog);
}

TEST(SimulatedModule, ABroadcastDoesNotFeedItsWatchdog) {
  Bench bench(200, kOn);
  for (int i = 0; i < 5; ++i) {
    bench.run(2, false);
    bench.module.handle(0x05, {}, false);
  }
  EXPECT_TRUE(bench.status() & kWatchdog);
}

TEST(SimulatedModule, ABlockedShaftDrawsTheLimitAndStopsTheModule) {
  Bench bench(200, kOn);
  bench.blocked = true;
  bench.turn(+1, 90, 1, 0.1);
  const Status status = bench.status();
  EXPECT_TRUE(status & kOverCurrent);
  EXPECT_FALSE(status & kMotionControl);
  bench.run(0.2);
  EXPECT_NEAR(bench.status().current_A, 0, 0.001);
  bench.start();
  EXPECT_FALSE(bench.status() & kOverCurrent);
}

TEST(SimulatedModule, ADriverFaultStopsItAgainUntilItIsReset) {
  Bench bench(200, kOn);
  bench.module.set_driver_broken(true);
  bench.run(0.01);
  EXPECT_TRUE(bench.status() & kDriverFault);
  bench.start();
  bench.run(0.01);
  EXPECT_FALSE(bench.status() & kMotionControl);
  bench.send(0x07);
  bench.run(0.3);
  bench.start();
  bench.run(0.01);
  EXPECT_TRUE(bench.status() & kMotionControl);
}

TEST(SimulatedModule, AfterAResetItIsSilentForABlinkAndHasForgottenItsCalibration) {
  Bench bench(170, kOn);
  bench.turn(+1, 30, 1, 1);
  ASSERT_TRUE(bench.status() & kCalibrated);
  bench.send(0x07);
  EXPECT_FALSE(bench.send(0x05).has_value());
  bench.run(0.3, false);
  const Status status = bench.status();
  EXPECT_EQ(status.flags, kWasReset);
  EXPECT_NEAR(status.position_deg, 0, 0.01);
  Payload page{};
  page[0] = 2;
  const auto identity = bench.send(0x05, page);
  ASSERT_TRUE(identity.has_value());
  EXPECT_EQ(identity->data[2], 3);  // reset cause: command
  const unsigned uptime_ms = identity->data[6] * 256u + identity->data[7];
  EXPECT_NEAR(uptime_ms, 300, 2);
}

TEST(SimulatedModule, ADeadModuleIsSilentAndItsMotorIsOff) {
  Bench bench(200, kOn);
  bench.turn(+1, 90, 1, 0.3);
  bench.module.set_dead(true);
  const double stopped_deg = bench.shaft_deg();
  bench.run(1);
  EXPECT_NEAR(bench.shaft_deg(), stopped_deg, 0.01);
  EXPECT_FALSE(bench.send(0x05).has_value());
}

TEST(SimulatedModule, HealthReportsSetPointAndTimeLeft) {
  Bench bench(200, kOn);
  bench.turn(+1, 90, 2, 0.5);
  Payload page{};
  page[0] = 1;
  const Payload health = bench.send(0x05, page)->data;
  EXPECT_NEAR(Bench::u16(health, 0), 2210, 20);
  EXPECT_NEAR(Bench::u16(health, 2), 12000, 100);
  EXPECT_EQ(Bench::u16(health, 4), 9000u);
  EXPECT_NEAR(Bench::u16(health, 6), 1500, 2);
}

TEST(SimulatedModule, CountsAsDroppedWhatItDoesNotKnow) {
  Bench bench;
  Payload data{};
  data[0] = 9;
  bench.send(0x05, data);  // no such page
  bench.send(0x55);        // no such code
  bench.start();
  bench.rotate(+1, 360.00, 1);  // no such position
  data[0] = 2;
  EXPECT_EQ(bench.send(0x05, data)->data[3], 3);
  EXPECT_FALSE(bench.status() & kMoving);
}

TEST(SimulatedModule, WarnsOfHeatWithHysteresis) {
  Bench bench;
  bench.module.set_temperature_degC(86);
  bench.run(0.01);
  EXPECT_TRUE(bench.status() & kHot);
  bench.module.set_temperature_degC(82);
  bench.run(0.01);
  EXPECT_TRUE(bench.status() & kHot);
  bench.module.set_temperature_degC(79);
  bench.run(0.01);
  EXPECT_FALSE(bench.status() & kHot);
}

}  // namespace
}  // namespace lss::sim::zebro
