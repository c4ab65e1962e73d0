// Navigation with altimeters at the corners.

#include <gtest/gtest.h>

#include <cmath>

#include "tests/talaris/gnc/navigation_fixture.h"

namespace lss::gnc::talaris::test {
namespace {

NavigationParameters with_corners(double ground_slope_rad = 0) {
  NavigationParameters p;
  p.corners = true;
  p.ground_slope_rad = ground_slope_rad;
  p.range_sigma_m = 0.003;
  p.altimeter_at_B_m = {-0.1, 0.2, -0.15};
  return p;
}

// It stood for 20 s, then flies.
struct Flight : Fixture {
  explicit Flight(const NavigationParameters& p, unsigned seed = 1) : Fixture(p, false, seed) {
    for (int i = 0; i < 100; ++i) navigation.step(flown.frame(), true);
    flown.flying = true;
  }
  double sideways_off_m_s() const {
    return (navigation.state().velocity_N_m_s - flown.truth.v).tail<2>().norm();
  }
};

TEST(Corners, KeepTheAttitudeOverAFloor) {
  double with_deg = 0, without_deg = 0, with_m_s = 0, without_m_s = 0;
  for (unsigned seed = 1; seed <= 12; ++seed) {
    NavigationParameters p = with_corners();
    Flight with(p, seed);
    with.run(100);
    EXPECT_GT(with.navigation.counters().corners_used, 150u);
    EXPECT_EQ(with.navigation.counters().corners_gated, 0u);
    EXPECT_FALSE(with.navigation.range_doubted());
    with_deg += with.tilt_error();
    with_m_s += with.sideways_off_m_s();
    p.corners = false;
    Flight without(p, seed);
    without.run(100);
    without_deg += without.tilt_error();
    without_m_s += without.sideways_off_m_s();
  }
  EXPECT_LT(with_deg, 0.8 * without_deg);
  EXPECT_LT(with_m_s, 0.8 * without_m_s);
}

// Errors relative to the variances: the mean square of n independent ones is 1 +- sqrt(2 / n).
TEST(Corners, TheFilterKnowsHowWell) {
  double squares = 0;
  constexpr int kFlights = 60;
  for (unsigned seed = 1; seed <= kFlights; ++seed) {
    Flight f(with_corners(), seed);
    f.flown.quantised = false;
    f.run(50);
    const auto e = f.flown.error(f.navigation);
    const auto variance = f.navigation.filter().velocity_variance();
    squares += e(4) * e(4) / variance(1) + e(5) * e(5) / variance(2);
  }
  EXPECT_NEAR(squares / (2 * kFlights), 1, 0.45);
}

// Ground that rises as steeply as configured: the attitude is not that of the ground.
TEST(Corners, AHillIsNoTilt) {
  for (unsigned seed = 1; seed <= 6; ++seed) {
    NavigationParameters p = with_corners(4 * kDegree);
    Flight with(p, seed);
    with.flown.slope = std::tan(4 * kDegree);
    with.run(100);
    p.corners = false;
    Flight without(p, seed);
    without.flown.slope = with.flown.slope;
    without.run(100);
    EXPECT_LT(with.tilt_error(), without.tilt_error() + 0.15) << seed;
    EXPECT_FALSE(with.navigation.range_doubted());
  }
}

TEST(Corners, ReplaceTheOneInTheMiddle) {
  Flight f(with_corners());
  f.run(10);
  f.flown.range_off_m[0] = 100;  // it says nothing that can be
  f.run(50);
  EXPECT_LT(std::abs(f.height_error()), 0.02);
  EXPECT_FALSE(f.navigation.range_doubted());
  const RangeSample& by_corners = f.navigation.range_by_corners();
  EXPECT_LT(f.flown.now_ns - by_corners.time_ns, 200'000'000);
}

TEST(Corners, OverruleOneThatDrifts) {
  Flight f(with_corners(4 * kDegree));
  f.run(10);
  for (int i = 0; i < 25; ++i) {
    f.flown.range_off_m[0] -= 0.03;  // 0.15 m/s
    f.run(1);
  }
  EXPECT_TRUE(f.navigation.range_doubted());
  f.run(20);
  EXPECT_LT(std::abs(f.height_error()), 0.05);
  EXPECT_NEAR(f.navigation.range_by_corners().range_m, f.flown.truth.p.x() - 0.1, 0.2);
  f.flown.flying = false;
  f.navigation.begin_calibration();
  EXPECT_FALSE(f.navigation.range_doubted()) << "until the next calibration";
}

TEST(Corners, OneOfTheFourThatLiesIsFound) {
  for (const std::size_t corner : {1u, 2u, 3u, 4u}) {
    Flight f(with_corners());
    f.run(10);
    const NavCounters before = f.navigation.counters();
    f.flown.range_off_m[corner] = 0.1;
    f.run(20);
    EXPECT_GT(f.navigation.counters().corners_gated, before.corners_gated + 30);
    EXPECT_LE(f.navigation.counters().corners_used, before.corners_used + 1);
    EXPECT_FALSE(f.navigation.range_doubted());
    EXPECT_LT(f.tilt_error(), 0.5);
  }
}

// By so little that each fit passes.
TEST(Corners, OneThatIsOffALittleIsFoundByTheMean) {
  for (const std::size_t corner : {1u, 4u}) {
    Flight f(with_corners());
    f.run(10);
    f.flown.range_off_m[corner] = 0.02;
    f.run(30);
    const NavCounters before = f.navigation.counters();
    f.run(20);
    EXPECT_LE(f.navigation.counters().corners_used, before.corners_used + 3) << corner;
  }
}

// The filter would believe the one in the middle again after ten readings that agree.
TEST(Corners, FourThatAgreeWithTheFilterOverruleAStep) {
  Flight f(with_corners(4 * kDegree));
  f.run(10);
  f.flown.range_off_m[0] = -1.2;
  double worst_m = 0;
  for (int i = 0; i < 20; ++i) {
    f.run(1);
    worst_m = std::max(worst_m, std::abs(f.height_error()));
  }
  EXPECT_TRUE(f.navigation.range_doubted());
  EXPECT_LT(worst_m, 0.1);
}

// It stands on a stone that only the one in the middle sees, and on a ramp.
TEST(Corners, GroundThatIsNoLevelPlaneIsNotTakenForTheirMounting) {
  for (const bool ramp : {false, true}) {
    const NavigationParameters p = with_corners(ramp ? 0 : 4 * kDegree);
    Flown flown(p, 1);
    Navigation navigation(p);
    if (ramp) {
      flown.slope = std::tan(3 * kDegree);
    } else {
      flown.range_off_m[0] = -0.3;
    }
    ASSERT_TRUE(flown.calibrate(navigation));
    for (int i = 0; i < 50; ++i) navigation.step(flown.frame(), true);
    EXPECT_TRUE(navigation.corners_uneven());
    flown.flying = true;
    flown.range_off_m[0] = 0;
    for (int i = 0; i < 50; ++i) navigation.step(flown.frame());
    EXPECT_EQ(navigation.counters().corners_used, 0u);
    EXPECT_FALSE(navigation.range_doubted());
  }
}

// What they measure at standstill is zero: how each is mounted does not count.
TEST(Corners, TheirMountingDoesNotCount) {
  const NavigationParameters p = with_corners();
  Flown flown(p, 1);
  Navigation navigation(p);
  flown.range_off_m = {0, 0.012, -0.008, 0.006, 0.012};
  ASSERT_TRUE(flown.calibrate(navigation));
  for (int i = 0; i < 20; ++i) navigation.step(flown.frame(), true);
  flown.flying = true;
  for (int i = 0; i < 50; ++i) navigation.step(flown.frame());
  EXPECT_EQ(navigation.counters().corners_gated, 0u);
  EXPECT_FALSE(navigation.range_doubted());
  const Vector3 up = navigation.state().q_NB * Vector3::UnitX();
  EXPECT_LT(degrees(std::acos(std::min(1.0, up.dot(flown.truth.q * Vector3::UnitX())))), 0.4);
}

// One that never stood with them, since it was calibrated, does not use them.
TEST(Corners, WithoutStandstillTheySayNothing) {
  Fixture f(with_corners());
  f.run(50);
  EXPECT_EQ(f.navigation.counters().corners_used, 0u);
  EXPECT_EQ(f.navigation.range_by_corners().time_ns, 0);
}

TEST(Corners, NeedAnAltimeterThatLooksDown) {
  NavigationParameters p = with_corners();
  EXPECT_EQ(check(p), nullptr);
  p.altimeter = false;
  EXPECT_STREQ(check(p),
               "altimeters at the corners need the one in the middle, and that it looks down");
  p = with_corners();
  p.corner_y_m = 0;
  EXPECT_NE(check(p), nullptr);
}

}  // namespace
}  // namespace lss::gnc::talaris::test
