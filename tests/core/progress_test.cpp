#include "daemon/runtime/progress.h"

#include <gtest/gtest.h>

#include "daemon/runtime/clock_step.h"
#include "daemon/runtime/expiry_watch.h"

namespace lss {
namespace {

constexpr TimeNs kTenth = 100 * kMillisecond;

TEST(ProgressWatch, ReportsAThreadThatStandsStillOnceAndThatItRunsAgain) {
  ProgressWatch watch(kSecond);
  std::vector<Progress> threads{{"frame", 1}, {"publish", 1}};
  TimeNs now = 5 * kSecond;
  EXPECT_TRUE(watch.look(threads, now).empty());
  for (int i = 0; i < 9; ++i) {
    ++threads[0].turns;
    EXPECT_TRUE(watch.look(threads, now += kTenth).empty());
  }
  ++threads[0].turns;
  auto changes = watch.look(threads, now += kTenth);
  ASSERT_EQ(changes.size(), 1u);
  EXPECT_EQ(changes[0].thread, "publish");
  EXPECT_TRUE(changes[0].stuck);
  EXPECT_EQ(changes[0].still_ns, kSecond);
  EXPECT_FALSE(watch.stuck(0));
  EXPECT_TRUE(watch.stuck(1));

  ++threads[0].turns;
  EXPECT_TRUE(watch.look(threads, now += kTenth).empty()) << "reported once";
  ++threads[0].turns;
  ++threads[1].turns;
  changes = watch.look(threads, now += kTenth);
  ASSERT_EQ(changes.size(), 1u);
  EXPECT_FALSE(changes[0].stuck);
  EXPECT_EQ(changes[0].still_ns, kSecond + 2 * kTenth);
  EXPECT_FALSE(watch.stuck(1));
}

TEST(ProgressWatch, ABusWithoutOrdersBringsNoMeasurementsWhileItStandsStill) {
  ProgressWatch watch(kSecond);
  const std::vector<Progress> threads{{"bus/can", 1}, {"bus/imu", 1, false}};
  watch.look(threads, kSecond);
  const auto changes = watch.look(threads, 3 * kSecond);
  ASSERT_EQ(changes.size(), 2u);
  EXPECT_STREQ(ProgressWatch::effect(changes[0]), "no orders reach the modules");
  EXPECT_STREQ(ProgressWatch::effect(changes[1]), "it brings no measurements");
}

TEST(ProgressWatch, AStuckFrameAndAStuckBusAreReportedApart) {
  ProgressWatch watch(kSecond);
  std::vector<Progress> threads{{"frame", 1}, {"bus/legs", 1}};
  watch.look(threads, kSecond);
  threads[1].turns = 2;
  EXPECT_EQ(watch.look(threads, 2 * kSecond)[0].thread, "frame");
  threads[0].turns = 2;
  const auto changes = watch.look(threads, 3 * kSecond);
  ASSERT_EQ(changes.size(), 2u);
  EXPECT_EQ(changes[0].thread, "frame");
  EXPECT_FALSE(changes[0].stuck);
  EXPECT_EQ(changes[1].thread, "bus/legs");
  EXPECT_TRUE(changes[1].stuck);
}

TEST(ClockStep, ASetClockIsReportedOnceAndASlewedOneIsFollowed) {
  ClockStep clock;
  EXPECT_EQ(clock.look(kSecond, 100 * kSecond), 0) << "the first look";
  EXPECT_EQ(clock.look(2 * kSecond, 101 * kSecond), 0);
  EXPECT_EQ(clock.look(3 * kSecond, 162 * kSecond), 60 * kSecond);
  EXPECT_EQ(clock.look(4 * kSecond, 163 * kSecond), 0);
  EXPECT_EQ(clock.look(5 * kSecond, 104 * kSecond), -60 * kSecond);
  TimeNs utc = 104 * kSecond;
  for (int i = 6; i < 1000; ++i)
    EXPECT_EQ(clock.look(i * kSecond, utc += kSecond + ClockStep::kLimit / 2), 0);
}

TEST(ExpiryWatch, TheExpiryIsReportedOnceADayFrom30DaysBeforeAndWhenItHasHappened) {
  constexpr std::int64_t kDay = ExpiryWatch::kDay_s, kEnd = 400 * kDay + kDay / 2;
  ExpiryWatch watch(kEnd);
  std::vector<std::int64_t> told;
  for (std::int64_t utc = 0; utc < 402 * kDay; utc += 600) {
    if (const auto left = watch.look(utc)) told.push_back(*left);
  }
  ASSERT_EQ(told.size(), 32u);
  EXPECT_EQ(told.front(), 30 * kDay - 600);
  for (std::size_t i = 1; i < 30; ++i) EXPECT_EQ(told[i], told[i - 1] - kDay);
  EXPECT_EQ(told[30], -600);
  EXPECT_EQ(told[31], -600 - kDay);
  ExpiryWatch late(kEnd);
  EXPECT_EQ(late.look(kEnd - 3600), 3600);
  EXPECT_EQ(late.look(kEnd), std::nullopt);
  EXPECT_EQ(late.look(kEnd + 1), -1) << "at once";
  EXPECT_EQ(late.look(kEnd + 2), std::nullopt);
}

TEST(ExpiryWatch, AClockThatIsSetReportsItAgainAndWithoutACertificateNothingIsReported) {
  constexpr std::int64_t kDay = ExpiryWatch::kDay_s;
  ExpiryWatch watch(100 * kDay);
  EXPECT_EQ(watch.look(99 * kDay), kDay);
  EXPECT_EQ(watch.look(99 * kDay - 5), std::nullopt) << "slewed";
  EXPECT_EQ(watch.look(90 * kDay), 10 * kDay);
  EXPECT_EQ(watch.look(200 * kDay), -100 * kDay);
  EXPECT_EQ(watch.look(200 * kDay + 1), std::nullopt);
  EXPECT_EQ(ExpiryWatch().look(INT64_MAX / 2), std::nullopt);
}

}  // namespace
}  // namespace lss
