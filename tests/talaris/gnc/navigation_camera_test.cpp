// Navigation with a camera that measures how fast the ground passes.

#include <gtest/gtest.h>

#include <cmath>

#include "gnc/talaris/checked_navigation.h"
#include "tests/talaris/gnc/navigation_fixture.h"

namespace lss::gnc::talaris::test {
namespace {

NavigationParameters with_camera() {
  NavigationParameters p;
  p.camera = true;
  p.ground_slope_rad = 0;
  p.altimeter_at_B_m = {-0.1, 0.2, -0.15};
  p.flow_scale_sigma = 0;
  return p;
}

double sideways(const Vector3& v) { return v.tail<2>().norm(); }

TEST(Camera, KeepsSpeedAndPlace) {
  double worst_m_s = 0, worst_m = 0, without_m_s = 0;
  for (unsigned seed = 1; seed <= 8; ++seed) {
    NavigationParameters p = with_camera();
    Fixture f(p, true, seed);
    f.run(100);
    worst_m_s =
        std::max(worst_m_s, sideways(f.navigation.state().velocity_N_m_s - f.flown.truth.v));
    worst_m = std::max(worst_m, sideways(f.navigation.state().position_N_m - f.flown.truth.p));
    EXPECT_GT(f.navigation.counters().flows_used, 350u) << "seed " << seed;
    EXPECT_LT(f.navigation.counters().flows_gated, 5u) << "seed " << seed;
    p.camera = false;
    Fixture blind(p, true, seed);
    blind.run(100);
    without_m_s = std::max(without_m_s,
                           sideways(blind.navigation.state().velocity_N_m_s - blind.flown.truth.v));
  }
  EXPECT_LT(worst_m_s, 0.05);
  EXPECT_LT(worst_m, 0.3);
  EXPECT_GT(without_m_s, 4 * worst_m_s);
}

// Errors relative to the variances: the mean square of n independent ones is 1 +- sqrt(2 / n).
TEST(Camera, TheFilterKnowsHowWell) {
  double squares = 0;
  constexpr int kFlights = 60;
  for (unsigned seed = 1; seed <= kFlights; ++seed) {
    Fixture f(with_camera(), true, seed);
    f.flown.quantised = false;
    f.run(50);
    const auto e = f.flown.error(f.navigation);
    const auto variance = f.navigation.filter().velocity_variance();
    squares += e(4) * e(4) / variance(1) + e(5) * e(5) / variance(2);
  }
  EXPECT_NEAR(squares / (2 * kFlights), 1, 0.45);
}

TEST(Camera, AnExpectedSampleChangesNothing) {
  NavigationParameters p = with_camera();
  p.flow_sigma_rad_s = 1e-6;
  Fixture f(p);
  f.flown.quantised = false;
  f.run(10);
  const double before = sideways(f.navigation.state().velocity_N_m_s - f.flown.truth.v);
  EXPECT_LT(before, 0.01) << "what is exact is followed exactly, with arm, tilt and turning";
}

TEST(Camera, OneThatIsFarOffIsGated) {
  Fixture f(with_camera());
  f.run(20);
  f.flown.flow_off = {0, 2, 0};
  const auto used = f.navigation.counters().flows_used;
  f.run(5);
  EXPECT_EQ(f.navigation.counters().flows_used, used);
  EXPECT_GE(f.navigation.counters().flows_gated, 18u);
  EXPECT_LT(sideways(f.navigation.state().velocity_N_m_s - f.flown.truth.v), 0.1);
}

// By ever more, each sample within its gate: without the check it is followed.
TEST(Camera, OneThatContradictsTheImuIsLeftUntilTheNextCalibration) {
  for (unsigned seed = 1; seed <= 8; ++seed) {
    const NavigationParameters p = with_camera();
    Flown flown(p, seed);
    CheckedNavigation navigation(p);
    const auto calibrate = [&] {
      flown.flying = false;
      navigation.begin_calibration();
      while (navigation.calibration().phase == CalibrationPhase::running)
        navigation.calibrate(flown.frame());
      ASSERT_TRUE(navigation.aligned());
      EXPECT_FALSE(navigation.camera_doubted());
    };
    calibrate();
    Navigation followed(p), blind(p);
    {
      Flown same(p, seed);
      ASSERT_TRUE(same.calibrate(followed));
    }
    blind = followed;
    flown.flying = true;
    const auto run = [&](int frames) {
      for (int i = 0; i < frames; ++i) {
        const Batch batch = flown.frame();
        navigation.step(batch);
        followed.step(batch);
        Batch less = batch;
        less.flows = {};
        blind.step(less);
      }
    };
    run(5);
    EXPECT_FALSE(navigation.camera_doubted());
    for (int i = 1; i <= 30; ++i) {
      flown.flow_off = {0, 0.01 * i, 0};
      run(1);
    }
    EXPECT_TRUE(navigation.camera_doubted());
    EXPECT_GT(sideways(followed.state().velocity_N_m_s - flown.truth.v), 0.15);
    EXPECT_EQ(navigation.state().velocity_N_m_s, blind.state().velocity_N_m_s);
    EXPECT_EQ(navigation.state().position_N_m, blind.state().position_N_m);
    flown.flow_off.setZero();
    run(10);
    EXPECT_TRUE(navigation.camera_doubted());
  }
}

TEST(Camera, OneThatIsGatedForLongIsLeft) {
  Flown flown(with_camera(), 1);
  CheckedNavigation navigation(with_camera());
  navigation.begin_calibration();
  while (navigation.calibration().phase == CalibrationPhase::running)
    navigation.calibrate(flown.frame());
  flown.flying = true;
  flown.flow_off = {0, 2, 0};
  for (int i = 0; i < 9; ++i) navigation.step(flown.frame());
  EXPECT_FALSE(navigation.camera_doubted());
  flown.flow_off.setZero();
  navigation.step(flown.frame());
  flown.flow_off = {0, 2, 0};
  for (int i = 0; i < 9; ++i) navigation.step(flown.frame());
  EXPECT_FALSE(navigation.camera_doubted());
  for (int i = 0; i < 2; ++i) navigation.step(flown.frame());
  EXPECT_TRUE(navigation.camera_doubted());
}

TEST(Camera, SamplesAfterAGapOfNoNumberOrOutOfItsRangeAreNotUsed) {
  Fixture f(with_camera());
  f.run(2);
  const auto bad = [&](auto change) {
    const auto before = f.navigation.counters();
    f.flown.frame();
    change(f.flown.flows);
    f.navigation.step(f.flown.batch());
    EXPECT_EQ(f.navigation.counters().flows_gated, before.flows_gated);
    return f.navigation.counters().flows_bad - before.flows_bad;
  };
  EXPECT_EQ(bad([](auto&) {}), 0u);
  EXPECT_EQ(bad([](auto& flows) { flows.erase(flows.begin() + 1); }), 1u) << "after a gap";
  EXPECT_EQ(bad([](auto& flows) { flows[2].y_rad = kNaN; }), 1u);
  EXPECT_EQ(bad([](auto& flows) { flows[2].z_rad = 1e300; }), 1u);
  EXPECT_EQ(bad([](auto& flows) { flows.push_back(flows.back()); }), 1u) << "the same again";
  EXPECT_EQ(bad([](auto& flows) { flows.back().time_ns += 1'000'000'000; }), 1u) << "not yet";
  EXPECT_TRUE(f.navigation.state().position_N_m.allFinite());

  NavigationParameters near = with_camera();
  near.flow_max_m = 0.5;
  Fixture low(near);
  low.run(10);
  EXPECT_EQ(low.navigation.counters().flows_used, 0u);
  EXPECT_GT(low.navigation.counters().flows_bad, 30u);
}

TEST(Camera, NeedsAnAltimeterThatLooksDown) {
  NavigationParameters p = with_camera();
  EXPECT_EQ(check(p), nullptr);
  p.pointing = Pointing::sideways;
  EXPECT_NE(check(p), nullptr);
  p = with_camera();
  p.altimeter = false;
  EXPECT_NE(check(p), nullptr);
}

}  // namespace
}  // namespace lss::gnc::talaris::test
