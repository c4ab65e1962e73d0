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

// A large fixed part hides in a proportion what one more costs.
TEST(Growth, AStepIsWorseThanLinearWhenOneMoreCostsMoreThanBefore) {
  Growth growth{.name = "some", .what = "", .cost = "", .unit = ""};
  for (const double n : {1, 2, 4, 8})
    growth.points.push_back({n, {100 + n * n - 0.1, 100 + n * n, 100 + n * n + 0.1}});
  const std::vector<Step> all = steps(growth);
  EXPECT_EQ(all[0].met, Met::yes) << "nothing to compare with";
  EXPECT_EQ(all[1].met, Met::no);
  EXPECT_EQ(all[2].met, Met::no);
  for (Point& point : growth.points) point.cost = {100 + 3 * point.count};
  for (const Step& step : steps(growth)) EXPECT_EQ(step.met, Met::yes) << step.to;
}

TEST(Growth, ACostThatFallsIsAtMostLinear) {
  const Growth growth{.name = "some",
                      .what = "",
                      .cost = "",
                      .unit = "",
                      .points = {{1, {21}}, {2, {15}}, {4, {14}}, {8, {16}}}};
  const std::vector<Step> all = steps(growth);
  EXPECT_EQ(all[1].met, Met::yes);
  EXPECT_EQ(all[2].met, Met::no) << "one more costs 0.5, before nothing";
}

TEST(Growth, NothingIsJudgedByWhatWasNotMeasured) {
  EXPECT_EQ(of({0}, {5}), Met::undecided);
  EXPECT_EQ(of({}, {5}), Met::undecided);
  EXPECT_EQ(of({5}, {kNone}), Met::undecided);
}

TEST(Growth, EachMoreIsTheSlopeBetweenTwoCounts) {
  const Growth growth{.name = "some",
                      .what = "",
                      .cost = "",
                      .unit = "",
                      .points = {{1, {7}}, {2, {9}}, {4, {12, 13, 14}}}};
  const std::vector<Step> all = steps(growth);
  ASSERT_EQ(all.size(), 2u);
  EXPECT_EQ(all[0].each_more, 2);
  EXPECT_EQ(all[1].each_more, 2);
  EXPECT_EQ(all[1].least_more, 1.5);
  EXPECT_EQ(all[1].most_more, 2.5);
  EXPECT_NEAR(all[1].of_proportional, 13. / 18, 1e-12);
}

}  // namespace
}  // namespace lss::bench
