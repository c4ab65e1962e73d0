// Speeds of walking and turning in rigid-body physics, by the true way over whole gait cycles. The
// bounds come from 30 seeds (legs at boot, noise, phases of the clocks) of this chain; tests/e2e
// has the same ones for the program. Which seeds run: tests/support/everything.h.

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

#include "idl/angles.h"
#include "tests/support/everything.h"
#include "tests/zebro/chain/chain.h"

namespace lss::zebro {
namespace {

using gnc::zebro::Speed;

constexpr unsigned kGaitSeeds = 30;
constexpr unsigned kOneIn = 15;

struct Bounds {
  double least, most;
  bool contain(double value) const { return value >= least && value <= most; }
};

struct Gait {
  const char* name;
  bool forward;
  double heading_rad;
  Speed speed;
  double cycle_s;  // docs/gait-zebro.md
  double cycles;
  double before_s;  // from the begin of walking
  Bounds speed_mm_s, turn_deg_s, aside_mm;
};

class GaitSpeed : public testing::TestWithParam<Gait> {};

TEST_P(GaitSpeed, IsWithinTheBoundsOfItsDistribution) {
  const Gait& gait = GetParam();
  for (unsigned seed = 1; seed <= kGaitSeeds; ++seed) {
    if (!testing_support::in_sample(seed, kOneIn)) continue;
    SCOPED_TRACE(seed);
    Chain chain({.seed = seed});
    ASSERT_TRUE(chain.stand());
    ASSERT_TRUE(chain.walk(gait.forward, gait.heading_rad, gait.speed));
    chain.run(gait.before_s);
    const auto from = chain.body();
    const double taken_s = gait.cycles * gait.cycle_s;
    chain.run(taken_s);
    ASSERT_EQ(chain.mode(), Mode::walking);
    const auto to = chain.body();
    const Eigen::Vector3d way_mm =
        1e3 * (from.attitude.conjugate() * (to.position_m - from.position_m));
    const Eigen::Vector3d ahead =
        from.attitude.conjugate() * (to.attitude * Eigen::Vector3d::UnitX());
    const double speed_mm_s = way_mm.x() / taken_s;
    const double turn_deg_s = std::atan2(ahead.y(), ahead.x()) / kDegree / taken_s;
    std::printf("%s seed %u: %.3f mm/s, %.3f deg/s, %.2f mm left\n", gait.name, seed, speed_mm_s,
                turn_deg_s, way_mm.y());
    EXPECT_TRUE(gait.speed_mm_s.contain(speed_mm_s)) << speed_mm_s;
    EXPECT_TRUE(gait.turn_deg_s.contain(turn_deg_s)) << turn_deg_s;
    EXPECT_TRUE(gait.aside_mm.contain(way_mm.y())) << way_mm.y();
  }
}

// Without turning.
constexpr Bounds kStraight{-0.05, 0.05}, kNotAside{-1, 1};
constexpr double kRight_rad = 90 * kDegree;
// Above each the distribution of the 30 seeds: least, median, most of mm/s | deg/s | mm left.
INSTANTIATE_TEST_SUITE_P(
    Zebro, GaitSpeed,
    testing::Values(
        // 2.159 2.167 2.175 | 0.005 0.005 0.006 | 0.52 0.55 0.59
        Gait{"low", true, 0, Speed::low, 19.8, 1, 6.2, {2.12, 2.21}, kStraight, kNotAside},
        // 5.026 5.042 5.065 | -0.016 -0.010 -0.003 | -0.47 -0.38 -0.31
        Gait{"medium", true, 0, Speed::medium, 9.9, 1, 6.1, {4.94, 5.15}, kStraight, kNotAside},
        // 10.356 10.396 10.423 | -0.003 0.001 0.004 | -0.13 0.02 0.08
        Gait{"high", true, 0, Speed::high, 6.6, 2, 6.8, {10.2, 10.6}, kStraight, kNotAside},
        // -10.519 -10.473 -10.394 | -0.008 0.000 0.001 | 0.00 0.00 0.05
        Gait{"back", false, 0, Speed::high, 6.6, 1, 7.4, {-10.7, -10.25}, kStraight, kNotAside},
        // -0.089 0.030 0.130 | -5.903 -5.868 -5.842 | 1.64 1.89 2.10
        Gait{"right", true, kRight_rad, Speed::high, 6.6, 1, 7.4, {-0.5, 0.5}, {-6, -5.75}, {0, 4}},
        // -0.313 -0.292 -0.237 | 6.041 6.085 6.108 | 2.65 2.84 2.92
        Gait{"left",
             true,
             -kRight_rad,
             Speed::high,
             6.6,
             1,
             7.4,
             {-0.7, 0.2},
             {5.95, 6.22},
             {1, 5}}),
    [](const auto& gait) { return gait.param.name; });

// In rigid-body physics the legs are late by their control loops, so the two ways differ a little.
TEST(Neighbours, WalkAsFastAsGroups_Conf_2) {
  double way_m[2];
  for (const auto coordination :
       {gnc::zebro::Coordination::groups, gnc::zebro::Coordination::neighbours}) {
    Chain chain({.adjust = [&](Parameters& p) { p.locomotion.coordination = coordination; }});
    ASSERT_TRUE(chain.stand());
    ASSERT_TRUE(chain.walk());
    chain.run(6.8);
    const auto from = chain.body();
    chain.run(2 * 6.6);
    ASSERT_EQ(chain.mode(), Mode::walking);
    way_m[static_cast<std::size_t>(coordination)] =
        (chain.body().position_m - from.position_m).norm();
  }
  std::printf("groups %.1f mm, neighbours %.1f mm\n", way_m[0] * 1e3, way_m[1] * 1e3);
  EXPECT_NEAR(way_m[1] / way_m[0], 1, 0.02);
}

}  // namespace
}  // namespace lss::zebro
