#include "idl/timing_statistics.h"

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <algorithm>
#include <vector>

#include "daemon/cycle/messages.h"

namespace lss {
namespace {

TEST(TimingSeries, EveryDurationLiesInItsBucket) {
  EXPECT_TRUE(rc::check([] {
    const auto ns = *rc::gen::inRange<std::int64_t>(0, 16'000'000'000);
    const std::size_t i = TimingSeries::index(ns);
    RC_ASSERT(i < TimingSeries::kBuckets);
    RC_ASSERT(TimingSeries::lower_ns(i) <= ns);
    RC_ASSERT(ns < TimingSeries::lower_ns(i + 1));
  }));
}

TEST(TimingSeries, BucketsFollowEachOtherAnEighthOfAnOctaveApart) {
  for (std::size_t i = 0; i < TimingSeries::kBuckets; ++i) {
    const auto low = TimingSeries::lower_ns(i), high = TimingSeries::lower_ns(i + 1);
    ASSERT_LT(low, high);
    ASSERT_EQ(TimingSeries::index(low), i);
    ASSERT_EQ(TimingSeries::index(high - 1), i);
    ASSERT_TRUE(i < 8 || 8 * (high - low) <= low);
  }
}

TEST(TimingSeries, WhatIsOutOfRangeIsCountedAtItsEnds) {
  TimingSeries s;
  s.add(-5);
  s.add(1'000'000'000'000);
  EXPECT_EQ(s.bucket.front(), 1u);
  EXPECT_EQ(s.bucket.back(), 1u);
  EXPECT_EQ(s.min_ns, -5);
  EXPECT_EQ(s.max_ns, 1'000'000'000'000);
}

TEST(TimingSeries, QuantilesAreThoseOfTheSortedValuesToTheWidthOfABucket) {
  EXPECT_TRUE(rc::check([](std::vector<std::uint32_t> values) {
    RC_PRE(!values.empty());
    TimingSeries s;
    for (const std::uint32_t v : values) s.add(v);
    std::ranges::sort(values);
    for (const double q : {0.5, 0.99, 0.999}) {
      const auto rank = static_cast<std::size_t>(
          std::max(1.0, std::ceil(q * static_cast<double>(values.size()))));
      const double exact = values[rank - 1];
      RC_ASSERT(std::abs(s.quantile_ns(q) - exact) <= std::max(128.0, exact / 8));
    }
    RC_ASSERT(s.quantile_ns(1) <= static_cast<double>(s.max_ns));
    RC_ASSERT(s.quantile_ns(0) >= static_cast<double>(s.min_ns));
  }));
}

TEST(TimingSeries, MeanAndSigma) {
  TimingSeries s;
  for (const int v : {2000, 4000, 4000, 4000, 5000, 5000, 7000, 9000}) s.add(v);
  EXPECT_DOUBLE_EQ(s.mean_ns(), 5000);
  EXPECT_DOUBLE_EQ(s.sigma_ns(), 2000);
}

TimingPoints points(std::uint64_t frame, std::int64_t released_late = 30) {
  const auto boundary = static_cast<std::int64_t>(frame) * 20 * kMillisecond;
  const std::int64_t offset = 5 * kMillisecond;
  return {.frame = frame,
          .boundary_ns = boundary,
          .woken_ns = boundary + 100,
          .read_ns = boundary + 300,
          .navigated_ns = boundary + 600,
          .ready_ns = boundary + 1000,
          .released_ns = boundary - 20 * kMillisecond + offset + released_late,
          .offset_ns = offset};
}

TEST(TimingCollector, StepsAreTheDifferencesOfThePoints) {
  TimingCollector<TimingPoints> collector;
  for (std::uint64_t k = 1; k <= 10; ++k) collector.add(points(k));
  const TimingStatistics& s = collector.statistics();
  EXPECT_EQ(s.frames, 10u);
  const std::int64_t expected[] = {100, 200, 300, 400, 1000, 30};
  for (std::size_t i = 0; i < kTimingStepCount; ++i) {
    EXPECT_EQ(s.series[i].min_ns, expected[i]) << kTimingSteps[i].name;
    EXPECT_EQ(s.series[i].max_ns, expected[i]) << kTimingSteps[i].name;
  }
  EXPECT_EQ(s.series[5].count, 9u) << "the release of a frame comes with the next one";
  EXPECT_EQ(s.until_ns - s.since_ns, 9 * 20 * kMillisecond);
  EXPECT_DOUBLE_EQ(s.margin_ns(1000), 5e6 - 1000);
}

TEST(TimingCollector, AHoleInTheFramesGivesNoRelease) {
  TimingCollector<TimingPoints> collector;
  collector.add(points(1));
  collector.add(points(5));
  EXPECT_EQ(collector.statistics().series[5].count, 0u);
}

TEST(TimingCollector, AResetForgetsFramesAndWhatWasMissedBefore) {
  TimingCollector<TimingPoints> collector;
  TimingPoints t = points(1);
  t.overruns = 7;
  collector.add(t);
  EXPECT_EQ(collector.statistics().overruns, 0u) << "counted from the first frame on";
  t = points(2);
  t.overruns = 9;
  collector.add(t);
  EXPECT_EQ(collector.statistics().overruns, 2u);
  collector.reset();
  EXPECT_EQ(collector.statistics().frames, 0u);
  t = points(3);
  t.overruns = 10;
  collector.add(t);
  EXPECT_EQ(collector.statistics().frames, 1u);
  EXPECT_EQ(collector.statistics().overruns, 1u);
}

}  // namespace
}  // namespace lss
