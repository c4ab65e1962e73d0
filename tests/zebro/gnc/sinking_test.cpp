// How deep legs come into the soil, from currents that are made up.

#include "gnc/zebro/sinking.h"

#include <gtest/gtest.h>

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
      EXPECT_NEAR(sinking.share(), share, 1e-9);
    }
  }
}

TEST(Sinking, IsThatOfTheLegThatIsLeastDeep) {
  Sinking sinking(kBelly_rad);
  stride(sinking, [](std::size_t leg, double theta_deg) {
    return soil(leg == 3 ? 0.04 : 0.4)(leg, theta_deg);
  });
  EXPECT_NEAR(sinking.share(), 0.04, 1e-9);
}

TEST(Sinking, OnHardGroundThereIsNoneWhateverLegsWeigh) {
  for (const double weight_A : {0.0, 0.012, -0.012}) {
    Sinking sinking(kBelly_rad);
    ASSERT_TRUE(stride(sinking, [=](std::size_t, double theta_deg) {
      return 0.05 + weight_A * std::abs(std::sin(theta_deg * kDegree));
    }));
    EXPECT_EQ(sinking.share(), 0);
  }
}

TEST(Sinking, WhatIsLessThanModulesCanMeasureIsNoSoil) {
  Sinking sinking(kBelly_rad);
  ASSERT_TRUE(stride(sinking, [](std::size_t, double theta_deg) {
    return theta_deg > 0 && theta_deg < 95 ? 0.054 : 0.05;
  }));
  EXPECT_EQ(sinking.share(), 0);
}

TEST(Sinking, NeedsANewFlightOfEachLegWithAKnownAngle) {
  Sinking sinking(kBelly_rad);
  PerLeg<Sinking::Leg> legs{};
  EXPECT_FALSE(sinking.update(legs));
  ASSERT_TRUE(stride(sinking, soil(0.3)));
  for (int frame = 0; frame < 100; ++frame) EXPECT_FALSE(sinking.update(legs));
  for (double theta_deg = -20; theta_deg > -340; theta_deg -= 2) {
    for (std::size_t i = 0; i < kLegs; ++i)
      legs[i] = {.theta_rad = theta_deg * kDegree, .current_A = 1, .known = i != 2, .flies = true};
    EXPECT_FALSE(sinking.update(legs));
  }
  EXPECT_FALSE(sinking.update({}));
  EXPECT_NEAR(sinking.share(), 0.3, 1e-9);
}

// Noise of 20 mA in each status, 40 % of what a leg draws in the air.
TEST(Sinking, NoiseOnHardGroundIsNoSoilTwiceInARow) {
  std::mt19937 random(1);
  std::normal_distribution<double> noise_A(0.05, 0.02);
  Sinking sinking(kBelly_rad);
  int strides = 0;
  for (int i = 0; i < 5000; ++i) {
    ASSERT_TRUE(stride(sinking, [&](std::size_t, double) { return noise_A(random); }));
    strides += sinking.share() > 0.16 ? 1 : 0;
  }
  EXPECT_LE(strides, 1);
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
