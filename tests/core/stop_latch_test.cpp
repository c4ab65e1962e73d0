#include "daemon/runtime/stop_latch.h"

#include <gtest/gtest.h>

namespace lss {
namespace {

constexpr TimeNs kFrame = 200 * kMillisecond;

class StopLatchAsked : public testing::Test {
 protected:
  StopLatchAsked() {
    latch.ask(kFrame + 1);
    latch.fell();
  }
  StopLatch latch;
};

TEST(StopLatch, OrdersPassUntilSomebodyAsks) {
  StopLatch latch;
  EXPECT_FALSE(latch.fell());
  EXPECT_TRUE(latch.passes(false, kFrame));
  latch.ask(kFrame + 1);
  EXPECT_TRUE(latch.fell());
  EXPECT_FALSE(latch.fell()) << "once for every request";
  EXPECT_TRUE(latch.pending());
  EXPECT_FALSE(latch.passes(false, kFrame)) << "computed before it";
  EXPECT_FALSE(latch.passes(false, 2 * kFrame)) << "the cycle has not heard of it yet";
}

TEST_F(StopLatchAsked, TheCycleConfirmsByOrdersThatStopAll) {
  EXPECT_TRUE(latch.passes(true, 2 * kFrame));
  EXPECT_FALSE(latch.pending());
  EXPECT_TRUE(latch.passes(false, 3 * kFrame));
}

TEST_F(StopLatchAsked, OrdersThatStoppedAllForAnotherReasonBeforeDoNotConfirm) {
  EXPECT_TRUE(latch.passes(true, kFrame)) << "to stop is always right";
  EXPECT_TRUE(latch.pending());
  EXPECT_FALSE(latch.passes(false, 2 * kFrame));
}

TEST_F(StopLatchAsked, AskedAgainItHasToBeConfirmedAgain) {
  latch.passes(true, 2 * kFrame);
  latch.ask(2 * kFrame + 1);
  EXPECT_TRUE(latch.fell());
  EXPECT_FALSE(latch.passes(false, 3 * kFrame));
}

}  // namespace
}  // namespace lss
