// Navigation frame by frame: gates, gaps, silence, and the requirements of the frame thread.

#include "gnc/talaris/navigation.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <cstring>

#include "tests/support/allocations.h"
#include "tests/talaris/gnc/navigation_fixture.h"

namespace lss::gnc::talaris::test {
namespace {

TEST(Navigation, IsNotValidBeforeItIsCalibrated) {
  Flown flown({}, 1);
  Navigation navigation;
  EXPECT_FALSE(navigation.step(flown.frame()).valid);
  navigation.begin_calibration();
  EXPECT_FALSE(navigation.calibrate(flown.frame()).phase == CalibrationPhase::done);
  EXPECT_FALSE(navigation.step(flown.frame()).valid);
  EXPECT_FALSE(navigation.state().valid);
}

TEST(Navigation, BeginsWhereItWasCalibrated) {
  Fixture f({}, false);
  const NavState& s = f.navigation.state();
  EXPECT_TRUE(s.valid);
  EXPECT_EQ(s.time_ns, f.flown.now_ns);
  EXPECT_NEAR(s.position_N_m.x(), 1.2, 0.01);
  EXPECT_EQ(s.position_N_m.y(), 0);
  EXPECT_LT(s.velocity_N_m_s.norm(), 1e-3);
  EXPECT_LT(f.tilt_error(), 0.5);
  f.navigation.begin_calibration();
  EXPECT_FALSE(f.navigation.state().valid);
  EXPECT_FALSE(f.navigation.aligned());
}

TEST(Navigation, FollowsTheFlight) {
  NavigationParameters level;
  level.ground_slope_rad = 0;
  Fixture f(level);
  for (int i = 0; i < 100; ++i) {
    const NavState& s = f.run(1);
    ASSERT_TRUE(s.valid);
    ASSERT_EQ(s.time_ns, f.flown.now_ns);
    ASSERT_LT(std::abs(f.height_error()), 0.04);
    ASSERT_LT((s.velocity_N_m_s - f.flown.truth.v).norm(), 0.7);
    ASSERT_LT(f.tilt_error(), 1);
  }
  EXPECT_EQ(f.navigation.counters().imu_used, 4000u);
  EXPECT_EQ(f.navigation.counters().gaps + f.navigation.counters().frames_held, 0u);
  EXPECT_NEAR(f.navigation.counters().ranges_used, 200, 5);
}

TEST(Navigation, AccelerationIsTheMeanOfTheFrame) {
  Fixture f;
  f.run(10);
  const Vector3 before = f.flown.truth.v;
  const NavState& s = f.run(1);
  const Vector3 mean = (f.flown.truth.v - before) / 0.2;
  EXPECT_LT((s.acceleration_N_m_s2 - mean).norm(), 0.3);
  EXPECT_LT((s.rate_B_rad_s - (f.flown.imu.back().rate_B_rad_s - s.gyro_bias_rad_s)).norm(), 1e-15);
}

TEST(Navigation, PredictionGoesOnAsItWas) {
  NavState s;
  s.time_ns = 5;
  s.velocity_N_m_s = {1, 0, 2};
  s.acceleration_N_m_s2 = {0, 1, -4};
  s.rate_B_rad_s = {0.5, 0, 0};
  const NavState later = predict(s, 0.15);
  EXPECT_EQ(later.time_ns, 150'000'005);
  EXPECT_LT((later.position_N_m - Vector3(0.15, 0.01125, 0.3 - 0.045)).norm(), 1e-15);
  EXPECT_LT((later.velocity_N_m_s - Vector3(1, 0.15, 2 - 0.6)).norm(), 1e-15);
  EXPECT_NEAR(degrees(later.q_NB.angularDistance(s.q_NB)), degrees(0.075), 1e-9);
}

// A range measured between two samples belongs between them: with the whole filter at standstill
// except one vertical speed, half a sample is 5 mm at 2 m/s.
TEST(Navigation, RangesAreUsedAtTheirTime) {
  NavigationParameters p;
  p.imu_period_s = 0.01;
  Fixture f(p, true, 3);
  f.run(20);
  Navigation between = f.navigation;
  f.flown.frame();
  f.flown.ranges.clear();
  const Batch plain = f.flown.batch();
  f.navigation.step(plain);
  // exactly the filter's expectation half a sample before the fifth
  const ImuSample& fifth = f.flown.imu[5];
  const std::int64_t at_ns = fifth.time_ns - 5'000'000;
  Navigation probe = between;
  const ImuSample half[] = {f.flown.imu[0], f.flown.imu[1],
                            f.flown.imu[2], f.flown.imu[3],
                            f.flown.imu[4], {at_ns, fifth.rate_B_rad_s, fifth.force_B_m_s2}};
  probe.step({half, {}, at_ns});
  const double range = probe.state().position_N_m.x() / (probe.state().q_NB * Vector3::UnitX()).x();
  const RangeSample exact[] = {{at_ns, range}};
  between.step({f.flown.imu, exact, f.flown.now_ns});
  EXPECT_NEAR(between.counters().innovation_m, 0, 1e-7);
  EXPECT_EQ(between.counters().ranges_used, f.navigation.counters().ranges_used + 1);
}

// The same range one frame later: taken back by the velocity.
TEST(Navigation, LatencyIsTakenOff) {
  for (const double latency : {0.0, 0.05, 0.12}) {
    NavigationParameters told, ignorant;
    told.range_latency_s = latency;
    double errors[2] = {0, 0};
    for (int which = 0; which < 2; ++which) {
      Flown flown({}, 7);
      flown.size = 2;
      Navigation navigation(which == 0 ? told : ignorant);
      ASSERT_TRUE(flown.calibrate(navigation));
      flown.flying = true;
      std::vector<RangeSample> waiting;
      for (int i = 0; i < 100; ++i) {
        flown.frame();
        const auto shift = static_cast<std::int64_t>(latency * 1e9);
        for (RangeSample& r : flown.ranges) r.time_ns += shift;
        std::vector<RangeSample> now;
        waiting.insert(waiting.end(), flown.ranges.begin(), flown.ranges.end());
        while (!waiting.empty() && waiting.front().time_ns <= flown.now_ns) {
          now.push_back(waiting.front());
          waiting.erase(waiting.begin());
        }
        navigation.step({flown.imu, now, flown.now_ns});
        errors[which] += std::pow(navigation.state().position_N_m.x() - flown.truth.p.x(), 2) / 100;
      }
      EXPECT_GT(navigation.counters().ranges_used, which == 0 ? 190u : 0u);
    }
    EXPECT_LT(std::sqrt(errors[0]), 0.015) << latency;
    if (latency > 0) {
      EXPECT_GT(errors[1], 4 * errors[0]) << latency;
    }
  }
}

TEST(Navigation, AnOutlierIsGatedAndChangesNothing) {
  Fixture f;
  f.run(20);
  Navigation twin = f.navigation;
  f.flown.frame();
  f.flown.ranges = {{f.flown.now_ns - 100'000'000, 9.0}};
  f.navigation.step(f.flown.batch());
  EXPECT_EQ(f.navigation.counters().ranges_gated, 1u);
  EXPECT_GT(f.navigation.counters().innovation_m, 1);
  f.flown.ranges.clear();
  twin.step(f.flown.batch());
  EXPECT_LT((f.navigation.state().position_N_m - twin.state().position_N_m).norm(), 1e-12);
  EXPECT_EQ(f.navigation.counters().ranges_used, twin.counters().ranges_used);
}

// The ground is half a metre lower from here on: after ten readings that agree it is believed.
TEST(Navigation, AStepOfTheGroundIsBelievedAfterASecond) {
  Fixture f;
  f.run(20);
  f.flown.ground_m = -0.5;
  f.run(4);
  EXPECT_EQ(f.navigation.counters().gates_reopened, 0u);
  EXPECT_LT(std::abs(f.height_error()), 0.05);
  f.run(3);
  EXPECT_EQ(f.navigation.counters().gates_reopened, 1u);
  EXPECT_EQ(f.navigation.counters().ranges_gated, 10u);
  EXPECT_NEAR(f.height_error(), 0.5, 0.05);
  f.run(20);
  EXPECT_NEAR(f.height_error(), 0.5, 0.05);
  EXPECT_EQ(f.navigation.counters().ranges_gated, 10u);
}

// Dust: readings that contradict the filter and each other are never believed.
TEST(Navigation, ScatteredReadingsNeverReopenTheGate) {
  Fixture f;
  f.run(20);
  for (int i = 0; i < 50; ++i) {
    f.flown.frame();
    for (RangeSample& r : f.flown.ranges) r.range_m = 5 + 3 * std::abs(f.flown.normal(1));
    f.navigation.step(f.flown.batch());
  }
  EXPECT_EQ(f.navigation.counters().gates_reopened, 0u);
  EXPECT_GT(f.navigation.counters().ranges_gated, 90u);
}

TEST(Navigation, LostPacketsAreBridged) {
  Fixture f, whole;
  for (int i = 0; i < 50; ++i) {
    f.flown.frame();
    f.flown.imu.erase(f.flown.imu.begin() + 10);
    f.flown.imu.erase(f.flown.imu.begin() + 20, f.flown.imu.begin() + 23);
    f.navigation.step(f.flown.batch());
    whole.run(1);
  }
  EXPECT_EQ(f.navigation.counters().gaps, 100u);
  EXPECT_NEAR(f.navigation.counters().longest_gap_s, 0.020, 1e-9);
  EXPECT_EQ(f.navigation.counters().imu_used, 1800u);
  EXPECT_TRUE(f.navigation.state().valid);
  EXPECT_LT(std::abs(f.height_error()), 0.05);
  EXPECT_LT(f.tilt_error(), 1.5);
  // and it knows that it knows less
  EXPECT_GT(f.navigation.state().attitude_sigma_rad.y(),
            1.02 * whole.navigation.state().attitude_sigma_rad.y());
}

TEST(Navigation, BrokenAndRepeatedSamplesAreCountedAndIgnored) {
  Fixture f;
  f.run(5);
  Navigation twin = f.navigation;
  f.flown.frame();
  twin.step(f.flown.batch());
  const ImuSample good = f.flown.imu[10];
  ImuSample none = good, huge = good, old = good;
  none.force_B_m_s2.y() = kNaN;
  huge.rate_B_rad_s.z() = 40;
  old.time_ns -= 30'000'000;
  f.flown.imu.insert(f.flown.imu.begin() + 11, {good, none, huge, old});
  f.flown.ranges.push_back({f.flown.now_ns - 1, kNaN});
  f.flown.ranges.push_back({f.flown.now_ns - 1, 0.05});
  f.flown.ranges.push_back({f.flown.now_ns - 1, 31});
  f.flown.ranges.push_back(f.flown.ranges.front());
  f.navigation.step(f.flown.batch());
  EXPECT_EQ(f.navigation.counters().imu_bad, 2u);
  EXPECT_EQ(f.navigation.counters().imu_late, 2u);
  EXPECT_EQ(f.navigation.counters().ranges_bad, 4u);
  EXPECT_EQ(f.navigation.state().position_N_m, twin.state().position_N_m);
  EXPECT_EQ(f.navigation.state().q_NB.coeffs(), twin.state().q_NB.coeffs());
}

// One held frame is bridged; a second one is too long, and it stays so when the IMU comes back
// late.
TEST(Navigation, SilenceIsBridgedForAFrameAndThenNotValid) {
  Fixture f;
  f.run(20);
  f.flown.frame();
  f.navigation.step({{}, {}, f.flown.now_ns});
  EXPECT_TRUE(f.navigation.state().valid);
  EXPECT_EQ(f.navigation.state().time_ns, f.flown.now_ns);
  EXPECT_EQ(f.navigation.counters().frames_held, 1u);
  EXPECT_LT(std::abs(f.height_error()), 0.06);
  EXPECT_LT(f.tilt_error(), 3);
  Navigation back = f.navigation;
  Flown flown = f.flown;
  back.step(flown.frame());
  EXPECT_TRUE(back.state().valid);
  EXPECT_EQ(back.counters().gaps, 1u);
  EXPECT_NEAR(back.counters().longest_gap_s, 0.205, 1e-9);

  for (int i = 0; i < 5; ++i) {
    f.flown.frame();
    f.navigation.step({{}, f.flown.ranges, f.flown.now_ns});
    EXPECT_FALSE(f.navigation.state().valid);
    EXPECT_TRUE(f.navigation.state().position_N_m.allFinite());
    EXPECT_LT(std::abs(f.height_error()), 0.1) << "the altimeter goes on";
  }
  f.run(1);
  EXPECT_FALSE(f.navigation.state().valid) << "how it stands is not known after a second";
  EXPECT_GT(degrees(f.navigation.state().attitude_sigma_rad.maxCoeff()), 20);
}

TEST(Navigation, AYearOfSilenceIsSurvived) {
  Fixture f;
  f.run(5);
  f.flown.now_ns += 31'536'000'000'000'000;
  f.run(2);
  EXPECT_FALSE(f.navigation.state().valid);
  EXPECT_TRUE(f.navigation.filter().covariance().allFinite());
  EXPECT_TRUE(f.navigation.state().q_NB.coeffs().allFinite());
}

TEST(Navigation, NothingAllocates) {
  Flown flown({}, 1);
  NavigationParameters p;
  p.stand.fixed_y = true;
  p.stand.rotation = FreeRotation::none;
  Navigation navigation(p);
  navigation.begin_calibration();
  for (int i = 0; i < 400; ++i) {
    flown.frame();
    if (i % 41 == 6) flown.imu.erase(flown.imu.begin(), flown.imu.begin() + 5);
    if (i % 37 == 5) flown.imu.clear();
    if (i > 250) flown.ground_m = -1;
    const Batch batch = flown.batch();
    const std::uint64_t before = testing_support::allocations();
    navigation.calibrate(batch);
    navigation.step(batch, i % 2 == 0);
    ASSERT_EQ(testing_support::allocations(), before);
  }
  EXPECT_TRUE(navigation.aligned());
  EXPECT_GT(navigation.counters().gates_reopened, 0u);
}

std::array<double, 16> numbers(const NavState& s) {
  std::array<double, 16> n{};
  Eigen::Map<Vector3>(n.data()) = s.position_N_m;
  Eigen::Map<Vector3>(n.data() + 3) = s.velocity_N_m_s;
  Eigen::Map<Eigen::Vector4d>(n.data() + 6) = s.q_NB.coeffs();
  Eigen::Map<Vector3>(n.data() + 10) = s.attitude_sigma_rad;
  Eigen::Map<Vector3>(n.data() + 13) = s.position_sigma_m;
  return n;
}

TEST(Navigation, SameBatchesGiveTheSameBits) {
  Fixture f;
  Navigation twin = f.navigation;
  for (int i = 0; i < 100; ++i) {
    const Batch batch = f.flown.frame();
    const auto a = numbers(f.navigation.step(batch)), b = numbers(twin.step(batch));
    ASSERT_EQ(std::memcmp(a.data(), b.data(), sizeof(a)), 0);
    if (i == 50) twin = f.navigation;
  }
}

double any_double() {
  using Limits = std::numeric_limits<double>;
  return *rc::gen::oneOf(
      rc::gen::element(Limits::quiet_NaN(), Limits::infinity(), -Limits::infinity(), 1e308, -1e308,
                       1e-320, 0.0),
      rc::gen::map(rc::gen::inRange(-3000, 3001), [](int n) { return n * 0.01; }));
}

// For any input the output is finite and the covariance stays valid.
RC_GTEST_PROP(NavigationNonsense, NeverComesOutAsNonsense, ()) {
  static const Fixture begun;
  Flown flown = begun.flown;
  Navigation navigation = begun.navigation;
  const int frames = *rc::gen::inRange(1, 15);
  for (int i = 0; i < frames; ++i) {
    flown.frame();
    const int changes = *rc::gen::inRange(0, 6);
    for (int c = 0; c < changes && !flown.imu.empty(); ++c) {
      ImuSample& s = flown.imu[*rc::gen::inRange<std::size_t>(0, flown.imu.size())];
      const int what = *rc::gen::inRange(0, 5);
      if (what == 0) s.time_ns = *rc::gen::arbitrary<std::int64_t>() / 4;
      if (what == 1) s.rate_B_rad_s(*rc::gen::inRange(0, 3)) = any_double();
      if (what == 2) s.force_B_m_s2(*rc::gen::inRange(0, 3)) = any_double();
      if (what == 3) flown.imu.resize(flown.imu.size() / 2);
      if (what == 4)
        flown.ranges.push_back({*rc::gen::arbitrary<std::int64_t>() / 4, any_double()});
    }
    const NavState& s = navigation.step(flown.batch());
    for (const double x : numbers(s)) RC_ASSERT(std::isfinite(x));
    RC_ASSERT(std::abs(s.q_NB.norm() - 1) < 1e-9);
    RC_ASSERT(s.position_sigma_m.minCoeff() >= 0);
  }
}

TEST(Navigation, ParametersAreChecked) {
  EXPECT_EQ(check(NavigationParameters{}), nullptr);
  const auto wrong = [](auto change) {
    NavigationParameters p;
    change(p);
    return check(p) != nullptr;
  };
  EXPECT_TRUE(wrong([](auto& p) { p.range_sigma_m = 0; }));
  EXPECT_TRUE(wrong([](auto& p) { p.force_noise = kNaN; }));
  EXPECT_TRUE(wrong([](auto& p) { p.rate_bias_walk = -1; }));
  EXPECT_TRUE(wrong([](auto& p) { p.altimeter_at_B_m.z() = HUGE_VAL; }));
  EXPECT_TRUE(wrong([](auto& p) { p.range_max_m = p.range_min_m; }));
  EXPECT_TRUE(wrong([](auto& p) { p.range_latency_s = 0.6; }));
  EXPECT_TRUE(wrong([](auto& p) { p.imu_period_s = 0.05; }));
  EXPECT_TRUE(wrong([](auto& p) { p.max_tilt_rad = 1.5; }));
  EXPECT_TRUE(wrong([](auto& p) {
    p.pointing = Pointing::sideways;
    p.roll_rad = 1.1;
  }));
  EXPECT_TRUE(wrong([](auto& p) { p.gate_reopens_after = 1; }));
  EXPECT_TRUE(wrong([](auto& p) { p.min_samples = 1.1; }));
  EXPECT_TRUE(wrong([](auto& p) { p.calibration_s = 0.5; }));
}

}  // namespace
}  // namespace lss::gnc::talaris::test
