// Old values, silent and implausible sensors: faults, never values (FMEA 7.3.1, 7.5.1, 7.6, 7.7).

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/ardito/gnc/rover.h"

namespace lss::gnc::ardito::test {
namespace {

TEST(Stale, OneOldSensorIsASensorFailureEvenWhenItsValueFits) {
  Rover rover = driving();
  rover.tamper = [](Measured& m) { m.wheels[2].hall_rad_s.age_s = 0.3; };
  rover.step();
  EXPECT_EQ(rover.command.stale_wheels, only(2));
  EXPECT_EQ(rover.command.wheel_suspect[2], WheelFailure::motor_sensor);
  rover.run(0.3);
  EXPECT_EQ(rover.command.wheel_failure[2], WheelFailure::motor_sensor);
  EXPECT_EQ(rover.command.sensors_lost[2], static_cast<std::uint32_t>(kHall));
}

TEST(Stale, TwoMissedFramesAreNoFailure) {
  Rover rover = driving();
  rover.tamper = [](Measured& m) { m.wheels[2].hall_rad_s.age_s = 0.3; };
  rover.run(0.2);
  rover.tamper = nullptr;
  rover.run(2);
  EXPECT_EQ(rover.command.wheel_failure[2], WheelFailure::none);
}

TEST(Stale, ASilentWheelDriveIsIsolatedAndThenAnError) {
  Rover rover = driving();
  rover.tamper = [](Measured& m) {
    for (Reading* r : {&m.wheels[0].motor_rad_s, &m.wheels[0].hall_rad_s,
                       &m.wheels[0].reduction_rad_s, &m.wheels[0].current}) {
      r->age_s = 1;
    }
  };
  rover.run(0.3);
  EXPECT_EQ(rover.command.wheel_failure[0], WheelFailure::all_sensors);
  EXPECT_TRUE(contains(rover.command.motors_stopped, 0));
  EXPECT_EQ(rover.command.error, 0U);
  rover.run(0.6);
  EXPECT_EQ(rover.command.error, 1U);
  EXPECT_EQ(rover.command.mode, Mode::stop);
}

TEST(Stale, ADriveThatSaysItIsFaultyIsAMotorFailure) {
  Rover rover = driving();
  rover.tamper = [](Measured& m) { m.wheels[5].drive_fault = true; };
  rover.step();
  EXPECT_EQ(rover.command.wheel_suspect[5], WheelFailure::motor);
  rover.run(0.5);
  EXPECT_EQ(rover.command.wheel_failure[5], WheelFailure::motor);
  EXPECT_TRUE(contains(rover.command.motors_stopped, 5));
  EXPECT_EQ(rover.command.error, 0U);
  rover.tamper = [](Measured& m) { m.steering[1].drive_fault = true; };
  rover.run(0.6);
  EXPECT_EQ(rover.command.steering_failure[1], SteeringFailure::critical);
  EXPECT_EQ(rover.command.error, 1U);
}

TEST(Stale, HotAndOverloadedMotorsAreStopped) {
  Rover rover = driving();
  rover.tamper = [](Measured& m) { m.wheels[3].temperature_C.value = 95; };
  rover.run(2);
  EXPECT_EQ(rover.command.hot_motors, only(3)) << "reported";
  EXPECT_EQ(rover.command.motors_stopped, 0U);
  rover.tamper = [](Measured& m) { m.wheels[3].temperature_C.value = 120; };
  rover.run(0.7);
  EXPECT_EQ(rover.command.hot_motors, only(3));
  EXPECT_TRUE(contains(rover.command.motors_stopped, 3));
  rover.tamper = [](Measured& m) { m.wheels[1].current.value = 2.5; };
  rover.run(0.9);
  EXPECT_FALSE(contains(rover.command.motors_stopped, 1));
  rover.run(0.7);
  EXPECT_TRUE(contains(rover.command.motors_stopped, 1));
}

TEST(Stale, AnOldTemperatureIsSaidAndChangesNothing) {
  Rover rover = driving();
  rover.tamper = [](Measured& m) { m.wheels[3].temperature_C = {200, 5}; };
  rover.run(2);
  EXPECT_EQ(rover.command.stale_wheels, only(3));
  EXPECT_EQ(rover.command.hot_motors, 0U);
  EXPECT_EQ(rover.command.wheel_failure[3], WheelFailure::none);
}

TEST(Stale, OldSteeringEncodersAreLost) {
  Rover rover = driving();
  rover.tamper = [](Measured& m) { m.steering[0].motor_rad.age_s = 0.3; };
  rover.run(0.3);
  EXPECT_EQ(rover.command.steering_failure[0], SteeringFailure::motor_encoder);
  EXPECT_EQ(rover.command.stale_steering, only(0));
  rover.tamper = [](Measured& m) { m.steering[0].motor_rad = m.steering[0].reduction_rad = {}; };
  rover.run(0.5);
  EXPECT_EQ(rover.command.steering_failure[0], SteeringFailure::both_encoders);
  EXPECT_EQ(rover.command.error, 1U);
}

TEST(Stale, RockerAnglesThatAreOldOrImpossibleSwitchTheCorrectionOff) {
  for (const Reading bad : {Reading{0.2, 0.3}, Reading{2, 0.01}, Reading{NAN, 0}}) {
    static Reading reading;
    reading = bad;
    Rover rover = driving();
    rover.noise.ground_rad = 0.5;
    rover.tamper = [](Measured& m) { m.rho1_rad = reading; };
    rover.run(3);
    EXPECT_NE(rover.command.faults & kRockerStale, 0U);
    double least = 100, most = 0;
    for (const double w : rover.command.wheel_rad_s) {
      least = std::min(least, w);
      most = std::max(most, w);
    }
    EXPECT_LT(most - least, 0.2);  // the plane's: all alike
    rover.tamper = nullptr;
    rover.run(0.2);
    EXPECT_EQ(rover.command.faults & kRockerStale, 0U);
  }
}

TEST(Stale, ACorrectionOfSignZeroIsNone) {
  Parameters p;
  p.correction_sign = 0;
  ASSERT_EQ(check(p), nullptr);
  Rover rover(5, p);
  rover.request.run = true;
  rover.request.speed = 0.6;
  rover.noise.ground_rad = 0.5;
  ASSERT_TRUE(rover.settle(30));
  for (int n = 0; n < 30; ++n) {
    rover.step();
    const auto [least, most] =
        std::minmax_element(rover.command.wheel_rad_s.begin(), rover.command.wheel_rad_s.end());
    EXPECT_LT(*most - *least, 0.2);  // the plane's: all alike
  }
}

TEST(Stale, ImuSilentFrozenImplausibleAndContradicting) {
  Rover rover = driving();
  EXPECT_EQ(rover.command.faults & (kImuSilent | kImuImplausible), 0U);
  rover.tamper = [](Measured& m) { m.imu.sigma_rad.age_s = 0.3; };
  rover.step();
  EXPECT_NE(rover.command.faults & kImuSilent, 0U);

  rover.tamper = [](Measured& m) { m.imu.counter = 17; };
  rover.run(0.3);
  EXPECT_NE(rover.command.faults & kImuSilent, 0U);
  rover.tamper = nullptr;
  rover.run(0.2);
  EXPECT_EQ(rover.command.faults & (kImuSilent | kImuImplausible), 0U);

  rover.tamper = [](Measured& m) { m.imu.speed_m_s.value = 5; };
  rover.step();
  EXPECT_NE(rover.command.faults & kImuImplausible, 0U);
  rover.tamper = nullptr;
  rover.run(0.3);
  EXPECT_EQ(rover.command.faults & kImuImplausible, 0U);

  // slip is said at once, a contradiction that stays is the IMU's
  rover.tamper = [](Measured& m) { m.imu.speed_m_s.value += 0.3; };
  rover.run(0.3);
  EXPECT_NE(rover.command.faults & kSlip, 0U);
  EXPECT_EQ(rover.command.faults & kImuImplausible, 0U);
  rover.run(2);
  EXPECT_NE(rover.command.faults & kImuImplausible, 0U);
  // none of it is a wheel's fault
  for (std::size_t i = 0; i < kWheels; ++i) {
    EXPECT_EQ(rover.command.wheel_failure[i], WheelFailure::none);
  }
}

// 1 m/s from one frame to the next, far below the fastest that it may say.
TEST(Stale, AnImuThatJumpsIsImplausibleInThatFrame) {
  for (const double jump_m_s : {-1.05, -0.95, 0.95, 1.05}) {
    Rover rover = driving(0.2);
    rover.noise.imu_m_s = 0;
    rover.run(1);
    static double value_m_s;
    value_m_s = rover.measured.imu.speed_m_s.value + jump_m_s;
    rover.tamper = [](Measured& m) { m.imu.speed_m_s.value = value_m_s; };
    rover.step();
    EXPECT_EQ((rover.command.faults & kImuImplausible) != 0, std::abs(jump_m_s) > 1) << jump_m_s;
    rover.step();
    EXPECT_EQ(rover.command.faults & kImuImplausible, 0U) << "it stays there";
  }
}

// 7.2.2
TEST(Stale, ASteeringMotorThatDrawsTooMuchIsCritical) {
  Rover rover = driving();
  rover.tamper = [](Measured& m) { m.steering[2].current.value = -2.5; };
  rover.run(0.9);
  EXPECT_EQ(rover.command.steering_failure[2], SteeringFailure::none);
  rover.run(0.7);
  EXPECT_EQ(rover.command.steering_failure[2], SteeringFailure::critical);
  EXPECT_EQ(rover.command.error, 1U);
}

// 7.3.1
TEST(Stale, RockerAnglesThatJumpAreNotTrustedForAWhile) {
  Rover rover = driving();
  rover.tamper = [](Measured& m) { m.beta_rad.value += 0.6; };
  rover.step();
  EXPECT_NE(rover.command.faults & kRockerJump, 0U);
  rover.run(4.8);
  EXPECT_NE(rover.command.faults & kRockerJump, 0U);
  rover.run(0.3);
  EXPECT_EQ(rover.command.faults & kRockerJump, 0U);
  rover.tamper = nullptr;
  rover.step();
  EXPECT_NE(rover.command.faults & kRockerJump, 0U) << "and back";
}

// Metres until the angles are in doubt, or no longer; 60 at most.
double metres_until(Rover& rover, bool doubted) {
  double way_m = 0;
  while (((rover.command.faults & kRockerOff) != 0) != doubted && way_m < 60) {
    rover.step();
    way_m += std::abs(rover.true_speed_m_s()) * kFrame_s;
  }
  return way_m;
}

TEST(Stale, RockerAnglesThatAreNot0OnAverageAreNotTrustedUntilTheyAreAgain) {
  constexpr decltype(Rover::tamper) kWrong[] = {[](Measured& m) { m.beta_rad.value += 0.06; },
                                                [](Measured& m) { m.rho1_rad.value -= 0.18; },
                                                [](Measured& m) { m.rho2_rad.value += 0.18; }};
  for (const auto wrong : kWrong) {
    for (const double speed : {0.6, -0.5}) {
      Rover rover = driving(speed);
      rover.noise.ground_rad = 0;  // it wanders: wheels of a side do not roll over the same there
      rover.tamper = wrong;
      const double way_m = metres_until(rover, true);
      EXPECT_GT(way_m, 5);
      EXPECT_LT(way_m, 25);
      rover.tamper = nullptr;
      EXPECT_LT(metres_until(rover, false), 25);
      EXPECT_GE(metres_until(rover, true), 60) << "nothing is wrong";
    }
  }
}

TEST(Stale, RockerAnglesAreNotJudgedOnShortWaysBackAndForth) {
  Rover rover = driving();
  rover.tamper = [](Measured& m) { m.rho1_rad.value += 0.18; };
  for (const double speed : {0.6, -0.6, 0.6, -0.6}) {
    rover.request.speed = speed;
    ASSERT_TRUE(rover.settle(20));
    rover.run(20);  // 12 m
    EXPECT_EQ(rover.command.faults & kRockerOff, 0U);
  }
}

// Around a mound or in a bowl the wheels of a side do not roll over the same ground.
TEST(Stale, RockerAnglesAreNotJudgedInCurves) {
  Rover rover = driving_rover(5, 0.6, 3, 1);
  rover.noise.ground_rad = 0;
  rover.tamper = [](Measured& m) { m.rho2_rad.value += 0.1; };
  EXPECT_GE(metres_until(rover, true), 60);
}

// On the slope of a hill the rover slides down sideways while it drives, for seconds.
TEST(Stale, ARoverThatSlidesSidewaysSlipsAndItsImuIsRight) {
  for (const double speed : {1.0, -0.6}) {
    Rover rover = driving(speed);
    rover.tamper = [](Measured& m) {
      constexpr double kSideways_m_s = 0.09;
      const double ahead_m_s = m.imu.speed_m_s.value;
      m.imu.speed_m_s.value = std::copysign(std::hypot(ahead_m_s, kSideways_m_s), ahead_m_s);
      m.imu.sigma_rad.value = std::atan2(kSideways_m_s, std::abs(ahead_m_s));
    };
    rover.run(0.3);
    for (int n = 0; n < 100; ++n) {
      rover.step();
      ASSERT_NE(rover.command.faults & kSlip, 0U) << n;
      ASSERT_EQ(rover.command.faults & kImuImplausible, 0U) << n;
    }
  }
}

TEST(Stale, AnImuOfWrongDirectionIsReportedApartFromASlide) {
  for (const double speed : {1.0, -1.0}) {
    Rover rover = driving(speed);
    rover.tamper = [](Measured& m) { m.imu.sigma_rad.value = 0.4; };
    rover.run(1.8);
    EXPECT_EQ(rover.command.faults & kImuImplausible, 0U);
    rover.run(0.4);
    EXPECT_NE(rover.command.faults & kImuImplausible, 0U);
  }
}

// 17.8.1 with E12: a reduction encoder that the IMU or the motor's load contradicts is broken, not
// the clutch.
TEST(Stale, TheImuAndTheLoadDistinguishAWrongReductionEncoderFromASlippingClutch) {
  const auto wrong = [](Measured& m) { m.wheels[1].reduction_rad_s.value *= 0.6; };
  const auto alone = [](Measured& m) {
    m.wheels[1].reduction_rad_s.value *= 0.6;
    m.wheels[1].current.value = 0.09;
  };
  // the rover is blocked while a motor turns on
  const auto slipping = [](Measured& m) {
    m.wheels[1].reduction_rad_s.value *= 0.6;
    m.wheels[1].current.value = 0.09;
    m.imu.speed_m_s.value = m.wheels[1].reduction_rad_s.value * 0.15;
  };
  // on soil: driven wheels lose a fifth, the wheel without a motor turns more slowly than it moves
  const auto towed = [](Measured& m) {
    m.wheels[1].reduction_rad_s.value *= 0.7;
    m.wheels[1].current.value = 0.09;
    m.imu.speed_m_s.value *= 0.8;
  };
  const std::pair<void (*)(Measured&), WheelFailure> cases[] = {
      {towed, WheelFailure::clutch},
      {wrong, WheelFailure::reduction_encoder},
      {alone, WheelFailure::reduction_encoder},
      {slipping, WheelFailure::clutch}};
  for (const auto& [tamper, found] : cases) {
    Rover rover = driving();
    rover.request.enable_correction = false;
    rover.tamper = tamper;
    rover.step();
    EXPECT_EQ(rover.command.wheel_suspect[1], found);
  }
}

}  // namespace
}  // namespace lss::gnc::ardito::test
