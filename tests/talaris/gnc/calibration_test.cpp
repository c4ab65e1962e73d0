// Calibration: its results, and detection of forbidden conditions.

#include "gnc/talaris/calibration.h"

#include <gtest/gtest.h>

#include <cstring>
#include <functional>
#include <set>
#include <string>

#include "tests/talaris/gnc/flown.h"

namespace lss::gnc::talaris::test {
namespace {

using Spoil = std::function<void(Flown&, int frame)>;

struct Outcome {
  CalibrationStatus status;
  Alignment found;
  int frames = 0;
  std::set<CalibrationFault> faults;  // seen on the way
};

Outcome run(const NavigationParameters& p, const Spoil& spoil = {}, unsigned seed = 1) {
  Flown flown(p, seed);
  Calibration calibration;
  calibration.begin();
  Outcome r;
  while (calibration.status().phase == CalibrationPhase::running && r.frames < 5000) {
    flown.frame();
    if (spoil) spoil(flown, r.frames);
    ++r.frames;
    calibration.step(flown.batch(), p);
    r.faults.insert(calibration.status().fault);
  }
  r.status = calibration.status();
  r.found = calibration.result();
  return r;
}

TEST(Calibration, FindsBiasesUprightAndHeightIn30Seconds) {
  NavigationParameters p;
  for (unsigned seed = 0; seed < 20; ++seed) {
    Flown flown(p, seed);
    Calibration calibration;
    calibration.begin();
    int frames = 0;
    double progress = 0;
    while (calibration.status().phase == CalibrationPhase::running) {
      calibration.step(flown.frame(), p);
      ++frames;
      EXPECT_GE(calibration.status().progress, progress);
      progress = calibration.status().progress;
      EXPECT_NEAR(progress, frames * 0.2 / 30, 0.007);  // one frame
    }
    ASSERT_EQ(calibration.status().phase, CalibrationPhase::done);
    EXPECT_EQ(frames, 151);  // the first sample is one period into the first frame
    EXPECT_EQ(progress, 1);
    const Alignment& a = calibration.result();
    // a mean of 30 s, of a bias that walked on
    const double rate_sigma =
        std::hypot(p.rate_noise / std::sqrt(30.0), p.rate_bias_walk * std::sqrt(30.0 / 3));
    EXPECT_LT((a.gyro_bias_rad_s - flown.truth.bg).norm(), 5 * rate_sigma);
    // the filter's own unit: across the vertical, bias and tilt cannot be distinguished
    const Vector3 felt = flown.truth.q.conjugate() * Vector3(p.gravity_m_s2, 0, 0) + flown.truth.ba;
    const Vector3 expected =
        a.q_NB.conjugate() * Vector3(p.gravity_m_s2, 0, 0) + a.accelerometer_bias_m_s2;
    EXPECT_LT((felt - expected).norm(), 0.025);
    EXPECT_NEAR(a.accelerometer_bias_m_s2.norm(), std::abs(flown.truth.ba.x()), 0.02);
    EXPECT_NEAR(a.range_m, 1.2, 0.01);
    EXPECT_GT(a.ranges, 250);
  }
}

TEST(Calibration, HeadingIsTheOneThatIsGiven) {
  NavigationParameters p;
  p.roll_rad = 45 * kDegree;
  const Outcome r = run(p);
  ASSERT_EQ(r.status.phase, CalibrationPhase::done);
  const Vector3 z = r.found.q_NB * Vector3::UnitZ();
  EXPECT_NEAR(std::atan2(-z.y(), z.z()), 45 * kDegree, 0.01);
}

// One second of movement in the middle: reported, and then 30 s from there.
struct Movement {
  CalibrationFault fault;
  Vector3 rate, force;
  bool alternating;
};
class CalibrationMoved : public testing::TestWithParam<Movement> {};
INSTANTIATE_TEST_SUITE_P(
    Each, CalibrationMoved,
    testing::Values(Movement{CalibrationFault::turning, {0, 0.5 * kDegree, 0}, {0, 0, 0}, false},
                    Movement{CalibrationFault::turning, {-0.5 * kDegree, 0, 0}, {0, 0, 0}, false},
                    Movement{CalibrationFault::rate_spread, {0, 0, 1 * kDegree}, {0, 0, 0}, true},
                    Movement{CalibrationFault::shaking, {0, 0, 0}, {0, 0, -0.5}, false},
                    Movement{CalibrationFault::shaking, {0, 0, 0}, {0.5, 0, 0}, false},
                    Movement{CalibrationFault::force_spread, {0, 0, 0}, {1.5, 0, 0}, true}));

TEST_P(CalibrationMoved, BeginsAgainAndReportsTheReason) {
  const Movement m = GetParam();
  const Outcome r = run({}, [&](Flown& flown, int frame) {
    if (frame < 60 || frame >= 65) return;
    double sign = 1;
    for (ImuSample& s : flown.imu) {
      s.rate_B_rad_s += sign * m.rate;
      s.force_B_m_s2 += sign * m.force;
      if (m.alternating) sign = -sign;
    }
  });
  EXPECT_EQ(r.status.phase, CalibrationPhase::done);
  EXPECT_EQ(r.status.restarts, 1);
  EXPECT_EQ(r.status.fault, m.fault);
  EXPECT_GT(r.status.measured, r.status.limit);
  EXPECT_LT(r.status.measured, 3 * r.status.limit);
  // five frames of movement, then (a first one with the movement's mean may count) 30 s
  EXPECT_GE(r.frames, 60 + 1 + 151);
  EXPECT_LE(r.frames, 66 + 151);
}

TEST(Calibration, StandingStillIsNeverTakenForMovement) {
  for (unsigned seed = 0; seed < 50; ++seed) {
    const Outcome r = run({}, {}, seed);
    EXPECT_EQ(r.status.phase, CalibrationPhase::done) << seed;
    EXPECT_EQ(r.status.restarts, 0) << seed << describe(r.status.fault);
  }
}

TEST(Calibration, FailsWhenItIsMovedAgainAndAgain) {
  const Outcome r = run({}, [&](Flown& flown, int frame) {
    if (frame % 50 != 49) return;
    for (ImuSample& s : flown.imu) s.rate_B_rad_s.y() += 1 * kDegree;
  });
  EXPECT_EQ(r.status.phase, CalibrationPhase::failed);
  EXPECT_EQ(r.status.fault, CalibrationFault::turning);
  EXPECT_EQ(r.status.restarts, NavigationParameters{}.calibration_restarts);
  EXPECT_EQ(r.frames, 200);
}

// Trembling from the first frame on, never still for a second.
TEST(Calibration, FailsWhenItIsNeverStill) {
  const Outcome r = run({}, [&](Flown& flown, int) {
    double sign = 1;
    for (ImuSample& s : flown.imu) s.force_B_m_s2.z() += 2 * (sign = -sign);
  });
  EXPECT_EQ(r.status.phase, CalibrationPhase::failed);
  EXPECT_EQ(r.status.fault, CalibrationFault::force_spread);
  EXPECT_NEAR(r.status.measured, 2, 0.3);
  EXPECT_NEAR(r.frames, 5 * 150, 2);
}

// A permanent error is detected at the end.
TEST(Calibration, FailsOnWhatCannotBe) {
  struct Case {
    CalibrationFault fault;
    double measured, near;
    Spoil spoil;
  };
  const auto each = [](const std::function<void(ImuSample&)>& change) {
    return [change](Flown& flown, int) {
      for (ImuSample& s : flown.imu) change(s);
    };
  };
  const Case cases[] = {
      {CalibrationFault::rate_bias, 1.5 * kDegree, 0.4 * kDegree,
       each([](ImuSample& s) { s.rate_B_rad_s.x() += 1.5 * kDegree; })},
      {CalibrationFault::force_size, 0.98, 0.1, each([](ImuSample& s) { s.force_B_m_s2 *= 1.1; })},
      {CalibrationFault::tilted, 0.35, 0.08, each([](ImuSample& s) {
         s.force_B_m_s2 = exponential({0, 0.35, 0}) * s.force_B_m_s2;
       })},
      {CalibrationFault::tilted, 3.14159, 0.08, each([](ImuSample& s) { s.force_B_m_s2 *= -1; })},
      {CalibrationFault::imu_silent, 0.5, 0.01,
       [](Flown& flown, int) { flown.imu.resize(flown.imu.size() / 2); }},
      {CalibrationFault::imu_silent, 0, 0, [](Flown& flown, int) { flown.imu.clear(); }},
      {CalibrationFault::imu_silent, 1.5, 0.02,  // it sends at another rate
       [](Flown& flown, int) {
         for (std::size_t i = flown.imu.size(); i > 1; i -= 2) {
           ImuSample between = flown.imu[i - 1];
           between.time_ns -= 2'500'000;
           flown.imu.insert(flown.imu.begin() + static_cast<std::ptrdiff_t>(i - 1), between);
         }
       }},
      {CalibrationFault::few_ranges, 0, 0, [](Flown& flown, int) { flown.ranges.clear(); }},
      {CalibrationFault::few_ranges, 0, 0,
       [](Flown& flown, int) {
         for (RangeSample& r : flown.ranges) r.range_m = kNaN;
       }},
      {CalibrationFault::range_spread, 0.4, 0.05,
       [](Flown& flown, int frame) {
         for (RangeSample& r : flown.ranges) r.range_m += frame % 2 * 0.4;
       }},
  };
  for (const Case& c : cases) {
    const Outcome r = run({}, c.spoil);
    EXPECT_EQ(r.status.phase, CalibrationPhase::failed) << describe(c.fault);
    EXPECT_STREQ(describe(r.status.fault), describe(c.fault));
    EXPECT_NEAR(r.status.measured, c.measured, c.near) << describe(c.fault);
    EXPECT_EQ(r.status.restarts, 0) << describe(c.fault);
  }
}

TEST(Calibration, AltimeterIsNotAskedWhereThereIsNone) {
  NavigationParameters p;
  p.altimeter = false;
  const Outcome r = run(p, [](Flown& flown, int) { flown.ranges.clear(); });
  EXPECT_EQ(r.status.phase, CalibrationPhase::done);
  EXPECT_TRUE(std::isnan(r.found.range_m));
}

// A tenth of the samples broken, repeated or from the past: the others suffice, with the same
// result.
TEST(Calibration, BrokenSamplesDoNotCount) {
  const Outcome clean = run({});
  const Outcome broken = run({}, [](Flown& flown, int frame) {
    const ImuSample good = flown.imu[20];
    flown.imu.insert(flown.imu.begin() + 21, 3, good);
    flown.imu[21].time_ns -= 50'000'000;
    flown.imu[22].force_B_m_s2.setConstant(frame % 2 ? kNaN : HUGE_VAL);
    flown.imu[22].time_ns += 1;
    flown.imu[23].rate_B_rad_s.setConstant(1e300);
    flown.imu[23].time_ns += 2;
    flown.imu.push_back(good);
    flown.ranges.push_back({flown.now_ns, -1});
    flown.ranges.push_back({flown.now_ns, 1e9});
  });
  EXPECT_EQ(broken.status.phase, CalibrationPhase::done);
  EXPECT_EQ(broken.found.gyro_bias_rad_s, clean.found.gyro_bias_rad_s);
  EXPECT_EQ(broken.found.q_NB.coeffs(), clean.found.q_NB.coeffs());
  EXPECT_EQ(broken.found.range_m, clean.found.range_m);
}

TEST(Calibration, EveryFaultHasItsWords) {
  std::set<std::string> words;
  for (int i = 0; i <= static_cast<int>(CalibrationFault::range_spread); ++i) {
    words.insert(describe(static_cast<CalibrationFault>(i)));
  }
  EXPECT_EQ(words.size(), static_cast<std::size_t>(CalibrationFault::range_spread) + 1);
  EXPECT_EQ(words.count("unknown"), 0u);
}

}  // namespace
}  // namespace lss::gnc::talaris::test
