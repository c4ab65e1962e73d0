// Old values, silent and implausible sensors: faults, never values (FMEA 7.3.1, 7.5.1, 7.6, 7.7).

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/ardito/gnc/rover.h"

namespace lss::gnc::ardito::test {
namespace {

Rover driving(double speed = 0.6) {
  Rover rover(5);
  rover.request.run = true;
  rover.request.speed = speed;
  EXPECT_TRUE(rover.settle(30));
  rover.run(1);
  return rover;
}

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

// Wheels that turn in place: the IMU is right, and the motors push.
TEST(Slip, ARoverThatDoesNotMoveIsStuckAndItsImuIsRight) {
  for (const double speed : {0.6, -0.3}) {
    Rover rover = driving(speed);
    EXPECT_EQ(rover.command.faults & (kWheelsSlip | kStuck), 0U);
    rover.drive_load = 0.5;
    rover.run(2);  // up a hill: loaded, and moving
    EXPECT_EQ(rover.command.faults & (kWheelsSlip | kStuck | kImuImplausible), 0U);
    rover.tamper = [](Measured& m) { m.imu.speed_m_s.value = 0.002; };
    rover.run(0.2);
    EXPECT_NE(rover.command.faults & kWheelsSlip, 0U) << "known at once";
    EXPECT_NEAR(rover.command.estimate.ground_m_s, 0, 0.01) << "odometry stops counting";
    EXPECT_NEAR(rover.command.estimate.slip_m_s, speed, 0.05);
    rover.run(0.9);
    EXPECT_EQ(rover.command.faults & kStuck, 0U);
    rover.run(0.2);
    EXPECT_NE(rover.command.faults & kStuck, 0U);
    rover.run(3);
    EXPECT_EQ(rover.command.faults & kImuImplausible, 0U);
  }
}

TEST(Slip, AnImuThatSaysNothingMovesWhileMotorsRollEasilyIsWrong) {
  Rover rover = driving();
  rover.drive_load = 0.08;
  rover.run(2);
  rover.tamper = [](Measured& m) { m.imu.speed_m_s.value = 0.002; };
  for (int n = 0; n < 40; ++n) {
    rover.step();
    EXPECT_EQ(rover.command.faults & (kWheelsSlip | kStuck), 0U) << n;
  }
  EXPECT_NE(rover.command.faults & kImuImplausible, 0U);
}

// In a curve the yaw rate tells, whatever the load.
TEST(Slip, InACurveTheYawRateTellsWhoIsRight) {
  for (const bool turns : {true, false}) {
    Rover rover(5);
    rover.request.run = true;
    rover.request.speed = 0.6;
    rover.request.sigma_rad = 4 * kDegree;
    ASSERT_TRUE(rover.settle(30));
    rover.drive_load = turns ? 0.4 : 0.05;
    rover.run(2);
    static bool keeps_turning;
    keeps_turning = turns;
    rover.tamper = [](Measured& m) {
      m.imu.speed_m_s.value = 0.002;
      if (!keeps_turning) m.imu.yaw_rate_rad_s.value = 0.003;
    };
    rover.run(2.5);
    EXPECT_EQ((rover.command.faults & kStuck) != 0, !turns);
    EXPECT_EQ((rover.command.faults & kImuImplausible) != 0, turns);
  }
}

// As on soil, uphill: the IMU is right although the rover turns at three quarters of the yaw rate.
TEST(Slip, InACurveWheelsThatLoseYawRateAndSpeedTogetherSlip) {
  for (const double speed_share : {0.55, 0.95}) {
    Rover rover(5);
    rover.request.run = true;
    rover.request.speed = 0.8;
    rover.request.sigma_rad = 4 * kDegree;
    ASSERT_TRUE(rover.settle(30));
    rover.drive_load = 0.5;
    rover.run(2);
    static double share;
    share = speed_share;
    rover.tamper = [](Measured& m) {
      m.imu.speed_m_s.value *= share;
      m.imu.yaw_rate_rad_s.value *= 0.75;
    };
    for (int n = 0; n < 40; ++n) {
      rover.step();
      EXPECT_EQ(rover.command.faults & kImuImplausible, 0U) << n;
    }
    EXPECT_EQ((rover.command.faults & kWheelsSlip) != 0, speed_share < 0.6);
  }
}

// Across and up a slope of soil a rover loses speed and slides down sideways: its IMU is right.
// Without the loss of speed it is the IMU's direction.
TEST(Slip, WheelsThatPushAndLoseSpeedMaySlideSideways) {
  for (const double along : {0.75, 1.0}) {
    Rover rover = driving(0.4);
    rover.drive_load = 0.5;
    rover.run(2);
    static double share;
    share = along;
    rover.tamper = [](Measured& m) {
      const double ahead_m_s = m.imu.speed_m_s.value * share;
      const double sideways_m_s = share < 1 ? 0.16 : 0;
      m.imu.speed_m_s.value = std::hypot(ahead_m_s, sideways_m_s);
      m.imu.sigma_rad.value = share < 1 ? std::atan2(sideways_m_s, ahead_m_s) : 0.5;
    };
    rover.run(4);
    EXPECT_EQ((rover.command.faults & kImuImplausible) != 0, along == 1) << along;
  }
}

// The IMU loses this share of the wheels' speed.
void lose(Rover& rover, double share) {
  static double left;
  left = 1 - share;
  rover.tamper = [](Measured& m) { m.imu.speed_m_s.value *= left; };
}

Rover climbing(double speed = 0.6) {
  Rover rover = driving(speed);
  rover.drive_load = 0.5;
  rover.run(2);
  EXPECT_EQ(rover.command.faults & kSlipSlows, 0U);
  return rover;
}

bool slows(const Rover& rover) { return (rover.command.faults & kSlipSlows) != 0; }

TEST(Slip, MoreThanAllowedHalvesTheSpeedUntilItIsClearlyLess) {
  for (const double speed : {0.6, -0.6}) {
    Rover rover = climbing(speed);
    lose(rover, 0.35);
    rover.run(10);
    EXPECT_FALSE(slows(rover)) << "as much as is allowed";
    EXPECT_NEAR(rover.command.estimate.slip_share, 0.35, 0.03);
    lose(rover, 0.5);
    rover.run(3);
    EXPECT_TRUE(slows(rover));
    EXPECT_NEAR(rover.command.estimate.slip_share, 0.5, 0.05);
    EXPECT_NEAR(rover.command.estimate.speed_share, 0.5, 1e-9);
    EXPECT_NEAR(rover.true_speed_m_s(), speed / 2, 0.03);
    EXPECT_NEAR(rover.command.estimate.ground_m_s, speed / 4, 0.03) << "odometry by the IMU";
    lose(rover, 0.35);
    rover.run(10);
    EXPECT_TRUE(slows(rover)) << "it does not come and go";
    lose(rover, 0.15);
    rover.run(4);
    EXPECT_FALSE(slows(rover));
    EXPECT_NEAR(rover.true_speed_m_s(), speed, 0.03);
    EXPECT_EQ(rover.command.estimate.speed_share, 1);
  }
}

// Below that slip can hardly be measured, and a stuck rover has to be found.
TEST(Slip, ItIsNeverSlowedBelowASpeedAtWhichSlipIsMeasured) {
  for (const auto& [speed, slowed] : {std::pair{0.2, 0.12}, std::pair{0.1, 0.1}}) {
    Rover rover = climbing(speed);
    lose(rover, 0.5);
    rover.run(4);
    EXPECT_EQ(slows(rover), slowed < speed);
    EXPECT_NEAR(rover.true_speed_m_s(), slowed, 0.02);
  }
}

TEST(Slip, ASlowedRoverThatDoesNotMoveIsStuckAsSoon) {
  Rover rover = climbing(0.3);
  lose(rover, 0.55);
  rover.run(4);
  ASSERT_TRUE(slows(rover));
  lose(rover, 1);
  rover.run(0.2);
  EXPECT_EQ(rover.command.faults & kStuck, 0U);
  rover.run(1.2);
  EXPECT_NE(rover.command.faults & kStuck, 0U);
}

// Frames from the order to standstill. Meanwhile no wheel gets faster.
int frames_to_stop(Rover& rover) {
  rover.request.run = false;
  PerWheel<double> last = rover.command.wheel_rad_s;
  return frames_until(rover, 100, [&](const Command& c) {
    for (std::size_t i = 0; i < kWheels; ++i) {
      EXPECT_LE(std::abs(c.wheel_rad_s[i]), std::abs(last[i]) + 1e-12);
    }
    last = c.wheel_rad_s;
    return c.wheel_rad_s == PerWheel<double>{};
  });
}

TEST(Slip, AStopIsNoLaterWhileTheRoverIsSlowed) {
  Rover free = climbing();
  const int frames = frames_to_stop(free);
  for (const double after_s : {0.8, 1.0, 1.4, 3.0}) {
    Rover rover = climbing();
    lose(rover, 0.6);
    rover.run(after_s);
    EXPECT_LE(frames_to_stop(rover), frames) << after_s;
    EXPECT_EQ(rover.command.estimate.speed_share, 1) << "the next order is a new one";
  }
}

TEST(Slip, MotorsThatRollEasilyAreNotSlowedByWhatTheImuSays) {
  Rover rover = driving();
  rover.drive_load = 0.08;
  rover.run(2);
  lose(rover, 0.5);
  for (int n = 0; n < 100; ++n) {
    rover.step();
    ASSERT_FALSE(slows(rover)) << n;
  }
}

// An IMU that says too little cannot slow it on level ground for good.
TEST(Slip, ItGoesOnFullyWhenItsMotorsRollEasilyAgain) {
  Rover rover = climbing(0.3);
  lose(rover, 0.5);
  rover.run(4);
  ASSERT_TRUE(slows(rover));
  rover.drive_load = 0.08;
  rover.run(4);
  EXPECT_FALSE(slows(rover));
  EXPECT_NEAR(rover.true_speed_m_s(), 0.3, 0.03);
}

TEST(Slip, TheWayBackBeginsWithTheSpeedThatIsAskedFor) {
  Rover rover = climbing();
  lose(rover, 0.5);
  rover.run(4);
  ASSERT_TRUE(slows(rover));
  rover.request.speed = -rover.request.speed;
  rover.step();
  EXPECT_EQ(rover.command.estimate.speed_share, 1);
}

TEST(Slip, ARoverThatIsSlowedGoesOnFullyWithoutAnImuButNotForAGust) {
  Rover rover = climbing();
  lose(rover, 0.5);
  rover.run(4);
  ASSERT_TRUE(slows(rover));
  rover.tamper = [](Measured& m) {  // every third frame
    const bool gust = m.imu.counter % 3 == 0;
    m.imu.speed_m_s.value = gust ? -4 : m.imu.speed_m_s.value * 0.5;
  };
  for (int n = 0; n < 60; ++n) {
    rover.step();
    ASSERT_TRUE(slows(rover)) << n;
  }
  rover.tamper = [](Measured& m) { m.imu.speed_m_s.age_s = 1; };
  rover.run(1.5);
  EXPECT_TRUE(slows(rover));
  rover.run(3);
  EXPECT_FALSE(slows(rover));
  EXPECT_NEAR(rover.true_speed_m_s(), 0.6, 0.03);
}

TEST(Slip, AnEncoderThatFailsMeanwhileIsFoundAsFastAndNothingElse) {
  Rover rover = climbing();
  lose(rover, 0.5);
  rover.run(4);
  rover.wheel_faults[2].motor_encoder = Broken::zero;
  rover.run(0.4);
  EXPECT_EQ(rover.command.wheel_failure[2], WheelFailure::motor_sensor);
  rover.run(10);
  EXPECT_TRUE(slows(rover));
  for (std::size_t i = 0; i < kWheels; ++i) {
    EXPECT_EQ(rover.command.wheel_failure[i] != WheelFailure::none, i == 2) << i;
  }
}

TEST(Slip, SpeedsThatChangeInEachFrameNeverMakeItFasterThanOrdered) {
  Rover rover = climbing();
  lose(rover, 0.5);
  double last = 0.6;
  for (int n = 0; n < 300; ++n) {
    rover.request.speed = n % 40 == 39 ? -0.3 : n % 2 == 0 ? 0.3 : 0.6;
    rover.step();
    const double most = std::max(std::abs(rover.request.speed), last);
    ASSERT_LE(std::abs(rover.true_speed_m_s()), most + 0.03) << n;
    ASSERT_GE(rover.command.estimate.speed_share, 0.2);
    ASSERT_LE(rover.command.estimate.speed_share, 1);
    last = std::abs(rover.request.speed);
  }
}

// Out of a curve, up a slope of soil: the yaw rate of the curve does not count on the straight.
TEST(Slip, WhatTurnedInACurveDoesNotBlameTheImuAfterIt) {
  Rover rover(5);
  rover.request.run = true;
  rover.request.speed = 0.8;
  rover.request.sigma_rad = 4 * kDegree;
  ASSERT_TRUE(rover.settle(30));
  rover.drive_load = 0.5;
  rover.run(2);
  const auto slips = [&rover](double seconds) {
    for (double t = 0; t < seconds; t += kFrame_s) {
      rover.step();
      ASSERT_EQ(rover.command.faults & kImuImplausible, 0U) << t;
    }
  };
  rover.tamper = [](Measured& m) {
    m.imu.speed_m_s.value *= 0.45;
    m.imu.yaw_rate_rad_s.value *= 0.75;
  };
  slips(4);
  rover.request.sigma_rad = 0;
  slips(2);
  rover.tamper = [](Measured& m) {
    m.imu.speed_m_s.value *= 0.35;
    m.imu.yaw_rate_rad_s.value *= 0.75;
  };
  slips(8);
}

TEST(Slip, TurningOnTheSpotAgainstAnObstacleIsStuckToo) {
  Rover rover(5);
  rover.request.run = rover.request.parking = true;
  rover.request.speed = 0.5;
  ASSERT_TRUE(rover.settle(30));
  rover.drive_load = 0.5;
  rover.run(2);
  rover.tamper = [](Measured& m) { m.imu.yaw_rate_rad_s.value = 0.001; };
  rover.run(1.3);
  EXPECT_NE(rover.command.faults & kStuck, 0U);
}

// 7.2.1
TEST(Yaw, ARoverThatTurnsOtherwiseThanItsSteeringSaysIsReported) {
  Rover rover = driving();
  rover.run(20);
  EXPECT_EQ(rover.command.faults & kYawDisagrees, 0U);
  rover.tamper = [](Measured& m) { m.imu.yaw_rate_rad_s.value += 0.1; };
  rover.run(15);
  EXPECT_NE(rover.command.faults & kYawDisagrees, 0U);
  EXPECT_EQ(rover.command.error, 0U);
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
TEST(Stale, TheImuAndTheLoadTellAWrongReductionEncoderFromASlippingClutch) {
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
