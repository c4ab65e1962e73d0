// Air, slopes, and the errors of a day in the field.

#include "tools/lss-sim/talaris/air.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tools/lss-sim/talaris/vehicle.h"

namespace lss::sim::talaris {
namespace {

constexpr double kFlying_rpm = 4 * 29'400.0;

TEST(TalarisAir, WithoutAirThereIsNoForce) {
  Air air({}, 1);
  BodyState body;
  body.velocity_m_s = {0, 3, 4};
  EXPECT_EQ(air.step(body, kFlying_rpm).force_N.norm(), 0);
}

// The fans take in 4 kg/s: 20 N in a breeze of 5 m/s, and drag besides.
TEST(TalarisAir, FansAndFrameAreCarriedAwayByABreeze) {
  Air air({.density_kg_m3 = 1.2, .wind_m_s = 5}, 1);
  const Wrench still = air.step({}, 0), flying = air.step({}, kFlying_rpm);
  EXPECT_NEAR(still.force_N.z(), 0.6 * 0.35 * 25, 1e-9);
  EXPECT_NEAR(flying.force_N.z() - still.force_N.z(), 20, 0.1);
  EXPECT_EQ(flying.force_N.y(), 0);
  EXPECT_NEAR(flying.torque_Nm.y(), -0.05 * flying.force_N.z(), 1e-9) << "it acts above the origin";
}

TEST(TalarisAir, MovingIsLikeWindAgainstIt) {
  Air air({.density_kg_m3 = 1.2}, 1);
  BodyState body;
  body.velocity_m_s = {0, 0, 3};
  EXPECT_LT(air.step(body, kFlying_rpm).force_N.z(), -12);
}

TEST(TalarisAir, GustsRiseAndFallWithinTheirBounds) {
  Air air({.push_N = 20, .gust_N = 20, .to_rad = M_PI / 2}, 3);
  double most_N = 0, least_N = 99, step_N = 0, last_N = 20;
  for (int ms = 0; ms < 60'000; ++ms) {
    air.step({}, 0);
    const double now_N = air.push_N().norm();
    most_N = std::max(most_N, now_N);
    least_N = std::min(least_N, now_N);
    step_N = std::max(step_N, std::abs(now_N - last_N));
    last_N = now_N;
  }
  EXPECT_GT(most_N, 35);
  EXPECT_LE(most_N, 40);
  EXPECT_NEAR(least_N, 20, 1e-9);
  EXPECT_LT(step_N, 0.1);
}

TEST(TalarisSlope, ItStandsOnTheSlopeAndStays) {
  const PlantOptions options{.slope_rad = 8 * kDegree, .uphill_rad = 0.5};
  Plant plant(options);
  const BodyState before = plant.body();
  for (int ms = 0; ms < 3'000; ++ms) plant.step({}, 0, Vector3::Zero());
  EXPECT_LT((plant.body().position_m - before.position_m).norm(), 2e-3);
  EXPECT_LT(plant.body().velocity_m_s.norm(), 1e-5);
  EXPECT_TRUE(plant.contact());
  EXPECT_NEAR((plant.body().attitude * Vector3::UnitX()).x(), std::cos(8 * kDegree), 1e-3);
  const auto range = plant.distance_m(Vector3::Zero(), -Vector3::UnitX(), 0.9);
  ASSERT_TRUE(range);
  EXPECT_NEAR(*range, 0.247, 2e-3);
}

TEST(TalarisSlope, TheGroundRisesUphill) {
  const auto clearance = [](double uphill_rad) {
    Plant plant({.height_m = 2, .slope_rad = 8 * kDegree, .uphill_rad = uphill_rad});
    for (int ms = 0; ms < 300; ++ms) plant.step({}, 0, {45 * kGravity_m_s2, 0, 200});
    return plant.clearance_m();
  };
  EXPECT_LT(clearance(0), clearance(M_PI) - 0.01);
}

TEST(TalarisField, OpenValvesShareThePressure) {
  ColdGas gas({.droop = 0.02});
  for (int ms = 0; ms < 50; ++ms) gas.step(0b1);
  EXPECT_NEAR(gas.thrust_N(0), 58, 1e-9);
  for (int ms = 0; ms < 50; ++ms) gas.step(0b1010101);
  EXPECT_NEAR(gas.thrust_N(0), 58 * 0.94, 1e-9);
}

TEST(TalarisField, TanksThatAreNotFullEmptyEarlier) {
  ColdGas gas({.fill = 0.9});
  EXPECT_NEAR(gas.left_s(), 0.9 * 44, 1e-9);
  EXPECT_EQ(gas.used_s(), 0);
  EXPECT_NEAR(gas.tank_kPa(), 0.9 * kFullTank_kPa, 1e-6);
}

TEST(TalarisField, FansThatAreNotAlikeTurnTheVehicle) {
  FanOptions options{.torque_m = 0.004, .started = true};
  options.torque_scale = {1.1, 1, 1.1, 1};
  Fans alike({.torque_m = 0.004, .started = true}), unlike(options);
  for (int ms = 0; ms < 3'000; ++ms) {
    alike.step({1900, 1900, 1900, 1900});
    unlike.step({1900, 1900, 1900, 1900});
  }
  EXPECT_NEAR(alike.wrench().torque_Nm.x(), 0, 1e-9);
  EXPECT_NEAR(unlike.wrench().torque_Nm.x(), -0.2 * 0.004 * unlike.thrust_N(0), 1e-6);
}

// Neighbours turn against each other: what a failed one leaves turns the vehicle.
TEST(TalarisField, AFailedFanLeavesTheTorqueOfTheOthers) {
  Fans broken({.torque_m = 0.004, .started = true});
  Fans dead({.torque_m = 0.004, .rotor_kg_m2 = 2e-4, .started = true});
  for (int ms = 0; ms < 3'000; ++ms) {
    broken.step({1900, 1900, 1900, 1900});
    dead.step({1900, 1900, 1900, 1900});
  }
  const double each_N = broken.thrust_N(0), rpm = broken.rpm(1);
  broken.broken[1] = dead.dead[1] = true;
  double turned_Nms = 0;
  for (int ms = 0; ms < 3'000; ++ms) {
    broken.step({1900, 1900, 1900, 1900});
    dead.step({1900, 1900, 1900, 1900});
    turned_Nms += kStep_s * (dead.wrench().torque_Nm.x() + 0.004 * (each_N - dead.thrust_N(1)));
  }
  EXPECT_NEAR(broken.rpm(1), rpm, 1);
  EXPECT_NEAR(broken.wrench().force_N.x(), 3 * each_N, 0.1);
  EXPECT_NEAR(broken.wrench().torque_Nm.x(), -0.004 * each_N, 1e-4);
  // the rotor that stops takes the vehicle with it
  EXPECT_NEAR(turned_Nms, -2e-4 * rpm * 2 * std::numbers::pi / 60, 1e-3);
}

TEST(TalarisField, TheWideSetIsDrawnWithinItsBoundsAndTheNarrowOneAsBefore) {
  const TalarisOptions nominal;
  double slope_rad = 0, wind_m_s = 0, fill = 1;
  for (unsigned seed = 0; seed < 200; ++seed) {
    const TalarisOptions narrow = dispersed(nominal, seed), wide = dispersed(nominal, seed, kWide);
    EXPECT_EQ(narrow.plant.mass_kg, wide.plant.mass_kg);
    EXPECT_EQ(narrow.air.density_kg_m3, 0);
    EXPECT_EQ(narrow.plant.slope_rad, 0);
    slope_rad = std::max(slope_rad, wide.plant.slope_rad);
    wind_m_s = std::max(wind_m_s, wide.air.wind_m_s);
    fill = std::min(fill, wide.gas.fill);
    EXPECT_LE(wide.plant.cg_m.tail(2).cwiseAbs().maxCoeff(), kWide.cg_m);
    EXPECT_LE(std::abs(wide.altimeter.bias_m), kWide.altimeter_bias_m);
  }
  EXPECT_NEAR(slope_rad, kWide.slope_rad, 0.1 * kDegree);
  EXPECT_NEAR(wind_m_s, kWide.wind_m_s, 0.1);
  EXPECT_NEAR(fill, 1 - kWide.tank_fill, 0.002);
}

}  // namespace
}  // namespace lss::sim::talaris
