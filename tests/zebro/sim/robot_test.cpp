// The robot really stands up and walks: bytes in, rigid-body physics out.

#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/everything.h"
#include "tests/zebro/sim/robot_driver.h"

namespace lss::sim::zebro {
namespace {

constexpr double kStanding_m = 0.053;  // the hip's height is a leg's diameter

class FromSeed : public testing::TestWithParam<unsigned> {};

// [Miss-1]
TEST_P(FromSeed, StandsUpFromUnknownLegAnglesAndStaysUp) {
  RobotDriver driver({.seed = GetParam()});
  driver.stand_up();
  EXPECT_NEAR(driver.body().position_m.z(), kStanding_m, 0.002);
  driver.run(1);
  const Pose pose = driver.moved(driver.body());
  EXPECT_NEAR(pose.height_m, kStanding_m, 0.002);
  EXPECT_LT(pose.tilt_deg, 1);
}
INSTANTIATE_TEST_SUITE_P(Robot, FromSeed, testing::Values(1u, 2u, 3u));

TEST(Robot, LiesStillOnItsBellyWhenNobodyCommands) {
  RobotDriver driver({.seed = 5});
  const BodyState start = driver.body();
  driver.run(2);
  EXPECT_LT((driver.body().position_m - start.position_m).norm(), 0.001);
}

// Speeds of the gait table: stride over stance, 10.1, 5.3 and 2.2 mm/s; over whole cycles.
struct Walk {
  std::size_t number;
  const char* name;
  Groups groups;
  int cycles, sense;
  double speed_m_s;
};

class Walks : public testing::TestWithParam<Walk> {};

TEST_P(Walks, StraightAtTheSpeedOfTheGaitTable) {
  const Walk& walk = GetParam();
  LSS_SKIP_OUTSIDE_SAMPLE(walk.number, 2);
  RobotDriver driver({.seed = 4});
  driver.stand_up();
  driver.walk(walk.groups, 1, walk.sense, walk.sense);
  const BodyState from = driver.body();
  const double began_s = driver.now_s();
  driver.walk(walk.groups, walk.cycles, walk.sense, walk.sense);
  const Pose pose = driver.moved(from);
  const double speed_m_s = pose.ahead_m / (driver.now_s() - began_s);
  RecordProperty("speed_mm_s", std::to_string(speed_m_s * 1e3));
  EXPECT_NEAR(speed_m_s, walk.sense * walk.speed_m_s, 0.25 * walk.speed_m_s);
  EXPECT_LT(std::abs(pose.left_m), 0.2 * std::abs(pose.ahead_m));
  driver.align();
  EXPECT_LT(driver.moved(from).tilt_deg, 1);
  EXPECT_NEAR(driver.moved(from).height_m, kStanding_m, 0.002);
}
INSTANTIATE_TEST_SUITE_P(Robot, Walks,
                         testing::Values(Walk{0, "Tripod", kTripod, 3, +1, 0.0101},
                                         Walk{1, "TripodBackward", kTripod, 3, -1, 0.0101},
                                         Walk{2, "Tetrapod", kTetrapod, 2, +1, 0.0053},
                                         Walk{3, "Wave", kWave, 1, +1, 0.0022}),
                         [](const auto& walk) { return walk.param.name; });

TEST(Robot, TurnsOnTheSpotTheWayThatItsSidesPush) {
  RobotDriver driver({.seed = 4});
  driver.stand_up();
  const BodyState from = driver.body();
  driver.walk(kTripod, 2, +1, -1);
  const Pose clockwise = driver.moved(from);
  EXPECT_LT(clockwise.yaw_deg, -20);
  EXPECT_LT(std::hypot(clockwise.ahead_m, clockwise.left_m), 0.03);
  const BodyState turned = driver.body();
  driver.walk(kTripod, 2, -1, +1);
  EXPECT_GT(driver.moved(turned).yaw_deg, 20);
}

TEST(Robot, ClimbsASlopeOfTenDegreesEvenOnEarth) {
  RobotDriver driver({.gravity_m_s2 = 9.81, .slope_rad = 0.1745});
  driver.stand_up();
  const BodyState from = driver.body();
  driver.walk(kTripod, 2, +1, +1);
  const BodyState above = driver.body();
  EXPECT_NEAR(driver.moved(from).ahead_m, 0.13, 0.04);
  EXPECT_NEAR(above.position_m.z() - from.position_m.z(), 0.13 * std::sin(0.1745), 0.012);
}

TEST(Robot, DragsALegWhoseModuleIsDead) {
  RobotDriver driver({.seed = 4});
  driver.stand_up();
  const auto kind = make_zebro_kind();
  driver.zebro().set_fault(parse_fault("module-dead:3", kind->fault_kinds()).value(), true);
  const double before_rad = driver.zebro().robot().shafts()[2].angle_rad;
  driver.walk(kTripod, 1, +1, +1);
  EXPECT_NEAR(driver.zebro().robot().shafts()[2].angle_rad, before_rad, 0.02);
  EXPECT_GT(driver.zebro().robot().shafts()[3].angle_rad, before_rad + 5);
}

}  // namespace
}  // namespace lss::sim::zebro
