// Lunar Zebro walks on soil that gives way: the same modules, bytes and script as on hard ground.

#include <gtest/gtest.h>

#include <bit>
#include <stdexcept>

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

TEST(SoilWalk, HasTheSameBitsInEachRun) {
  const auto bits = [] {
    RobotDriver driver(on("sand"));
    driver.stand_up();
    const BodyState body = driver.body();
    return std::array{std::bit_cast<std::uint64_t>(body.position_m.x()),
                      std::bit_cast<std::uint64_t>(body.position_m.z()),
                      std::bit_cast<std::uint64_t>(body.attitude.w())};
  };
  EXPECT_EQ(bits(), bits());
}

TEST(SoilWalk, IsNotForPlantsWithoutSoil) {
  EXPECT_THROW(RobotDriver(on("sand"), PlantKind::kinematic), std::invalid_argument);
  TerrainOptions rocks = on("sand");
  rocks.rocks = true;
  EXPECT_THROW(RobotDriver{rocks}, std::invalid_argument);
}

}  // namespace
}  // namespace lss::sim::zebro
