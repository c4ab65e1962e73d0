// The rigid body, its legs and the test stands.

#include "tools/lss-sim/talaris/plant.h"

#include <gtest/gtest.h>

#include <cmath>

namespace lss::sim::talaris {
namespace {

const Vector3 kNoPush = Vector3::Zero();
constexpr double kWeight_N = 45 * kGravity_m_s2;

void run(Plant& plant, double seconds, const Wrench& wrench = {}, const Vector3& push = kNoPush) {
  for (int i = 0; i < std::lround(seconds / kStep_s); ++i) plant.step(wrench, 0, push);
}

Wrench force(double x, double y, double z) { return {.force_N = {x, y, z}}; }
double tilt_rad(const BodyState& body) {
  return std::acos(std::min(1.0, (body.attitude * Vector3::UnitX()).x()));
}

TEST(TalarisPlant, StandsStillOnItsLegs) {
  Plant plant({});
  run(plant, 3);
  const BodyState at_first = plant.body();
  for (int i = 0; i < 2'000; ++i) {
    run(plant, kStep_s);
    ASSERT_LT(plant.body().velocity_m_s.norm(), 1e-6);
    ASSERT_LT(plant.body().rate_B_rad_s.norm(), 1e-6);
  }
  EXPECT_LT((plant.body().position_m - at_first.position_m).norm(), 1e-6);
  EXPECT_LT(plant.body().position_m.norm(), 1e-4);
  EXPECT_NEAR(plant.body().force_B_m_s2.x(), kGravity_m_s2, 1e-6);
  EXPECT_TRUE(plant.contact());
}

TEST(TalarisPlant, FallsFreelyAndFeelsNothingMeanwhile) {
  Plant plant({.height_m = 2});
  run(plant, 0.5);
  EXPECT_NEAR(plant.body().position_m.x(), 2 - 0.5 * kGravity_m_s2 * 0.25, 3e-3);
  EXPECT_NEAR(plant.body().velocity_m_s.x(), -0.5 * kGravity_m_s2, 1e-6);
  EXPECT_LT(plant.body().force_B_m_s2.norm(), 1e-9);
  EXPECT_FALSE(plant.contact());
}

TEST(TalarisPlant, TumblesWithoutGainingEnergyOrAngularMomentum) {
  Plant plant({.cg_m = {0.01, 0.02, -0.01}, .height_m = 20});
  const Vector3 carried(kWeight_N, 0, 0);
  run(plant, 0.5, {.torque_Nm = {3, 5, 4}}, carried);
  const Vector3 inertia(4.5, 3.0, 1.8);
  const auto momentum = [&]() -> Vector3 {
    const BodyState& body = plant.body();
    return body.attitude * inertia.cwiseProduct(body.rate_B_rad_s);
  };
  const double energy_J = plant.energy_J();
  const Vector3 before = momentum();
  run(plant, 2, {}, carried);
  EXPECT_NEAR(plant.energy_J(), energy_J, 0.02);
  EXPECT_LT((momentum() - before).norm(), 0.005 * before.norm());
  EXPECT_GT(tilt_rad(plant.body()), 0.5);
}

TEST(TalarisPlant, HoversWithItsWeightAsThrust) {
  Plant plant({.height_m = 2});
  run(plant, 5, force(kWeight_N, 0, 0));
  EXPECT_NEAR(plant.body().position_m.x(), 2, 1e-9);
  EXPECT_LT(plant.body().velocity_m_s.norm(), 1e-9);
}

TEST(TalarisPlant, LandsSoftlyComesToRestAndKnowsHowFastItWas) {
  Plant plant({.height_m = 0.2});
  run(plant, 1.2);
  EXPECT_NEAR(plant.touchdown().down_m_s, std::sqrt(2 * kGravity_m_s2 * 0.2), 0.1);
  EXPECT_LT(plant.body().velocity_m_s.norm(), 1e-3);
  EXPECT_LT(plant.body().position_m.norm(), 1e-3);
  EXPECT_TRUE(plant.contact());
}

TEST(TalarisPlant, AFootThatComesDownLaterAndFasterCounts) {
  Plant plant({.tilt_rad = 0.15, .height_m = 0.1});
  run(plant, 0.15);
  const double first = plant.touchdown().down_m_s;
  run(plant, 1.5);
  EXPECT_GT(first, 0.5);
  EXPECT_GT(plant.touchdown().down_m_s, first);
  EXPECT_LT(tilt_rad(plant.body()), 1e-3);
}

TEST(TalarisPlant, FeetStickUntilThePushIsMoreThanFriction) {
  Plant plant({.ground_friction = 0.5});
  run(plant, 1, {}, {0, 0, 0.4 * kWeight_N});
  EXPECT_LT(std::abs(plant.body().position_m.z()), 0.01);
  run(plant, 1, {}, {0, 0, 0.7 * kWeight_N});
  EXPECT_GT(plant.body().position_m.z(), 0.3);
}

TEST(TalarisPlant, ACentreOfMassBesideTheThrustTiltsIt) {
  Plant plant({.cg_m = {0, 0, 0.01}, .height_m = 5});
  run(plant, 0.5, force(kWeight_N, 0, 0));
  // The thrust is at z = -0.01 from the centre of mass: about y by z F.
  EXPECT_NEAR(plant.body().rate_B_rad_s.y(), -0.01 * kWeight_N / 3.0 * 0.5, 0.02);
}

TEST(TalarisPlant, GasThatIsGoneWeighsNothing) {
  Plant plant({.height_m = 5});
  for (int i = 0; i < 500; ++i) plant.step(force(kWeight_N, 0, 0), 2, kNoPush);
  EXPECT_NEAR(plant.mass_kg(), 43, 1e-12);
  EXPECT_NEAR(plant.body().velocity_m_s.x(), 2 * kGravity_m_s2 / 43 * 0.5, 1e-3);
}

TEST(TalarisPlant, ARailLetsItGoAheadOnlyAndBrakesIt) {
  Plant plant({.stand = Stand::rail, .friction_m_s2 = 0.1});
  run(plant, 1, force(0, 0, 4));  // less than friction
  EXPECT_EQ(plant.body().position_m.z(), 0);
  run(plant, 1, {.force_N = {50, 50, 49.5}, .torque_Nm = {5, 5, 5}});
  EXPECT_NEAR(plant.body().velocity_m_s.z(), 1.0, 1e-6);
  EXPECT_EQ(plant.body().position_m.head(2).norm(), 0);
  EXPECT_EQ(tilt_rad(plant.body()), 0);
  run(plant, 11);
  EXPECT_EQ(plant.body().velocity_m_s.z(), 0);
}

TEST(TalarisPlant, TheWallHasABumper) {
  Plant plant({.stand = Stand::rail, .wall_m = 1});
  run(plant, 3, force(0, 0, 60));
  EXPECT_TRUE(plant.contact());
  EXPECT_LT(plant.body().position_m.z(), 0.5);
}

TEST(TalarisPlant, ASledMovesInItsPlaneOnly) {
  Plant plant({.stand = Stand::sled, .heading_rad = 0.5});
  run(plant, 2, {.force_N = {100, 3, 20}, .torque_Nm = {2, 50, 50}});
  const BodyState& body = plant.body();
  EXPECT_EQ(body.position_m.x(), 0);
  EXPECT_NEAR(tilt_rad(body), 0, 1e-7);
  EXPECT_EQ(body.rate_B_rad_s.tail(2).norm(), 0);
  EXPECT_GT(body.rate_B_rad_s.x(), 0.5);
  EXPECT_GT(std::hypot(body.position_m.y(), body.position_m.z()), 0.2);
}

TEST(TalarisPlant, ABalancedPivotStaysAndAWeightTurnsItToItsStop) {
  Plant balanced({.stand = Stand::pivot, .tilt_rad = 0.1});
  run(balanced, 5);
  EXPECT_NEAR(tilt_rad(balanced.body()), 0.1, 1e-9);
  Plant loaded({.stand = Stand::pivot, .weight_kg = 1});
  run(loaded, 5);
  EXPECT_NEAR(tilt_rad(loaded.body()), 0.6, 0.02);
  Plant held({.stand = Stand::pivot, .weight_kg = 1});
  run(held, 5, {.torque_Nm = {0, 0.4 * kGravity_m_s2, 0}});
  EXPECT_NEAR(tilt_rad(held.body()), 0, 1e-6);
}

TEST(TalarisPlant, TheAxisOfAPivotMayBeYaw) {
  Plant plant({.stand = Stand::pivot, .axis = Axis::yaw});
  run(plant, 0.5, {.torque_Nm = {5, 5, 0.5}});
  EXPECT_EQ(plant.body().rate_B_rad_s.head(2).norm(), 0);
  EXPECT_NEAR(plant.body().rate_B_rad_s.z(), (0.5 - 0.1 * 1.8 / 1.8) / 1.8 * 0.5, 0.01);
}

TEST(TalarisPlant, TheCounterweightCarriesFiveSixths) {
  Plant plant({.stand = Stand::lift, .friction_m_s2 = 0});
  run(plant, 1);
  EXPECT_LT(std::abs(plant.body().position_m.x()), 1e-4);
  run(plant, 1, force(kWeight_N / 6 + 8.25, 0, 0));
  // Both masses are accelerated.
  EXPECT_NEAR(plant.body().velocity_m_s.x(), 8.25 / 82.5, 0.02);
  EXPECT_EQ(plant.body().position_m.tail(2).norm(), 0);
}

TEST(TalarisPlant, TheFansStandGoesUpAndDownOnly) {
  Plant plant({.stand = Stand::fans, .height_m = 0.1});
  run(plant, 1, {.force_N = {kWeight_N + 45, 30, 30}, .torque_Nm = {5, 5, 5}});
  EXPECT_NEAR(plant.body().velocity_m_s.x(), 0.95, 0.02);
  EXPECT_EQ(plant.body().position_m.tail(2).norm(), 0);
  EXPECT_EQ(tilt_rad(plant.body()), 0);
}

TEST(TalarisPlant, TheLoadStandDoesNotMove) {
  Plant plant({.stand = Stand::load});
  run(plant, 1, {.force_N = {300, 30, 30}, .torque_Nm = {5, 5, 5}});
  EXPECT_EQ(plant.body().position_m.norm(), 0);
  EXPECT_NEAR(plant.body().force_B_m_s2.x(), kGravity_m_s2, 1e-9);
}

TEST(TalarisPlant, BeamsMeetGroundAndWallAlongTheirWay) {
  const Vector3 at(-0.05, 0, 0), down(-1, 0, 0), ahead(0, 0, 1);
  Plant stands({});
  EXPECT_NEAR(*stands.distance_m(at, down, 0.9), 0.25 - 0.05 - 45 * kGravity_m_s2 / 160e3, 1e-9);
  Plant tilted({.tilt_rad = 0.3, .height_m = 3});
  const double level_m = 3 + 0.25 - 45 * kGravity_m_s2 / 160e3 - 0.05 * std::cos(0.3);
  EXPECT_NEAR(*tilted.distance_m(at, down, 0.9), level_m / std::cos(0.3), 1e-9);
  EXPECT_FALSE(tilted.distance_m(at, down, 0.29));
  Plant sled({.stand = Stand::sled, .heading_rad = 0.7, .wall_m = 4});
  EXPECT_NEAR(*sled.distance_m(at, ahead, 0.9), 4 / std::cos(0.7), 1e-9);
}

}  // namespace
}  // namespace lss::sim::talaris
