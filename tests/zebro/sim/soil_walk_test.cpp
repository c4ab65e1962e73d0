// Lunar Zebro walks on soil that gives way: the same modules, bytes and script as on hard ground.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstdio>
#include <stdexcept>

#include "tests/support/cpu_time.h"
#include "tests/zebro/sim/robot_driver.h"

namespace lss::sim::zebro {
namespace {

TerrainOptions on(const std::string& name, double gravity_m_s2 = soil::kMoon_m_s2) {
  return {.gravity_m_s2 = gravity_m_s2, .soil = soil::parse_soil(name), .seed = 4};
}

// Of whole cycles after the first one.
double speed_m_s(RobotDriver& driver, const Groups& groups, int cycles) {
  driver.walk(groups, 1, +1, +1);
  const BodyState from = driver.body();
  const double began_s = driver.now_s();
  driver.walk(groups, cycles, +1, +1);
  return driver.moved(from).ahead_m / (driver.now_s() - began_s);
}

// The slowest gait, in dry sand and in sand with a quarter of its strength, about as soft as the
// softest medium of Li, Zhang and Goldman.
TEST(SoilWalk, WaveInSandOnTheEarthIsFasterThanAMillimetrePerSecond_Oper_8_Ver_1) {
  double last_m_s = 1;
  for (const char* name : {"sand", "sand:0.25"}) {
    RobotDriver driver(on(name, soil::kEarth_m_s2));
    driver.stand_up();
    const double walking_m_s = speed_m_s(driver, kWave, 1);
    EXPECT_GT(walking_m_s, 0.001) << name;
    EXPECT_LT(walking_m_s, last_m_s) << name;
    last_m_s = walking_m_s;
  }
}

// [Ver-1]
TEST(SoilWalk, SinksDeeperInWeakerSoilAndStillWalks) {
  double last_m = 0.053;
  for (const char* name : {"regolith", "regolith:0.25"}) {
    RobotDriver driver(on(name));
    driver.stand_up();
    const double standing_m = driver.body().position_m.z();
    EXPECT_LT(standing_m, last_m - 0.003) << name;
    EXPECT_NEAR(speed_m_s(driver, kTripod, 1), 0.012, 0.002) << name;
    last_m = standing_m;
  }
}

// [Ver-3]
TEST(SoilWalk, StandsStillAndSaysHowDeep) {
  RobotDriver driver(on("regolith"));
  driver.stand_up();
  const BodyState from = driver.body();
  driver.run(10);
  EXPECT_NEAR(driver.body().position_m.z(), from.position_m.z(), 1e-4);
  EXPECT_NEAR(driver.moved(from).ahead_m, 0, 1e-4);
  const auto truth = driver.zebro().truth();
  for (std::size_t leg = 0; leg < kLegs; ++leg) {
    EXPECT_NEAR(truth["leg_sinkage_m"][leg].get<double>(), 0.053 - from.position_m.z(), 0.001);
    EXPECT_NEAR(truth["leg_slip_m_s"][leg].get<double>(), 0, 1e-4);
  }
}

TEST(SoilWalk, HoldsOnASlopeThatTheSoilHolds) {
  TerrainOptions terrain = on("regolith");
  terrain.slope_rad = 10 * kDegree;
  RobotDriver driver(terrain);
  driver.stand_up();
  const BodyState from = driver.body();
  driver.run(5);
  EXPECT_NEAR(driver.moved(from).ahead_m, 0, 5e-4);
}

TerrainOptions with_patch(const std::string& patch) {
  TerrainOptions terrain = on("regolith");
  terrain.patches.push_back(parse_patch(patch));
  return terrain;
}

TEST(SoilWalk, ALegSinksInAPatchAloneAndComesOutBehindIt) {
  RobotDriver driver(with_patch("sand:0.1@3@0.2..0.3"));
  driver.stand_up();
  // The deepest that each leg comes, by where its hip is then.
  std::array<double, kLegs> before_m{}, inside_m{}, behind_m{};
  driver.after_step = [&] {
    const Plant& robot = driver.zebro().robot();
    for (std::size_t i = 0; i < kLegs; ++i) {
      const double hip_m = robot.body().position_m.x() + kHipX_m[i];
      double& deepest_m = (hip_m < 0.17 ? before_m : hip_m < 0.33 ? inside_m : behind_m)[i];
      deepest_m = std::max(deepest_m, robot.legs_in_soil()[i].sinkage_m);
    }
  };
  driver.walk(kTripod, 5, +1, +1);
  for (std::size_t i = 0; i < kLegs; ++i) {
    EXPECT_LT(before_m[i], 0.02) << i;
    EXPECT_EQ(inside_m[i] > 0.02, i == 2) << i << " " << inside_m[i];
    EXPECT_LT(behind_m[i], 0.02) << i;
  }
  EXPECT_GT(behind_m[2], 0.005);
}

// All six legs: the underside lies in it, too.
TEST(SoilWalk, SinksWhollyInAPatchUnderAllLegs) {
  RobotDriver patch(with_patch("sand:0.25@123456")), soft(on("sand:0.25"));
  for (RobotDriver* driver : {&patch, &soft}) driver->stand_up();
  EXPECT_NEAR(patch.body().position_m.z(), soft.body().position_m.z(), 1e-6);
  RobotDriver side(with_patch("sand:0.1@135"));
  side.stand_up();
  EXPECT_GT(side.moved({}).tilt_deg, 5);
}

TEST(SoilWalk, HasTheSameBitsInEachRun) {
  const auto bits = [] {
    TerrainOptions terrain = on("sand");
    terrain.patches.push_back(parse_patch("sand:0.1@1"));
    RobotDriver driver(terrain);
    driver.stand_up();
    const BodyState body = driver.body();
    return std::array{std::bit_cast<std::uint64_t>(body.position_m.x()),
                      std::bit_cast<std::uint64_t>(body.position_m.z()),
                      std::bit_cast<std::uint64_t>(body.attitude.w())};
  };
  EXPECT_EQ(bits(), bits());
}

TEST(SoilWalk, CostsAtMostThreeTimesHardGround) {
  const auto cost_s = [](const TerrainOptions& terrain) {
    RobotDriver driver(terrain);
    driver.stand_up();
    return testing_support::cpu_s_of([&] { driver.walk(kTripod, 1, +1, +1); }) / 6.6;
  };
  const double hard_s = cost_s({.seed = 4}), soil_s = cost_s(on("regolith"));
  std::printf("a simulated second: %.0f ms on hard ground, %.0f ms on regolith\n", hard_s * 1e3,
              soil_s * 1e3);
#ifndef LSS_SANITIZED
  EXPECT_LT(soil_s, 3 * hard_s);
#endif
}

TEST(SoilWalk, IsNotForPlantsWithoutSoil) {
  EXPECT_THROW(RobotDriver(on("sand"), PlantKind::kinematic), std::invalid_argument);
  TerrainOptions rocks = on("sand");
  rocks.rocks = true;
  EXPECT_THROW(RobotDriver{rocks}, std::invalid_argument);
  TerrainOptions hard;
  hard.patches.push_back(parse_patch("sand@1"));
  EXPECT_THROW(RobotDriver{hard}, std::invalid_argument);
}

}  // namespace
}  // namespace lss::sim::zebro
