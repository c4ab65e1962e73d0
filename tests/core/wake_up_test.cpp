#include "daemon/runtime/wake_up.h"

#include <gtest/gtest.h>

#include <thread>

#include "daemon/runtime/alarm.h"

namespace lss {
namespace {

// "At once" and "never" of a driver's schedule; their distance to any time is out of range.
constexpr TimeNs kAtOnce = INT64_MIN, kNever = INT64_MAX;

TEST(LeftUntil, IsNothingForTimesThatHavePassed) {
  EXPECT_EQ(left_until(kAtOnce), 0);
  EXPECT_EQ(left_until(0), 0);
  EXPECT_EQ(left_until(now_ns()), 0);
  EXPECT_GT(left_until(kNever), 1000 * kSecond);
}

TEST(WakeUp, ReturnsAtOnceFromATimeThatHasPassed) {
  WakeUp wake_up;
  wake_up.wait(kAtOnce);
  wake_up.wait(now_ns());
}

TEST(WakeUp, AWakeEndsAWaitWithoutLimit) {
  WakeUp wake_up;
  std::thread other([&] { wake_up.wake(); });
  wake_up.wait(kNever);
  other.join();
}

TEST(Alarm, ReturnsAtOnceFromATimeThatHasPassed) {
  Alarm alarm;
  for (const TimeNs spin_ns : {TimeNs{0}, kMillisecond}) {
    EXPECT_FALSE(alarm.wait(kAtOnce, spin_ns));
    EXPECT_FALSE(alarm.wait(now_ns(), spin_ns));
  }
}

TEST(Alarm, ARingEndsAWaitWithoutLimit) {
  Alarm alarm;
  alarm.ring();
  EXPECT_TRUE(alarm.wait(kNever, kMillisecond));
}

}  // namespace
}  // namespace lss
