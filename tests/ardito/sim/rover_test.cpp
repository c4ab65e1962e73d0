// The rover in physics, its shafts turned directly.

#include "tools/lss-sim/ardito/rover.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <cstdio>
#include <numbers>

namespace lss::sim::ardito {
namespace {

using namespace dimensions;
constexpr double kTorque_Nm = 15;

double yaw_rad(const BodyState& body) {
  const Eigen::Vector3d ahead = body.attitude * Eigen::Vector3d::UnitX();
  return std::atan2(ahead.y(), ahead.x());
}

class Driver {
 public:
  explicit Driver(const RoverOptions& options) : rover(options) {}

  // Wheels at these speeds of their treads, after a ramp of 0.5 s; steering at these angles.
  void run(double seconds) {
    for (long i = std::lround(seconds / kStep_s); i > 0; --i) {
      std::array<ShaftDrive, kWheels> drives;
      for (std::size_t w = 0; w < kWheels; ++w) {
        const double wanted = treads_m_s[w] / kWheelRadius_m;
        speeds_[w] += std::clamp(wanted - speeds_[w], -0.01, 0.01);
        drives[w] = {speeds_[w], torque_Nm[w]};
      }
      std::array<ShaftDrive, kSteered> turns;
      for (std::size_t s = 0; s < kSteered; ++s) {
        const double error_rad = angles_rad[s] - rover.steering()[s].angle_rad;
        turns[s] = {std::clamp(20 * error_rad, -0.5, 0.5), 20};
      }
      rover.step(drives, turns);
    }
  }
  void drive(double speed_m_s) { treads_m_s.fill(speed_m_s); }
  double x_m() const { return rover.body().position_m.x(); }

  Rover rover;
  std::array<double, kWheels> treads_m_s{};
  std::array<double, kWheels> torque_Nm{kTorque_Nm, kTorque_Nm, kTorque_Nm,
                                        kTorque_Nm, kTorque_Nm, kTorque_Nm};
  std::array<double, kSteered> angles_rad{};

 private:
  std::array<double, kWheels> speeds_{};
};

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

// Ackermann angles and speeds for a circle around a point `radius_m` to the right on the middle
// axle, worked out from the ground plan.
void follow_circle(Driver& driver, double radius_m, double rate_rad_s) {
  const double ahead_m[] = {kFront_m, kFront_m, 0, 0, -kRear_m, -kRear_m};
  for (std::size_t wheel = 0; wheel < kWheels; ++wheel) {
    const double side_m = radius_m + (wheel % 2 == 0 ? kTrack_m / 2 : -kTrack_m / 2);
    const double angle_rad = -std::atan(ahead_m[wheel] / side_m);
    driver.treads_m_s[wheel] =
        std::copysign(std::hypot(ahead_m[wheel], side_m), side_m) * rate_rad_s;
    const auto* steered = std::ranges::find(kSteeredWheels, wheel);
    if (steered == kSteeredWheels.end()) continue;
    driver.angles_rad[static_cast<std::size_t>(steered - kSteeredWheels.begin())] = angle_rad;
  }
}

TEST(Rover, TurnsOnTheSpotAndToTheRight) {
  Driver driver({});
  follow_circle(driver, 0, 0);
  driver.run(3);
  follow_circle(driver, 0, 0.1458);
  driver.run(6);
  EXPECT_NEAR(driver.rover.body().yaw_rate_rad_s, -0.1458, 0.005);
  EXPECT_NEAR(yaw_rad(driver.rover.body()), -0.1458 * 5.9, 0.05);
  // The middle of the axles is where it turns; the centre of mass goes round it.
  EXPECT_LT(driver.rover.body().position_m.head<2>().norm(), 2 * kCentre_m);
}

TEST(Rover, FollowsACircleOnItsAckermannAngles) {
  Driver driver({});
  follow_circle(driver, 0.8, 0);
  driver.run(2);
  follow_circle(driver, 0.8, 0.3);
  driver.run(4);
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
  timespec before{}, after{};
  ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &before);
  driver.run(2);
  ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &after);
  const double took_s = static_cast<double>(after.tv_sec - before.tv_sec) +
                        static_cast<double>(after.tv_nsec - before.tv_nsec) * 1e-9;
  std::printf("%.0f us of CPU time for a step of 1 ms\n", took_s / 2000 * 1e6);
#ifndef LSS_SANITIZED
  EXPECT_LT(took_s, 1.0);
#endif
}

}  // namespace
}  // namespace lss::sim::ardito
