#include "gnc/zebro/leg.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <cmath>
#include <numbers>

#include "gnc/zebro/gait.h"
#include "gnc/zebro/stability.h"
#include "idl/angles.h"
#include "tests/zebro/gnc/generators.h"

namespace lss::gnc::zebro::test {
namespace {

constexpr double kDiameter_m = 0.053;

rc::Gen<double> angle_rad(double low_deg, double high_deg) {
  return rc::gen::map(rc::gen::inRange(0, 100'001), [low_deg, high_deg](int n) {
    return (low_deg + (high_deg - low_deg) * n / 100'000) * kDegree;
  });
}

TEST(Leg, StridesOfTheTable) {
  EXPECT_NEAR(stride_m(31.6 * kDegree, kDiameter_m), 29.0e-3, 0.05e-3);
  EXPECT_NEAR(stride_m(40 * kDegree, kDiameter_m), 36.4e-3, 0.05e-3);
  EXPECT_NEAR(stride_m(60 * kDegree, kDiameter_m), 53.6e-3, 0.05e-3);
  EXPECT_NEAR(stride_m(90 * kDegree, kDiameter_m), 77.0e-3, 0.05e-3);
}

RC_GTEST_PROP(Leg, SweepForStrideIsTheInverseOfStride, ()) {
  const double sweep_rad = *angle_rad(0, 170);
  RC_ASSERT(std::abs(sweep_for_stride_rad(stride_m(sweep_rad, kDiameter_m), kDiameter_m) -
                     sweep_rad) < 1e-9);
}

RC_GTEST_PROP(Leg, AdvanceGrowsByHipHeightPerRadianOfFall, ()) {
  const double theta_rad = *angle_rad(-60, 120);
  constexpr double kStep_rad = 1e-6;
  const double slope_m = (advance_m(theta_rad + kStep_rad, kDiameter_m) -
                          advance_m(theta_rad - kStep_rad, kDiameter_m)) /
                         (2 * kStep_rad);
  RC_ASSERT(std::abs(slope_m + hip_height_m(theta_rad, kDiameter_m)) < 1e-7);
}

// The leg drawn as points: the lowest of them carries. Nothing of the formulas is used.
RC_GTEST_PROP(Leg, HipHeightAndContactAreThoseOfAHalfCircle, ()) {
  const double theta_rad = *angle_rad(-89, 179);
  const double radius_m = kDiameter_m / 2;
  double lowest_m = 0;
  double ahead_m = 0;
  for (int n = 0; n <= 20'000; ++n) {
    // Along the arc from the hip (0) to the toe (pi), bulging to the rear when the toe is down.
    const double along_rad = kPi * n / 20'000;
    const double x_m = -radius_m * std::sin(along_rad);
    const double z_m = -radius_m + radius_m * std::cos(along_rad);
    const double turned_x_m = x_m * std::cos(theta_rad) - z_m * std::sin(theta_rad);
    const double turned_z_m = x_m * std::sin(theta_rad) + z_m * std::cos(theta_rad);
    if (turned_z_m < lowest_m) {
      lowest_m = turned_z_m;
      ahead_m = turned_x_m;
    }
  }
  RC_ASSERT(std::abs(hip_height_m(theta_rad, kDiameter_m) + lowest_m) < 1e-6);
  RC_ASSERT(std::abs(contact_offset_m(theta_rad, kDiameter_m) - ahead_m) < 1e-5);
}

TEST(Leg, BellyCarriesFromWhereTheArcLetsTheHipDown) {
  const double lowered = lowered_rad(0.025, kDiameter_m);
  EXPECT_NEAR(hip_height_m(lowered, kDiameter_m), 0.025, 1e-12);
  EXPECT_NEAR(lowered / kDegree, 93.2, 0.1);
}

TEST(Leg, WrapsIntoTheHalfOpenTurn) {
  EXPECT_DOUBLE_EQ(wrap_rad(3 * kPi), kPi);
  EXPECT_DOUBLE_EQ(wrap_rad(-kPi), kPi);
  EXPECT_DOUBLE_EQ(wrap_rad(kPi), kPi);
  EXPECT_NEAR(wrap_rad(1e6 * 2 * kPi + 0.5), 0.5, 1e-8);
}

RC_GTEST_PROP(Leg, SwingGoesThroughTheTopAndNeverFurtherThanOnceRound, ()) {
  const double from_rad = *angle_rad(-60, 60), to_rad = *angle_rad(-60, 60);
  const bool forward = *rc::gen::arbitrary<bool>();
  const double travel_rad = travel_through_top_rad(from_rad, to_rad, forward);
  RC_ASSERT(std::abs(wrap_rad(from_rad + travel_rad - to_rad)) < 1e-9);
  RC_ASSERT(std::abs(travel_rad) <= 2 * kPi + 1e-6);
  const double top_rad = std::copysign(kPi, travel_rad);
  RC_ASSERT(std::abs(from_rad + travel_rad) > std::abs(top_rad - 0.0) - 1e-9);
}

TEST(Leg, ForwardSwingFallsAndBackwardSwingRises) {
  EXPECT_NEAR(travel_through_top_rad(-20 * kDegree, 20 * kDegree, true), -320 * kDegree, 1e-12);
  EXPECT_NEAR(travel_through_top_rad(20 * kDegree, -20 * kDegree, false), 320 * kDegree, 1e-12);
  EXPECT_NEAR(travel_through_top_rad(0, 0, true), -2 * kPi, 1e-12);
  EXPECT_NEAR(travel_through_top_rad(0, 0, false), 2 * kPi, 1e-12);
}

struct Heading {
  double direction, heading_deg, left, right;
};

TEST(Turning, SideSpeedsFollowTheHeading) {
  const Heading table[] = {
      {1, 0, 1, 1},   {1, 90, 1, -1},  {1, -90, -1, 1}, {1, 45, 1, 0},
      {1, -45, 0, 1}, {-1, 0, -1, -1}, {-1, 90, -1, 1}, {-1, 45, -1, 0},
  };
  for (const Heading& row : table) {
    const SideSpeeds sides = side_speeds(row.direction, row.heading_deg * kDegree);
    EXPECT_NEAR(sides.left, row.left, 1e-12) << row.heading_deg;
    EXPECT_NEAR(sides.right, row.right, 1e-12) << row.heading_deg;
  }
}

RC_GTEST_PROP(Turning, StrideOfASideIsItsShareOfTheFullStride, ()) {
  const double speed = *rc::gen::map(rc::gen::inRange(50, 1001), [](int n) { return n / 1000.0; });
  const double half_rad = half_sweep_rad(speed, 40 * kDegree, kDiameter_m);
  RC_ASSERT(std::abs(stride_m(2 * half_rad, kDiameter_m) -
                     speed * stride_m(40 * kDegree, kDiameter_m)) < 1e-9);
  RC_ASSERT(half_sweep_rad(-speed, 40 * kDegree, kDiameter_m) == -half_rad);
}

TEST(Turning, SlowSideOnlySteps) {
  EXPECT_EQ(half_sweep_rad(0.049, 40 * kDegree, kDiameter_m), 0);
  EXPECT_EQ(half_sweep_rad(-0.049, 40 * kDegree, kDiameter_m), 0);
}

// Smallest margin over a whole cycle of the gait with sweep 40 deg, angles as the events say.
double smallest_margin_m(const Partition& gait, const GaitTimes& times) {
  const double half_rad = 20 * kDegree;
  const double lambda_s = cycle_time_s(gait, times);
  const double stance_s = lambda_s - times.flight_s;
  const Events v = rhythm(gait, times);
  double smallest_m = 1;
  constexpr int kSamples = 5000;
  for (int n = 0; n < kSamples; ++n) {
    PerLeg<bool> in_stance{};
    PerLeg<double> theta_rad{};
    for (std::size_t i = 0; i < kLegs; ++i) {
      const double since_s =
          std::fmod(lambda_s * n / kSamples - v.touchdown_s[i] + 2 * lambda_s, lambda_s);
      in_stance[i] = since_s < stance_s;
      theta_rad[i] = half_rad * (1 - 2 * since_s / stance_s);
    }
    smallest_m = std::min(smallest_m, static_margin_m(in_stance, theta_rad, kDiameter_m));
  }
  return smallest_m;
}

TEST(Stability, MarginsOfTheGaitTable) {
  const GaitTimes times{1.0, 1.0, 0.1};
  EXPECT_NEAR(smallest_margin_m(kTripod, times), 25e-3, 1e-3);
  EXPECT_NEAR(smallest_margin_m(kTetrapodB, times), 32e-3, 1e-3);
  EXPECT_NEAR(smallest_margin_m(kWave, times), 40e-3, 1e-3);
  const Partition bound{3, {0, 0, 1, 1, 2, 2}};
  EXPECT_NEAR(smallest_margin_m(bound, times), -17e-3, 1e-3);
}

TEST(Stability, EveryShippedGaitStandsSecurelyAtItsDefaultTimes) {
  for (const Partition& gait : {kTripod, kTetrapodB, kWave}) {
    EXPECT_GT(smallest_margin_m(gait, {3.0, 3.3, 0.3}), 0.02);
  }
}

TEST(Stability, FewerThanThreeFeetHaveNoMargin) {
  const PerLeg<double> straight{};
  EXPECT_LT(static_margin_m({true, false, false, false, false, false}, straight, kDiameter_m),
            -1e9);
  EXPECT_LE(static_margin_m({true, true, false, false, false, false}, straight, kDiameter_m), 0);
  EXPECT_LE(static_margin_m({false, false, true, true, false, false}, straight, kDiameter_m), 0);
}

}  // namespace
}  // namespace lss::gnc::zebro::test
