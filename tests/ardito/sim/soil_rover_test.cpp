// D.I.A.N.A. Ardito on soil, its shafts turned directly, and one of its wheels alone.

#include <gtest/gtest.h>

#include <stdexcept>
#include <vector>

#include "idl/angles.h"
#include "tests/ardito/sim/driver.h"
#include "tools/lss-sim/ardito/kinematic.h"
#include "tools/lss-sim/ardito/vehicle.h"
#include "tools/lss-sim/ardito/wheel_in_soil.h"

namespace lss::sim::ardito {
namespace {

using soil::kEarth_m_s2;
using soil::kMoon_m_s2;

constexpr soil::Wheel kWheel = {.radius_m = dimensions::kWheelRadius_m, .width_m = kWheelWidth_m};

RoverOptions on(const char* ground, double slope_deg = 0, double gravity_m_s2 = kEarth_m_s2) {
  return {.soil = soil::parse_soil(ground),
          .gravity_m_s2 = gravity_m_s2,
          .slope_rad = slope_deg * kDegree};
}

// ---- one wheel

struct Pull {
  double shear_N, pull_N, sinkage_m;
};
// At this slip, when it has rolled for long.
Pull roll(const soil::Soil& ground, double load_N, double slip) {
  WheelInSoil wheel(ground, load_N);
  SoilGrip grip;
  constexpr double kRim_m_s = 0.2;
  for (int i = 0; i < 20'000; ++i) grip = wheel.step({load_N, kRim_m_s, (1 - slip) * kRim_m_s, 0});
  const double shear_N = std::min(slip * kRim_m_s / grip.compliance_m_sN, grip.friction * load_N);
  return {shear_N, shear_N + grip.resistance_N, wheel.sinkage_m()};
}

TEST(WheelInSoil, PullsAsTheModelOfSoilSaysAtEverySlip) {
  constexpr double kLoad_N = 80;
  for (const char* name : {"sand", "loam", "regolith"}) {
    const soil::Soil ground = soil::in_gravity(soil::parse_soil(name), kEarth_m_s2);
    double last_N = 0;
    for (const double slip : {0.05, 0.1, 0.2, 0.4, 0.7, 1.0}) {
      SCOPED_TRACE(testing::Message() << name << " " << slip);
      const Pull is = roll(ground, kLoad_N, slip);
      const double depth_m = soil::sinkage_m(ground, kWheel, kLoad_N, slip);
      const soil::WheelForces model = soil::on_soil(ground, kWheel, depth_m, slip);
      EXPECT_NEAR(is.sinkage_m, depth_m, 0.01 * depth_m);
      EXPECT_NEAR(is.shear_N, model.thrust_N, 0.02 * kLoad_N);
      if (slip < 1) {
        EXPECT_NEAR(is.pull_N, model.pull_N(), 0.03 * kLoad_N);
      }
      EXPECT_GT(is.shear_N, last_N) << "more slip, more thrust";
      last_N = is.shear_N;
    }
  }
}

TEST(WheelInSoil, ThrustEndsAtTheStrengthOfTheSoil) {
  constexpr double kLoad_N = 80;
  const soil::Soil ground = soil::in_gravity(soil::parse_soil("regolith"), kEarth_m_s2);
  const double gain_N = roll(ground, kLoad_N, 0.2).shear_N - roll(ground, kLoad_N, 0.1).shear_N;
  const double late_N = roll(ground, kLoad_N, 1.0).shear_N - roll(ground, kLoad_N, 0.9).shear_N;
  EXPECT_LT(late_N, 0.3 * gain_N);
  const WheelInSoil wheel(ground, kLoad_N);
  WheelInSoil moved = wheel;
  const SoilGrip grip = moved.step({kLoad_N, 0, 0, 0});
  const double rim_m2 =
      1.1 * std::acos(1 - wheel.sinkage_m() / kWheel.radius_m) * kWheel.radius_m * kWheel.width_m;
  EXPECT_NEAR(grip.friction * kLoad_N,
              ground.cohesion_Pa * rim_m2 + kLoad_N * std::tan(ground.friction_rad), 1e-6);
}

// Soil in front hinders motion and never makes any: its work on a wheel that goes to and fro is
// not positive.
TEST(WheelInSoil, GivesNoWork) {
  WheelInSoil wheel(soil::in_gravity(soil::parse_soil("sand"), kEarth_m_s2), 80);
  double work_J = 0, least_J = 0;
  for (int i = 0; i < 20'000; ++i) {
    const double ahead_m_s = 0.1 * std::sin(i * 0.003) + 0.02 * std::sin(i * 0.05);
    const SoilGrip grip = wheel.step({80, ahead_m_s, ahead_m_s, 0});
    work_J += grip.resistance_N * ahead_m_s * kStep_s;
    least_J = std::min(least_J, work_J);
    EXPECT_LE(work_J, least_J + 0.02) << "more than is stored in the soil before it yields";
  }
  EXPECT_LT(work_J, -1);
}

TEST(WheelInSoil, ForwardAndBackwardAreTheSame) {
  const soil::Soil ground = soil::in_gravity(soil::parse_soil("sand"), kEarth_m_s2);
  WheelInSoil forward(ground, 80), backward(ground, 80);
  for (int i = 0; i < 2000; ++i) {
    const SoilGrip one = forward.step({80, 0.2, 0.15, 0.01});
    const SoilGrip other = backward.step({80, -0.2, -0.15, -0.01});
    EXPECT_EQ(one.resistance_N, -other.resistance_N);
    EXPECT_EQ(one.compliance_m_sN, other.compliance_m_sN);
    EXPECT_EQ(one.rolling_Nm, other.rolling_Nm);
  }
  EXPECT_EQ(forward.sinkage_m(), backward.sinkage_m());
}

TEST(WheelInSoil, ThatSpinsOnThePlaceDigsItselfInAndComesOutByRolling) {
  const soil::Soil ground = soil::in_gravity(soil::parse_soil("sand"), kEarth_m_s2);
  WheelInSoil wheel(ground, 80);
  const double at_rest_m = wheel.sinkage_m();
  for (int i = 0; i < 1000; ++i) wheel.step({80, 0, 0, 0});
  EXPECT_NEAR(wheel.sinkage_m(), at_rest_m, 1e-4);
  for (int i = 0; i < 10'000; ++i) wheel.step({80, 0.2, 0, 0});
  EXPECT_GT(wheel.sinkage_m(), 2 * at_rest_m);
  for (int i = 0; i < 10'000; ++i) wheel.step({80, 0.2, 0.2, 0});
  EXPECT_LT(wheel.sinkage_m(), 1.2 * at_rest_m);
}

// ---- the rover

TEST(RoverOnSoil, RestsAtTheDepthWhereEachWheelCarriesItsLoad) {
  for (const char* name : {"sand", "loam"}) {
    for (const double gravity_m_s2 : {kEarth_m_s2, kMoon_m_s2}) {
      SCOPED_TRACE(testing::Message() << name << " " << gravity_m_s2);
      Driver driver(on(name, 0, gravity_m_s2));
      driver.run(1);
      std::array<double, kWheels> mean_N{};
      constexpr int kLooks = 250;  // contacts shake
      for (int i = 0; i < kLooks; ++i) {
        driver.run(0.002);
        for (std::size_t w = 0; w < kWheels; ++w) mean_N[w] += driver.rover.loads_N()[w] / kLooks;
      }
      const soil::Soil ground = soil::in_gravity(soil::parse_soil(name), gravity_m_s2);
      double weight_N = 0;
      for (std::size_t i = 0; i < kWheels; ++i) {
        const double load_N = mean_N[i];
        const double expected_m = soil::sinkage_m(ground, kWheel, load_N, 0);
        // What was pressed down while it settled does not rise again.
        EXPECT_GT(driver.rover.sinkage_m(i), 0.97 * expected_m);
        EXPECT_LT(driver.rover.sinkage_m(i), 1.1 * expected_m);
        weight_N += load_N;
      }
      EXPECT_NEAR(weight_N, dimensions::kMass_kg * gravity_m_s2, 0.02 * weight_N);
      EXPECT_LT(driver.rover.body().velocity_m_s.norm(), 1e-3);
    }
  }
}

TEST(RoverOnSoil, StandsOnASlopeThatTheSoilHoldsAndSlidesOnOneThatItDoesNot) {
  for (const auto& [name, gravity_m_s2] :
       {std::pair("sand", kMoon_m_s2), {"loam", kEarth_m_s2}, {"regolith", kEarth_m_s2}}) {
    SCOPED_TRACE(name);
    Driver driver(on(name, 15, gravity_m_s2));
    driver.run(1);
    const Eigen::Vector3d from_m = driver.rover.body().position_m;
    driver.run(2);
    EXPECT_LT((driver.rover.body().position_m - from_m).norm(), 4e-4);
  }
  Driver steep(on("regolith", 42));  // phi is 35 deg, cohesion next to nothing
  steep.run(1);
  EXPECT_LT(steep.rover.body().velocity_m_s.x(), -0.1);
}

TEST(RoverOnSoil, ClimbsWhileItsSlipGrowsWithTheSlopeAndIsStuckWhereThePullEnds) {
  double last_m_s = 1;
  for (const double slope_deg : {0.0, 5.0, 10.0}) {
    Driver driver(on("regolith", slope_deg));
    driver.drive(0.2);
    driver.run(3);
    const double from_m = driver.x_m();
    driver.run(2);
    const double speed_m_s = (driver.x_m() - from_m) / 2;
    EXPECT_LT(speed_m_s, last_m_s - 0.005) << slope_deg;
    EXPECT_GT(speed_m_s, 0.01) << slope_deg;
    last_m_s = speed_m_s;
  }
  Driver driver(on("sand", 10));  // a wheel pulls 8 % of its load at best
  driver.drive(0.2);
  driver.run(4);
  const double from_m = driver.x_m();
  driver.run(2);
  EXPECT_LT(driver.x_m() - from_m, 0.02);
  for (std::size_t i = 0; i < kWheels; ++i) {
    EXPECT_GT(driver.rover.sinkage_m(i), 0.04);
  }
}

TEST(RoverOnSoil, WithFreeWheelsComesToRestAndStays) {
  for (const char* name : {"sand", "loam"}) {
    Driver driver(on(name));
    driver.drive(0.5);
    driver.run(1);
    driver.torque_Nm.fill(0);
    double energy_J = 1e9;
    for (int i = 0; i < 20; ++i) {
      driver.run(0.1);
      const double now_J = driver.rover.body().velocity_m_s.squaredNorm();
      EXPECT_LT(now_J, energy_J + 1e-5) << name;
      energy_J = now_J;
    }
    const double from_m = driver.x_m();
    driver.run(1);
    EXPECT_NEAR(driver.x_m(), from_m, 1e-3) << name;
  }
}

TEST(RoverOnSoil, DrivesStraightAndTurnsTheSameWayLeftAndRight) {
  Driver driver(on("regolith"));
  driver.drive(0.3);
  driver.run(3);
  EXPECT_NEAR(driver.rover.body().position_m.y(), 0, 0.01);
  EXPECT_GT(driver.x_m(), 0.5);
  std::vector<double> turned;
  for (const double way : {1.0, -1.0}) {
    Driver spot(on("regolith"));
    follow_circle(spot, 0, 0);
    spot.run(2);
    follow_circle(spot, 0, 0.15 * way);
    spot.run(4);
    turned.push_back(spot.rover.body().attitude.angularDistance(Eigen::Quaterniond::Identity()));
    EXPECT_LT(spot.rover.body().position_m.head<2>().norm(), 0.2);
  }
  EXPECT_GT(turned[0], 0.2);
  EXPECT_NEAR(turned[0], turned[1], 0.02 * turned[0]);
}

TEST(RoverOnSoil, DrivesOverHillsAndRoughGround) {
  for (const Ground ground : {Ground::hills, Ground::rough}) {
    RoverOptions options = on("regolith");
    options.ground = ground;
    Driver driver(options);
    driver.drive(0.4);
    for (int i = 0; i < 60; ++i) {
      driver.run(0.1);
      for (std::size_t w = 0; w < kWheels; ++w) {
        EXPECT_LT(driver.rover.sinkage_m(w), 0.1);
        EXPECT_GT(driver.rover.sinkage_m(w), -0.05);
      }
    }
    EXPECT_GT(driver.rover.body().position_m.head<2>().norm(), 1.0);
  }
}

TEST(RoverOnSoil, AWheelSinksInAPatchAloneAndComesOutBehindIt) {
  RoverOptions options = on("regolith");
  options.patches.push_back(parse_patch("sand:0.1@4@0.5..1.4"));
  Driver driver(options);  // wheel 4 begins 70 mm behind the origin
  driver.drive(0.3);
  const auto axle_m = [&] { return driver.x_m() - dimensions::kCentre_m; };
  while (axle_m() < 0.5) driver.run(0.05);
  EXPECT_LT(driver.rover.sinkage_m(3), 0.02);
  while (axle_m() < 1.1) driver.run(0.05);
  for (std::size_t i = 0; i < kWheels; ++i) {
    EXPECT_EQ(driver.rover.sinkage_m(i) > 0.02, i == 3) << i;
  }
  EXPECT_GT(driver.rover.sinkage_m(3), 0.07);
  while (axle_m() < 2) driver.run(0.05);
  EXPECT_LT(driver.rover.sinkage_m(3), 0.02);
}

TEST(RoverOnSoil, TheSameDriveGivesTheSameBits) {
  const auto drive = [] {
    Driver driver(on("sand"));
    driver.drive(0.3);
    driver.run(0.7);
    return driver.rover.body().position_m;
  };
  EXPECT_EQ(drive(), drive());
}

TEST(RoverOnSoil, ThereIsNoStepAndNoKinematicPlant) {
  RoverOptions options = on("sand");
  options.step_height_m = 0.06;
  EXPECT_THROW(Rover{options}, std::invalid_argument);
  options = on("sand");
  options.plant = PlantKind::kinematic;
  EXPECT_THROW(Ardito{options}, std::invalid_argument);
}

double cpu_s_of(const RoverOptions& options) {
  Driver driver(options);
  driver.drive(0.3);
  driver.run(1);
  return cpu_s_of(driver, 2);
}

TEST(RoverOnSoil, CostsAtMostThreeTimesHardGround) {
  const double hard_s = cpu_s_of({}), soil_s = cpu_s_of(on("regolith"));
  std::printf("a simulated second: %.0f ms on hard ground, %.0f ms on regolith\n", hard_s / 2 * 1e3,
              soil_s / 2 * 1e3);
#ifndef LSS_SANITIZED
  EXPECT_LT(soil_s, 3 * hard_s);
#endif
}

}  // namespace
}  // namespace lss::sim::ardito
