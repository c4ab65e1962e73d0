// Missions of a few metres with many faults: the conditions of every frame are satisfied, and the
// robot arrives.

#include "tests/zebro/mission/mission.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/zebro/chain/chain.h"
#include "tools/lss-sim/zebro/vehicle.h"

namespace lss::zebro::mission {
namespace {

// With faults every so many hours, at full speed and with short rests.
Options short_mission(unsigned seed, double fault_mean_h, double course_m) {
  Options options;
  options.seed = seed;
  options.fault_mean_h = fault_mean_h;
  options.flight_s = 3;
  options.autopilot.course_m = course_m;
  options.autopilot.speed = gnc::zebro::Speed::high;
  options.autopilot.rest_below = 0.95;
  options.autopilot.rest_until = 0.97;
  return options;
}

class Missions : public testing::TestWithParam<unsigned> {};

TEST_P(Missions, ArriveWithAnyFaultsAndNeverMoveWhenTheyMustNot) {
  const Result result = run(short_mission(GetParam(), 0.03, 10));
  EXPECT_THAT(result.violations, testing::IsEmpty());
  EXPECT_TRUE(result.arrived);
  EXPECT_NEAR(result.true_m, 10, 1);
  EXPECT_GE(result.count.rests, 1);
  EXPECT_GE(result.emergencies, 2);
  EXPECT_GE(result.count.recoveries, 2);
  RecordProperty("times_real_time",
                 static_cast<int>((result.elapsed_h - result.rested_h) * 3600 / result.wall_s));
}
INSTANTIATE_TEST_SUITE_P(Zebro, Missions, testing::Values(1u, 2u));

// Leg 2 is dead for good and the robot wakes with its panel out: error solving resets all modules,
// and the panel's counts from where it is.
TEST(Mission, NeverOperatesWithThePanelOutWhoeverResetItsModule_Func_5) {
  Options options = short_mission(74, 0.05, 15);
  options.lying_faults = false;
  const Result result = run(options);
  EXPECT_THAT(result.violations, testing::IsEmpty());
  EXPECT_TRUE(result.arrived);
  EXPECT_GE(result.count.rests, 1);
  EXPECT_GE(result.isolations, 2) << "after it woke as well";
}

// Two legs side by side jam for good: one is isolated, the other stops it at the next start, and a
// reset of everything forgets the first. With an autopilot that never tires it is the daemon that
// refuses to go on.
TEST(Mission, AFaultThatComesBackAtEveryStartIsSoonForAPerson) {
  for (const int reset_tries : {3, 1000}) {
    SCOPED_TRACE(reset_tries);
    Options options;
    options.seed = 69;
    options.fault_mean_h = 0.03;
    options.lying_faults = false;
    options.flight_s = 3;
    options.autopilot.course_m = 15;
    options.autopilot.speed = gnc::zebro::Speed::high;
    options.autopilot.reset_tries = reset_tries;
    const Result result = run(options);
    EXPECT_TRUE(result.arrived);
    EXPECT_GE(result.count.interventions, 1);
    EXPECT_LT(result.emergencies, 40);
    EXPECT_LT(result.count.resets, 10);
  }
}

TEST(Mission, TheSameSeedGivesTheSameMission) {
  Options options;
  options.seed = 5;
  options.fault_mean_h = 0.05;
  options.autopilot.course_m = 1;
  const Result a = run(options), b = run(options);
  EXPECT_EQ(a.true_m, b.true_m);
  EXPECT_EQ(a.aside_m, b.aside_m);
  EXPECT_EQ(a.elapsed_h, b.elapsed_h);
  EXPECT_EQ(a.emergencies, b.emergencies);
}

// The fast line of missions against the one that keeps the time of each byte.
TEST(Mission, FramesAsAWholeAreAsGoodAsBytesAtTheirInstants) {
  struct Walked {
    double ahead_m;
    std::uint64_t received, dropped, noisy;
  };
  const auto walk = [](bool whole_frames) {
    Chain chain({.seed = 3,
                 .vehicle =
                     [](const sim::zebro::TerrainOptions& terrain) {
                       return std::make_unique<sim::zebro::Zebro>(sim::zebro::ZebroOptions{
                           .terrain = terrain, .plant = sim::zebro::PlantKind::kinematic});
                     },
                 .whole_frames = whole_frames});
    EXPECT_TRUE(chain.stand());
    EXPECT_TRUE(chain.walk());
    const double from_m = chain.body().position_m.x();
    chain.run(30);
    Walked walked{.ahead_m = chain.body().position_m.x() - from_m,
                  .received = chain.bus().frames_received,
                  .dropped = chain.bus().frames_dropped,
                  .noisy = 0};
    chain.inject("noise:0.001");
    chain.run(20);
    walked.noisy = chain.bus().frames_dropped;
    return walked;
  };
  const Walked bytes = walk(false), frames = walk(true);
  EXPECT_GT(bytes.ahead_m, 0.2);
  EXPECT_NEAR(frames.ahead_m, bytes.ahead_m, 0.002);
  EXPECT_EQ(bytes.dropped, 0u);
  EXPECT_EQ(frames.dropped, 0u);
  const auto received = static_cast<double>(bytes.received);
  EXPECT_NEAR(static_cast<double>(frames.received), received, 0.01 * received);
  // Some 8000 replies of 24 characters, one character of a thousand broken.
  const auto noisy = static_cast<double>(bytes.noisy);
  EXPECT_GT(noisy, 100);
  EXPECT_NEAR(static_cast<double>(frames.noisy), noisy, 0.3 * noisy);
}

}  // namespace
}  // namespace lss::zebro::mission
