// The kinematic plant against rigid bodies: the same modules, the same bytes, the same script.

#include <gtest/gtest.h>

#include <stdexcept>

#include "tests/support/everything.h"
#include "tests/zebro/sim/robot_driver.h"

namespace lss::sim::zebro {
namespace {

constexpr double kStanding_m = 0.053;

struct Walk {
  std::size_t number;
  const char* name;
  const Groups* groups;
  int cycles, left, right;
};
constexpr Walk kWalks[] = {
    {0, "Tripod", &kTripod, 2, +1, +1},     {1, "TripodBackward", &kTripod, 2, -1, -1},
    {2, "Tetrapod", &kTetrapod, 1, +1, +1}, {3, "TetrapodBackward", &kTetrapod, 1, -1, -1},
    {4, "Wave", &kWave, 1, +1, +1},         {5, "WaveBackward", &kWave, 1, -1, -1},
};

// Whole cycles after the first one.
struct Walked {
  double speed_m_s, yaw_deg, standing_m, aligned_m;
};
Walked walked(const Walk& walk, PlantKind plant, long step_ms) {
  RobotDriver driver({.seed = 4}, plant, step_ms);
  driver.stand_up();
  const double standing_m = driver.body().position_m.z();
  driver.walk(*walk.groups, 1, walk.left, walk.right);
  const BodyState from = driver.body();
  const double began_s = driver.now_s();
  driver.walk(*walk.groups, walk.cycles, walk.left, walk.right);
  const Pose pose = driver.moved(from);
  const double took_s = driver.now_s() - began_s;
  driver.align();
  return {pose.ahead_m / took_s, pose.yaw_deg, standing_m, driver.body().position_m.z()};
}

class Plants : public testing::TestWithParam<Walk> {};

TEST_P(Plants, WalkAtTheSameSpeedAndStandAsHigh) {
  LSS_SKIP_OUTSIDE_SAMPLE(GetParam().number, 3);
  const Walked rigid = walked(GetParam(), PlantKind::dart, 1);
  for (const long step_ms : {1L, 20L}) {
    const Walked kinematic = walked(GetParam(), PlantKind::kinematic, step_ms);
    RecordProperty("rigid_mm_s", std::to_string(rigid.speed_m_s * 1e3));
    RecordProperty("kinematic_mm_s_" + std::to_string(step_ms),
                   std::to_string(kinematic.speed_m_s * 1e3));
    EXPECT_NEAR(kinematic.speed_m_s, rigid.speed_m_s, 0.05 * std::abs(rigid.speed_m_s)) << step_ms;
    EXPECT_NEAR(kinematic.standing_m, rigid.standing_m, 0.002);
    EXPECT_NEAR(kinematic.aligned_m, rigid.aligned_m, 0.002);
  }
}
INSTANTIATE_TEST_SUITE_P(Zebro, Plants, testing::ValuesIn(kWalks),
                         [](const auto& walk) { return walk.param.name; });

TEST(KinematicPlant, TurnsTheSameWayAsRigidBodies) {
  for (const int left : {+1, -1}) {
    const Walk turn{0, "", &kTripod, 1, left, -left};
    const double rigid_deg = walked(turn, PlantKind::dart, 1).yaw_deg;
    const double kinematic_deg = walked(turn, PlantKind::kinematic, 20).yaw_deg;
    EXPECT_GT(std::abs(rigid_deg), 20);
    EXPECT_NEAR(kinematic_deg / rigid_deg, 1, 0.25);
  }
}

TEST(KinematicPlant, LiesOnItsBellyAndComesDownToIt) {
  for (const PlantKind plant : {PlantKind::dart, PlantKind::kinematic}) {
    RobotDriver driver({.seed = 4}, plant);
    EXPECT_NEAR(driver.body().position_m.z(), kHipHeightLying_m, 0.002);
    driver.stand_up();
    EXPECT_NEAR(driver.body().position_m.z(), kStanding_m, 0.002);
    driver.lay_down();
    EXPECT_NEAR(driver.body().position_m.z(), kHipHeightLying_m, 0.002);
  }
}

TEST(KinematicPlant, ClimbsASlopeOnEarth) {
  RobotDriver driver({.gravity_m_s2 = 9.81, .slope_rad = 0.1745}, PlantKind::kinematic, 20);
  driver.stand_up();
  const BodyState from = driver.body();
  driver.walk(kTripod, 2, +1, +1);
  EXPECT_NEAR(driver.moved(from).ahead_m, 0.13, 0.02);
  EXPECT_NEAR(driver.body().position_m.z() - from.position_m.z(), 0.13 * std::sin(0.1745), 0.006);
}

// A leg's load reaches its motor: more on Earth than on the Moon.
TEST(KinematicPlant, HeavierIsHarderForTheMotors) {
  const auto strongest_Nm = [](double gravity_m_s2) {
    RobotDriver driver({.gravity_m_s2 = gravity_m_s2}, PlantKind::kinematic);
    driver.stand_up();
    driver.walk(kTripod, 1, +1, +1);
    double most_Nm = 0;
    for (int i = 0; i < 3000; ++i) {
      driver.run(0.001);
      for (const ShaftState& shaft : driver.zebro().robot().shafts())
        most_Nm = std::max(most_Nm, std::abs(shaft.torque_Nm));
    }
    return most_Nm;
  };
  const double moon_Nm = strongest_Nm(1.625), earth_Nm = strongest_Nm(9.81);
  EXPECT_GT(moon_Nm, 0.001);
  EXPECT_NEAR(earth_Nm / moon_Nm, 9.81 / 1.625, 0.6);
}

// A leg that cannot turn is dragged, and the robot veers to its side.
TEST(KinematicPlant, DragsALegWhoseModuleIsDead) {
  RobotDriver driver({.seed = 4}, PlantKind::kinematic, 20);
  driver.stand_up();
  const auto kind = make_zebro_kind();
  driver.zebro().set_fault(parse_fault("module-dead:3", kind->fault_kinds()).value(), true);
  const double before_rad = driver.zebro().robot().shafts()[2].angle_rad;
  const BodyState from = driver.body();
  driver.walk(kTripod, 1, +1, +1);
  EXPECT_NEAR(driver.zebro().robot().shafts()[2].angle_rad, before_rad, 1e-9);
  EXPECT_LT(driver.moved(from).ahead_m, 0.06);  // of 0.069
}

TEST(KinematicPlant, SaysWhatItDoesNotHave) {
  EXPECT_THROW(Zebro({.terrain = {.rocks = true}, .plant = PlantKind::kinematic}),
               std::invalid_argument);
  EXPECT_THROW(Zebro({.terrain = {}, .plant = PlantKind::dart, .step_ns = 20 * kMillisecond}),
               std::invalid_argument);
}

// After time without steps all reported values are correct.
TEST(KinematicPlant, RestsWithoutSteps) {
  RobotDriver driver({.seed = 4}, PlantKind::kinematic, 20);
  driver.stand_up();
  driver.walk(kTripod, 3, +1, +1);
  for (int leg = 1; leg <= kLegs; ++leg) driver.command(leg, 0x02);
  const auto temperature = [&] {
    const auto health = driver.command(1, 0x05, {1});
    return (health[0] << 8 | health[1]) * 0.01;
  };
  const double warm_degC = temperature();
  const double height_m = driver.body().position_m.z();
  driver.zebro().rest(7200);
  EXPECT_GT(warm_degC, 22.2);
  EXPECT_NEAR(temperature(), 22.1, 0.05);
  EXPECT_EQ(driver.body().position_m.z(), height_m);
  const auto identity = driver.command(1, 0x05, {2});
  const long uptime_ms = identity[4] << 24 | identity[5] << 16 | identity[6] << 8 | identity[7];
  EXPECT_NEAR(static_cast<double>(uptime_ms) * 1e-3, 7200 + driver.now_s(), 0.1);
}

}  // namespace
}  // namespace lss::sim::zebro
