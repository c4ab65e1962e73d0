#include "daemon/runtime/frame_clock.h"

#include <gtest/gtest.h>
#include <rapidcheck.h>

namespace lss {
namespace {

TEST(FrameClock, BoundariesAndReleasesLieOnTheGrid) {
  const FrameClock clock(1000, 20 * kMillisecond, 5 * kMillisecond);
  EXPECT_EQ(clock.boundary(0), 1000);
  EXPECT_EQ(clock.boundary(3), 1000 + 60 * kMillisecond);
  EXPECT_EQ(clock.release(3), 1000 + 65 * kMillisecond);
}

TEST(FrameClock, AFrameInTimeIsFollowedByTheNext) {
  const FrameClock clock(0, 100, 10);
  EXPECT_EQ(clock.after(7, 750), 8u);
  EXPECT_EQ(clock.after(7, 800), 8u);
}

TEST(FrameClock, AnOverrunSkipsFramesAndKeepsThePhase) {
  const FrameClock clock(0, 100, 10);
  EXPECT_EQ(clock.after(7, 801), 9u);
  EXPECT_EQ(clock.after(7, 1250), 13u);
  EXPECT_EQ(clock.boundary(13) % 100, 0);
}

TEST(FrameClock, TheNextFrameIsNeverInThePastNorMoreThanOnePeriodAhead) {
  EXPECT_TRUE(rc::check([](std::uint16_t frame, std::uint32_t late) {
    const FrameClock clock(12345, 1000, 10);
    const TimeNs now = clock.boundary(frame) + late % 100'000;
    const std::uint64_t next = clock.after(frame, now);
    RC_ASSERT(next > frame);
    RC_ASSERT(clock.boundary(next) >= now);
    RC_ASSERT(next == frame + 1u || clock.boundary(next) - now < 1000);
  }));
}

TEST(OverrunCounter, ReachesItsLimitOnlyByOverrunsInARow) {
  OverrunCounter counter(3);
  EXPECT_FALSE(counter.late());
  EXPECT_FALSE(counter.late());
  counter.in_time();
  EXPECT_FALSE(counter.late());
  EXPECT_FALSE(counter.late());
  EXPECT_TRUE(counter.late());
  EXPECT_EQ(counter.total(), 5u);
}

}  // namespace
}  // namespace lss
