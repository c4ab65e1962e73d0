// One wheel that digs itself in while the others hold.

#include <gtest/gtest.h>

#include <utility>

#include "gnc/ardito/slip.h"
#include "tests/ardito/gnc/rover.h"

namespace lss::gnc::ardito::test {
namespace {

TEST(Sinking, AWheelLowerThanThePlaneOfTheOthersIsMeasuredAndATiltedPlaneIsNone) {
  const PerWheel<double> tilted = {0.10, 0.16, 0.05, 0.11, 0.00, 0.06};
  for (const double lower : lower_than_others_m(tilted)) EXPECT_NEAR(lower, 0, 1e-12);
  for (std::size_t i = 0; i < kWheels; ++i) {
    PerWheel<double> z_m = tilted;
    z_m[i] += 0.08;
    const PerWheel<double> lower_m = lower_than_others_m(z_m);
    EXPECT_NEAR(lower_m[i], 0.08, 1e-12);
    for (std::size_t k = 0; k < kWheels; ++k) {
      if (k == i) continue;
      EXPECT_LT(lower_m[k], 0.06) << i << k;
    }
  }
}

// A tenth of the wheels' speed is lost, as on level regolith.
void slipping(Measured& m) { m.imu.speed_m_s.value *= 0.9; }
void low_wheel_4(Measured& m) {
  slipping(m);
  m.rho2_rad.value -= 0.18;  // lowers it by 67 mm, lifts wheel 6
}
void strained_wheel_4(Measured& m) {
  slipping(m);
  m.wheels[3].current.value += m.wheels[3].motor_rad_s.value > 0 ? 0.4 : -0.4;
}
void in_a_hole_wheel_4(Measured& m) {
  low_wheel_4(m);
  strained_wheel_4(m);
  m.imu.speed_m_s.value /= 0.9 * 0.9;  // all speed arrives
}
void dug_in_wheel_4(Measured& m) {
  in_a_hole_wheel_4(m);
  slipping(m);
}

Rover on_level_ground(double speed) {
  Rover rover(5);
  rover.noise.ground_rad = 0;
  rover.request.run = true;
  rover.request.speed = speed;
  EXPECT_TRUE(rover.settle(30));
  rover.run(3);
  return rover;
}

TEST(Sinking, AWheelIsDugInWhenItIsLowAndItsMotorPushesHarderAndTheRoverSlips) {
  for (const double speed : {0.6, -0.4}) {
    Rover rover = on_level_ground(speed);
    for (const auto tamper : {low_wheel_4, strained_wheel_4, in_a_hole_wheel_4}) {
      rover.tamper = tamper;
      for (int n = 0; n < 30; ++n) {
        rover.step();
        EXPECT_EQ(rover.command.faults & kWheelSinks, 0U) << n;
      }
      rover.tamper = nullptr;
      rover.run(6);  // also until a jump of the rocker is forgotten
    }
    rover.tamper = dug_in_wheel_4;
    double took_s = 0;
    while ((rover.command.faults & kWheelSinks) == 0 && took_s < 3) {
      rover.step();
      took_s += kFrame_s;
    }
    EXPECT_LT(took_s, 2);
    EXPECT_EQ(rover.command.sinking, only(3));
    EXPECT_GT(rover.command.estimate.sunk_m, Parameters{}.sink_m);
    EXPECT_GT(rover.command.estimate.strain, Parameters{}.sink_strain);
    EXPECT_LT(rover.command.estimate.strain_limit, Parameters{}.sink_strain);
    EXPECT_GT(rover.command.estimate.strain_limit, Parameters{}.sink_strain_deep);
    EXPECT_EQ(rover.command.wheel_failure[3], WheelFailure::none);
    // the way back is free; the same way is not
    rover.request.speed = 0;
    ASSERT_TRUE(rover.settle(20));
    rover.request.speed = -speed;
    ASSERT_TRUE(rover.settle(20));
    rover.run(3);
    EXPECT_EQ(rover.command.faults & kWheelSinks, 0U);
    rover.request.speed = 0;
    ASSERT_TRUE(rover.settle(20));
    rover.request.speed = speed;
    ASSERT_TRUE(rover.settle(20));
    rover.run(3);
    EXPECT_NE(rover.command.faults & kWheelSinks, 0U);
  }
}

void shallow_wheel_4(Measured& m) { m.rho2_rad.value -= 0.12; }

// Whether a wheel counts as dug in while the rover drives so for some seconds.
bool is_dug_in_at(Rover& rover, double speed) {
  rover.request.speed = 0;
  EXPECT_TRUE(rover.settle(20));
  rover.request.speed = speed;
  EXPECT_TRUE(rover.settle(20));
  for (int n = 0; n < 30; ++n) {
    rover.step();
    if ((rover.command.faults & kWheelSinks) != 0) return true;
  }
  return false;
}

TEST(Sinking, TheWayOutIsFreeForAWheelThatWasHaltedBeforeItCountedAsDugIn) {
  for (const double speed : {0.6, -0.4}) {
    Rover rover = on_level_ground(speed);
    rover.tamper = shallow_wheel_4;
    rover.run(3);
    ASSERT_EQ(rover.command.faults & kWheelSinks, 0U);
    rover.tamper = dug_in_wheel_4;  // backing out it goes deeper first
    EXPECT_FALSE(is_dug_in_at(rover, -speed));
    EXPECT_TRUE(is_dug_in_at(rover, speed)) << "the way in is not free";
    rover.tamper = nullptr;  // out
    EXPECT_FALSE(is_dug_in_at(rover, -speed));
    rover.tamper = shallow_wheel_4;
    rover.run(3);
    rover.tamper = dug_in_wheel_4;
    rover.run(3);
    EXPECT_NE(rover.command.faults & kWheelSinks, 0U) << "in again, by the other way";
  }
}

TEST(Sinking, AWheelThatNobodySawGoInIsNotJudgedUntilItIsOut) {
  Rover rover;
  rover.noise.ground_rad = 0;
  rover.tamper = dug_in_wheel_4;
  rover.request.run = true;
  EXPECT_FALSE(is_dug_in_at(rover, 0.6));
  EXPECT_FALSE(is_dug_in_at(rover, -0.4));
  rover.tamper = nullptr;
  EXPECT_FALSE(is_dug_in_at(rover, 0.6));
  rover.tamper = dug_in_wheel_4;
  rover.run(3);
  EXPECT_NE(rover.command.faults & kWheelSinks, 0U);
}

// Uphill as measured in physics: middle wheels carry little, those behind much.
void add_load(Measured& m, const PerWheel<double>& more) {
  for (std::size_t i = 0; i < kWheels; ++i) {
    double& current = m.wheels[i].current.value;
    current += m.wheels[i].motor_rad_s.value > 0 ? more[i] : -more[i];
  }
}
void uphill(Measured& m) { add_load(m, {0, 0, -0.1, -0.1, 0.1, 0.1}); }
void uphill_low_wheel_4(Measured& m) {
  uphill(m);
  low_wheel_4(m);
}
void uphill_dug_in_wheel_4(Measured& m) {  // 0.6, its twin 0.3, all others 0.42 on average
  uphill_low_wheel_4(m);
  add_load(m, {0, 0, 0, 0.3, 0, 0});
}
void somewhat_strained_low_wheel_4(Measured& m) {  // 1.4 times the others
  low_wheel_4(m);
  add_load(m, {0, 0, 0, 0.16, 0, 0});
}
void somewhat_strained_deep_wheel_4(Measured& m) {
  somewhat_strained_low_wheel_4(m);
  m.rho2_rad.value -= 0.15;
}

using Tamper = void (*)(Measured&);

bool finds_wheel_4(Rover& rover, Tamper tamper) {
  rover.tamper = tamper;
  for (int n = 0; n < 30; ++n) {
    rover.step();
    if (rover.command.sinking == only(3)) return true;
  }
  return false;
}

Rover evenly_loaded(double load) {
  Rover rover = on_level_ground(0.6);
  rover.noise.load = 0;
  rover.drive_load = load;
  rover.run(3);
  return rover;
}

TEST(Sinking, AMiddleWheelUphillIsComparedWithTheOneBesideIt) {
  for (const auto& [tamper, found] :
       {std::pair<Tamper, bool>(uphill_low_wheel_4, false), {uphill_dug_in_wheel_4, true}}) {
    Rover rover = evenly_loaded(0.4);
    rover.tamper = uphill;
    rover.run(3);
    EXPECT_EQ(finds_wheel_4(rover, tamper), found);
  }
}

// A wheel that is over a hole or comes down a rock pushes nothing, or brakes: it is no measure for
// the one beside it, or for the mean. All others push as on level ground.
void lifted_wheel_3(Measured& m) {
  low_wheel_4(m);
  add_load(m, {0, 0, -0.4, 0, 0, 0});
}
void braking_wheels_1_2_3(Measured& m) {
  low_wheel_4(m);
  add_load(m, {-0.6, -0.6, -0.6, 0, 0, 0});
}
void lifted_wheel_3_dug_in_wheel_4(Measured& m) {
  lifted_wheel_3(m);
  add_load(m, {0, 0, 0, 0.6, 0, 0});
}
void none_but_wheel_4_pushes(Measured& m) {
  low_wheel_4(m);
  add_load(m, {-0.4, -0.4, -0.4, 0, -0.4, -0.4});
}

TEST(Sinking, AWheelThatCarriesNothingIsNoMeasureForTheOthers) {
  for (const auto& [tamper, found] : {std::pair<Tamper, bool>(lifted_wheel_3, false),
                                      {braking_wheels_1_2_3, false},
                                      {lifted_wheel_3_dug_in_wheel_4, true},
                                      {none_but_wheel_4_pushes, true}}) {
    Rover rover = evenly_loaded(0.4);
    EXPECT_EQ(finds_wheel_4(rover, tamper), found);
  }
}

TEST(Sinking, ADeeperWheelNeedsLessStrain) {
  for (const auto& [tamper, found] : {std::pair<Tamper, bool>(somewhat_strained_low_wheel_4, false),
                                      {somewhat_strained_deep_wheel_4, true}}) {
    Rover rover = evenly_loaded(0.4);
    EXPECT_EQ(finds_wheel_4(rover, tamper), found);
  }
  const Parameters p;
  EXPECT_EQ(sink_strain_limit(p.sink_m, p), p.sink_strain);
  EXPECT_EQ(sink_strain_limit(1, p), p.sink_strain_deep);
}

}  // namespace
}  // namespace lss::gnc::ardito::test
