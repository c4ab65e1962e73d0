// How deep legs come into the soil, from currents that are made up.

#include "gnc/zebro/sinking.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <functional>
#include <limits>
#include <random>

#include "idl/angles.h"
#include "tests/support/allocations.h"

namespace lss::gnc::zebro::test {
namespace {

constexpr double kFlies_deg_s = 107, kFrame_s = 0.02;
const double kBelly_rad = lowered_rad(0.025, 0.053);  // 93 deg

// Current of a leg at an angle.
using Currents = std::function<double(std::size_t leg, double theta_deg)>;

// In the air 50 mA; the same more in the soil, where the hip is low, and a share of it where it is
// high.
Currents soil(double share) {
  return [=](std::size_t, double theta_deg) {
    if (theta_deg > 0 && theta_deg < 65) return 0.1;
    return theta_deg > 0 && theta_deg < 95 ? 0.05 + 0.05 * share : 0.05;
  };
}

double smallest(const Sinking& sinking) { return std::ranges::min(sinking.shares()); }

// All legs fly once, ahead (theta falls) or back; true: a new share.
bool stride(Sinking& sinking, const Currents& current_A, bool ahead = true) {
  bool is_new = false;
  PerLeg<Sinking::Leg> legs{};
  for (double way_deg = 0; way_deg <= 320; way_deg += kFlies_deg_s * kFrame_s) {
    const double theta_deg = ahead ? -20 - way_deg : 20 + way_deg;
    const double wrapped_deg = std::remainder(theta_deg, 360);
    for (std::size_t i = 0; i < kLegs; ++i) {
      legs[i] = {.theta_rad = theta_deg * kDegree,
                 .current_A = current_A(i, wrapped_deg),
                 .known = true,
                 .flies = true};
    }
    is_new |= sinking.update(legs);
  }
  for (Sinking::Leg& leg : legs) leg.flies = false;
  return sinking.update(legs) || is_new;
}

TEST(Sinking, IsTheShareOfTheCurrentThatIsDrawnWhereTheBellyWouldTouch) {
  for (const double share : {0.0, 0.1, 0.3}) {
    for (const bool ahead : {true, false}) {
      Sinking sinking(kBelly_rad);
      ASSERT_TRUE(stride(sinking, soil(share), ahead));
      EXPECT_NEAR(smallest(sinking), share, 1e-9);
    }
  }
}

TEST(Sinking, IsThatOfTheLegOfASideThatIsLeastDeep) {
  Sinking sinking(kBelly_rad);
  stride(sinking, [](std::size_t leg, double theta_deg) {
    return soil(leg == 3 ? 0.04 : leg == 4 ? 0.3 : 0.4)(leg, theta_deg);  // RM, LH
  });
  EXPECT_NEAR(sinking.shares()[0], 0.3, 1e-9);
  EXPECT_NEAR(sinking.shares()[1], 0.04, 1e-9);
}

TEST(Sinking, OnHardGroundThereIsNoneWithAnyWeightOfTheLegs) {
  for (const double weight_A : {0.0, 0.012, -0.012}) {
    Sinking sinking(kBelly_rad);
    ASSERT_TRUE(stride(sinking, [=](std::size_t, double theta_deg) {
      return 0.05 + weight_A * std::abs(std::sin(theta_deg * kDegree));
    }));
    EXPECT_EQ(smallest(sinking), 0);
  }
}

TEST(Sinking, WhatIsLessThanModulesCanMeasureIsNoSoil) {
  Sinking sinking(kBelly_rad);
  ASSERT_TRUE(stride(sinking, [](std::size_t, double theta_deg) {
    return theta_deg > 0 && theta_deg < 95 ? 0.054 : 0.05;
  }));
  EXPECT_EQ(smallest(sinking), 0);
}

TEST(Sinking, NeedsANewFlightOfEachLegWithAKnownAngle) {
  Sinking sinking(kBelly_rad);
  PerLeg<Sinking::Leg> legs{};
  EXPECT_FALSE(sinking.update(legs));
  EXPECT_LT(smallest(sinking), 0);
  ASSERT_TRUE(stride(sinking, soil(0.3)));
  for (int frame = 0; frame < 100; ++frame) EXPECT_FALSE(sinking.update(legs));
  for (double theta_deg = -20; theta_deg > -340; theta_deg -= 2) {
    for (std::size_t i = 0; i < kLegs; ++i)
      legs[i] = {.theta_rad = theta_deg * kDegree, .current_A = 1, .known = i != 2, .flies = true};
    EXPECT_FALSE(sinking.update(legs));
  }
  EXPECT_FALSE(sinking.update({}));
  EXPECT_NEAR(smallest(sinking), 0.3, 1e-9);
}

// Noise of 20 mA in each status, 40 % of what a leg draws in the air: strides in a row with more
// than the limit of config/zebro.toml, on the left, on the right, on both.
TEST(Sinking, NoiseOnHardGroundIsNoSoilInTwoStridesOrOfASideInThree) {
  std::mt19937 random(1);
  std::normal_distribution<double> noise_A(0.05, 0.02);
  Sinking sinking(kBelly_rad);
  std::array<int, 3> in_a_row{};
  for (int i = 0; i < 5000; ++i) {
    ASSERT_TRUE(stride(sinking, [&](std::size_t, double) { return noise_A(random); }));
    const auto [left, right] = sinking.shares();
    const std::array<double, 3> shares = {left, right, smallest(sinking)};
    for (std::size_t k = 0; k < shares.size(); ++k)
      in_a_row[k] = shares[k] > 0.16 ? in_a_row[k] + 1 : 0;
    EXPECT_LT(in_a_row[0], 3);
    EXPECT_LT(in_a_row[1], 3);
    EXPECT_LT(in_a_row[2], 2);
  }
}

TEST(Sinking, NothingAllocates) {
  Sinking sinking(kBelly_rad);
  const Currents currents = soil(0.3);
  const std::uint64_t before = testing_support::allocations();
  stride(sinking, currents);
  EXPECT_EQ(testing_support::allocations(), before);
}

}  // namespace
}  // namespace lss::gnc::zebro::test
