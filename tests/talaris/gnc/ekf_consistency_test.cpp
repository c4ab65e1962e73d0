// Whether the filter is as uncertain as it says: a hundred flights of 20 s after 30 s of
// calibration, with the sensors' noise, quantisation and biases. Sums of squares over all flights
// are chi-square; bounds are five standard deviations of that.

#include <gtest/gtest.h>

#include <Eigen/Cholesky>

#include "tests/talaris/gnc/flown.h"

namespace lss::gnc::talaris::test {
namespace {

constexpr int kRuns = 100;

void expect_chi_square(double sum, double freedom, const char* what) {
  const double bound = 5 * std::sqrt(2 * freedom);
  EXPECT_NEAR(sum, freedom, bound) << what;
  testing::Test::RecordProperty(what, std::to_string(sum / freedom));
}

class ConsistencyOf : public testing::TestWithParam<Pointing> {};
INSTANTIATE_TEST_SUITE_P(DownAndSideways, ConsistencyOf,
                         testing::Values(Pointing::down, Pointing::sideways));

TEST_P(ConsistencyOf, ErrorsAndInnovationsAreAsLargeAsTheFilterSays) {
  NavigationParameters p;
  p.ground_slope_rad = 0;  // as it is here
  p.pointing = GetParam();
  p.altimeter_at_B_m = {-0.2, 0.1, 0.15};
  p.height_m = 1.2;
  double calibrated = 0, after_5 = 0, after_20 = 0, attitude = 0, innovations = 0;
  int ranges = 0;
  for (unsigned run = 0; run < kRuns; ++run) {
    Flown flown(p, run);
    Navigation navigation(p);
    ASSERT_TRUE(flown.calibrate(navigation)) << describe(navigation.calibration().fault);
    const auto squares = [&](int first, int count) {
      const DenseEkf::Vector e = flown.error(navigation);
      const Eigen::MatrixXd c = navigation.filter().covariance().block(first, first, count, count);
      const Eigen::VectorXd x = e.segment(first, count);
      return x.dot(c.ldlt().solve(x));
    };
    // velocity is not estimated while it stands, and the wall's distance is by definition
    calibrated += squares(6, 9);
    flown.flying = true;
    std::uint32_t used = 0;
    for (int frame = 1; frame <= 100; ++frame) {
      ASSERT_TRUE(navigation.step(flown.frame()).valid);
      const NavCounters& c = navigation.counters();
      if (c.ranges_used > used) {
        innovations += std::pow(c.innovation_m / c.innovation_sigma_m, 2);
        ++ranges;
      }
      used = c.ranges_used;
      if (frame == 25) after_5 += squares(0, 15);
    }
    after_20 += squares(0, 15);
    attitude += squares(6, 3);
    ASSERT_EQ(navigation.counters().ranges_gated, 0u);
    ASSERT_EQ(navigation.counters().gaps, 0u);
  }
  EXPECT_GT(ranges, 9500);
  expect_chi_square(calibrated, 9 * kRuns, "calibrated");
  expect_chi_square(after_5, 15 * kRuns, "after_5_s");
  expect_chi_square(after_20, 15 * kRuns, "after_20_s");
  expect_chi_square(attitude, 3 * kRuns, "attitude_after_20_s");
  expect_chi_square(innovations, ranges, "innovations");
}

// The same check finds a filter that is too sure of itself.
TEST(Consistency, FindsAFilterThatIsTooSure) {
  NavigationParameters real, believed;
  believed.force_noise = real.force_noise / 2;
  believed.rate_noise = real.rate_noise / 2;
  believed.force_bias_walk = real.force_bias_walk / 2;
  believed.rate_bias_walk = real.rate_bias_walk / 2;
  double squares = 0;
  constexpr int kFew = 20;
  for (unsigned run = 0; run < kFew; ++run) {
    Flown flown(real, run);
    Navigation navigation(believed);
    ASSERT_TRUE(flown.calibrate(navigation));
    flown.flying = true;
    for (int frame = 0; frame < 100; ++frame) navigation.step(flown.frame());
    const DenseEkf::Vector e = flown.error(navigation);
    const Eigen::MatrixXd c = navigation.filter().covariance();
    squares += e.dot(c.ldlt().solve(e));
  }
  EXPECT_GT(squares, 15 * kFew + 10 * std::sqrt(2.0 * 15 * kFew));
}

// The figures of the document: drift of a flight.
TEST(Consistency, HeightIsKnownToMillimetresAndTheRestDrifts) {
  NavigationParameters p;
  p.ground_slope_rad = 0;  // as it is here
  double height = 0, across = 0, upright = 0;
  for (unsigned run = 0; run < kRuns; ++run) {
    Flown flown(p, 1000 + run);
    Navigation navigation(p);
    ASSERT_TRUE(flown.calibrate(navigation));
    flown.flying = true;
    for (int frame = 0; frame < 100; ++frame) navigation.step(flown.frame());
    const DenseEkf::Vector e = flown.error(navigation);
    height += e(0) * e(0) / kRuns;
    across += (e(1) * e(1) + e(2) * e(2)) / 2 / kRuns;
    upright += (e(7) * e(7) + e(8) * e(8)) / 2 / kRuns;
  }
  EXPECT_LT(std::sqrt(height), 0.010);
  EXPECT_LT(std::sqrt(across), 3);
  EXPECT_LT(std::sqrt(upright), 0.4 * kDegree);
  RecordProperty("height_rms_mm", std::to_string(std::sqrt(height) * 1e3));
  RecordProperty("across_rms_m", std::to_string(std::sqrt(across)));
  RecordProperty("tilt_rms_deg", std::to_string(std::sqrt(upright) / kDegree));
}

}  // namespace
}  // namespace lss::gnc::talaris::test
