// Which step of a count is worse than linear.

#include "tests/bench/growth.h"

#include <gtest/gtest.h>

namespace lss::bench {
namespace {

Met of(const Samples& at_2, const Samples& at_4) {
  const Growth growth{.name = "some",
                      .what = "of them",
                      .cost = "time",
                      .unit = "s",
                      .points = {{2, at_2}, {4, at_4}}};
  return steps(growth).front().met;
}

TEST(Growth, AStepIsWorseThanLinearWhenItCostsMoreThanItsShareOfTheCount) {
  EXPECT_EQ(of({10}, {15}), Met::yes);
  EXPECT_EQ(of({10}, {20}), Met::yes) << "without a fixed part";
  EXPECT_EQ(of({10}, {25}), Met::no);
  EXPECT_EQ(of({9, 10, 11}, {20, 25, 26}), Met::undecided) << "rounds differ by more";
  EXPECT_EQ(of({9, 10, 11}, {18, 19, 22}), Met::undecided);
  EXPECT_EQ(of({9, 10, 11}, {40, 41, 42}), Met::no);
}

TEST(Growth, EachMoreIsTheSlopeBetweenTwoCounts) {
  const Growth growth{.name = "some",
                      .what = "",
                      .cost = "",
                      .unit = "",
                      .points = {{1, {7}}, {2, {9}}, {4, {13}}}};
  const std::vector<Step> all = steps(growth);
  ASSERT_EQ(all.size(), 2u);
  EXPECT_EQ(all[0].each_more, 2);
  EXPECT_EQ(all[1].each_more, 2);
  EXPECT_NEAR(all[1].of_linear, 13. / 18, 1e-12);
}

}  // namespace
}  // namespace lss::bench
