// Wheels that slip, and an IMU that may be wrong: who is right, and how the rover slows down
// (7.2.1, 7.7).

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/ardito/gnc/rover.h"

namespace lss::gnc::ardito::test {
namespace {

Rover loaded_in_a_curve(double speed, double load) {
  Rover rover = driving_rover(5, speed, 4, 0);
  rover.drive_load = load;
  rover.run(2);
  return rover;
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

// In a curve the yaw rate shows whether the IMU is wrong or the rover is stuck, with any load.
TEST(Slip, InACurveTheYawRateDecidesBetweenAWrongImuAndAStuckRover) {
  for (const bool turns : {true, false}) {
    Rover rover = loaded_in_a_curve(0.6, turns ? 0.4 : 0.05);
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
    Rover rover = loaded_in_a_curve(0.8, 0.5);
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

// It loses half of its speed.
Rover slowed(double speed = 0.6) {
  Rover rover = climbing(speed);
  lose(rover, 0.5);
  rover.run(4);
  EXPECT_TRUE(slows(rover));
  return rover;
}

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
  Rover rover = slowed(0.3);
  rover.drive_load = 0.08;
  rover.run(4);
  EXPECT_FALSE(slows(rover));
  EXPECT_NEAR(rover.true_speed_m_s(), 0.3, 0.03);
}

TEST(Slip, TheWayBackBeginsWithTheSpeedThatIsAskedFor) {
  Rover rover = slowed();
  rover.request.speed = -rover.request.speed;
  rover.step();
  EXPECT_EQ(rover.command.estimate.speed_share, 1);
}

TEST(Slip, ARoverThatIsSlowedGoesOnFullyWithoutAnImuButNotForAGust) {
  Rover rover = slowed();
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
  Rover rover = slowed();
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
  Rover rover = loaded_in_a_curve(0.8, 0.5);
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

}  // namespace
}  // namespace lss::gnc::ardito::test
