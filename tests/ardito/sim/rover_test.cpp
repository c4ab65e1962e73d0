// The rover in physics, its shafts turned directly.

#include "tools/lss-sim/ardito/rover.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <numbers>

#include "tests/ardito/sim/driver.h"

namespace lss::sim::ardito {
namespace {

using namespace dimensions;

double yaw_rad(const BodyState& body) {
  const Eigen::Vector3d ahead = body.attitude * Eigen::Vector3d::UnitX();
  return std::atan2(ahead.y(), ahead.x());
}

TEST(Rover, StandsStillOnItsWheelsWithItsWholeWeight) {
  Driver driver({});
  driver.run(2);
  const BodyState body = driver.rover.body();
  EXPECT_LT(body.velocity_m_s.norm(), 1e-3);
  EXPECT_NEAR(body.position_m.z(), 0.525, 0.01);
  double weight_N = 0;
  for (const double load_N : driver.rover.loads_N()) {
    EXPECT_GT(load_N, 50);
    weight_N += load_N;
  }
  EXPECT_NEAR(weight_N, kMass_kg * 9.81, 5);
}

TEST(Rover, DrivesStraightAtTheSpeedOfItsWheels) {
  for (const double speed_m_s : {0.1, 0.5, 1.0, -0.5}) {
    Driver driver({});
    driver.drive(speed_m_s);
    driver.run(2);
    const double from_m = driver.x_m();
    driver.run(2);
    EXPECT_NEAR((driver.x_m() - from_m) / 2, speed_m_s, 0.02 * std::abs(speed_m_s)) << speed_m_s;
    EXPECT_NEAR(driver.rover.body().position_m.y(), 0, 0.01);
    EXPECT_NEAR(driver.rover.body().velocity_B_m_s.x(), speed_m_s, 0.05 * std::abs(speed_m_s));
  }
}

TEST(Rover, TurnsOnTheSpotAndToTheRight) {
  Driver driver({});
  drive_circle(driver, 0, 3, 0.1458, 6);
  EXPECT_NEAR(driver.rover.body().yaw_rate_rad_s, -0.1458, 0.005);
  EXPECT_NEAR(yaw_rad(driver.rover.body()), -0.1458 * 5.9, 0.05);
  // The middle of the axles is where it turns; the centre of mass goes round it.
  EXPECT_LT(driver.rover.body().position_m.head<2>().norm(), 2 * kCentre_m);
}

TEST(Rover, FollowsACircleOnItsAckermannAngles) {
  Driver driver({});
  drive_circle(driver, 0.8, 2, 0.3, 4);
  const BodyState body = driver.rover.body();
  EXPECT_NEAR(body.yaw_rate_rad_s, -0.3, 0.01);
  EXPECT_NEAR(body.velocity_B_m_s.head<2>().norm(), 0.3 * std::hypot(0.8, kCentre_m), 0.01);
  for (std::size_t wheel = 0; wheel < kWheels; ++wheel) {
    EXPECT_LT(std::abs(driver.rover.slip_m_s(wheel)), 0.01) << wheel;
  }
}

TEST(Rover, SteeringReachesItsAnglesAndItsStops) {
  Driver driver({});
  driver.angles_rad = {1.0, -1.0, 0.5, -0.5};
  driver.run(4);
  for (std::size_t i = 0; i < kSteered; ++i) {
    EXPECT_NEAR(driver.rover.steering()[i].angle_rad, driver.angles_rad[i], 0.01);
  }
  driver.angles_rad = {2, -2, 2, -2};
  driver.run(4);
  for (const ShaftState& shaft : driver.rover.steering()) {
    EXPECT_NEAR(std::abs(shaft.angle_rad), 75 * std::numbers::pi / 180, 0.02);
  }
}

// With the thesis' friction of 0.3 it climbs 60 mm with both sides at once; 100 mm need 0.8, which
// grousers give.
TEST(Rover, ClimbsAsHighAsItsFrictionLetsIt) {
  const auto climbs = [](double height_m, double friction) {
    Driver driver({.friction = friction, .step_height_m = height_m, .step_at_m = 1.0});
    driver.drive(0.3);
    driver.run(8);
    const BodyState body = driver.rover.body();
    return body.position_m.x() > 1.8 && std::abs(body.position_m.z() - 0.525 - height_m) < 0.01;
  };
  EXPECT_TRUE(climbs(0.06, 0.3));
  EXPECT_FALSE(climbs(0.15, 0.3));
  EXPECT_TRUE(climbs(0.10, 0.8));
}

TEST(Rover, AStepUnderTheLeftWheelsMovesTheRockersOppositeWays) {
  Driver driver(
      {.friction = 0.6, .step_height_m = 0.06, .step_at_m = 1.0, .step_side = StepSide::left});
  driver.drive(0.2);
  double most_beta_rad = 0, least_rho_rad = 0;
  for (int i = 0; i < 40; ++i) {
    driver.run(0.1);
    const Suspension suspension = driver.rover.suspension();
    most_beta_rad = std::max(most_beta_rad, suspension.beta_rad);
    least_rho_rad = std::min(least_rho_rad, suspension.rho1_rad);
  }
  // The front wheel is up: half of its rise over the wheelbase at the rocker, half the chassis'.
  EXPECT_NEAR(most_beta_rad, 0.06 / 0.9 / 2, 0.015);
  EXPECT_LT(least_rho_rad, -0.02);
}

TEST(Rover, AFreeWheelRollsAlongAndABlockedOneSkids) {
  Driver driver({});
  driver.drive(0.5);
  driver.run(1);
  driver.treads_m_s[3] = 0;
  driver.torque_Nm[3] = 0.5;
  driver.run(2);
  EXPECT_NEAR(driver.rover.wheels()[3].velocity_rad_s, 0.5 / kWheelRadius_m, 0.4);
  driver.torque_Nm[3] = 100;
  driver.run(2);
  EXPECT_NEAR(driver.rover.wheels()[3].velocity_rad_s, 0, 0.02);
  EXPECT_LT(driver.rover.slip_m_s(3), -0.3);
  EXPECT_GT(driver.rover.body().velocity_B_m_s.x(), 0.4) << "five wheels drag it";
}

TEST(Rover, DrivesOverHillsAndRoughGroundWithAllWheelsDown) {
  for (const Ground ground : {Ground::hills, Ground::rough}) {
    for (const unsigned seed : {1u, 2u}) {
      Driver driver({.ground = ground, .friction = 0.5, .seed = seed});
      driver.drive(0.5);
      int in_the_air = 0;
      double most_tilt_rad = 0;
      for (int i = 0; i < 80; ++i) {
        driver.run(0.1);
        for (const double load_N : driver.rover.loads_N()) in_the_air += load_N < 1 ? 1 : 0;
        const Eigen::Vector3d up = driver.rover.body().attitude * Eigen::Vector3d::UnitZ();
        most_tilt_rad = std::max(most_tilt_rad, std::acos(up.z()));
      }
      EXPECT_LT(in_the_air, 6) << seed;
      EXPECT_LT(most_tilt_rad, 0.35) << seed;
      EXPECT_GT(most_tilt_rad, 0.01) << seed;
      EXPECT_NEAR(driver.rover.body().position_m.head<2>().norm(), 3.9, 0.4) << seed;
    }
  }
}

TEST(Terrain, TheNearestPointIsWhereTheNormalMeetsTheCentre) {
  const Terrain terrain(Ground::rough, 5);
  GroundPoint point;
  for (double x_m = 3.5; x_m < 8; x_m += 0.05) {
    const double z_m = terrain.height_m(x_m, 1) + 0.16;
    point = terrain.nearest(x_m, 1, z_m, point);
    const double dx = x_m - point.x_m, dy = 1 - point.y_m, dz = z_m - point.z_m;
    const double distance = std::sqrt(dx * dx + dy * dy + dz * dz);
    EXPECT_NEAR(point.z_m, terrain.height_m(point.x_m, point.y_m), 1e-9);
    EXPECT_NEAR(dx / distance, point.normal[0], 1e-3);
    EXPECT_NEAR(dy / distance, point.normal[1], 1e-3);
    EXPECT_NEAR(dz / distance, point.normal[2], 1e-3);
  }
}

TEST(Terrain, TheSeedMakesTheGroundAndTheStartIsLevel) {
  const Terrain one(Ground::hills, 1), same(Ground::hills, 1), other(Ground::hills, 2);
  EXPECT_EQ(one.height_m(9, 4), same.height_m(9, 4));
  EXPECT_NE(one.height_m(9, 4), other.height_m(9, 4));
  EXPECT_EQ(one.height_m(0.5, 0.5), 0);
}

TEST(Rover, AStepIsMuchFasterThanTheTimeThatItStandsFor) {
  Driver driver({.ground = Ground::rough, .friction = 0.5});
  driver.drive(0.5);
  driver.run(1);
  const double took_s = cpu_s_of(driver, 2);
  std::printf("%.0f us of CPU time for a step of 1 ms\n", took_s / 2000 * 1e6);
#ifndef LSS_SANITIZED
  EXPECT_LT(took_s, 1.0);
#endif
}

}  // namespace
}  // namespace lss::sim::ardito
