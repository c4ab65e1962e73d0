#include "daemon/runtime/progress.h"

#include <gtest/gtest.h>

#include "daemon/runtime/clock_step.h"

namespace lss {
namespace {

constexpr TimeNs kTenth = 100 * kMillisecond;

TEST(ProgressWatch, TellsAThreadThatStandsStillOnceAndThatItRunsAgain) {
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
  EXPECT_TRUE(watch.look(threads, now += kTenth).empty()) << "told once";
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

}  // namespace
}  // namespace lss
