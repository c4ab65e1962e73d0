#include "daemon/core/frames.h"

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <algorithm>
#include <atomic>
#include <thread>
#include <vector>

namespace lss {
namespace {

constexpr TimeNs kPeriod = 200 * kMillisecond;
constexpr TimeNs kGrace = 15 * kMillisecond;
constexpr SensorFramesParameters kSensor{.packets = 40, .period_ns = kPeriod, .grace_ns = kGrace};
constexpr TimeNs kEpoch = 1000 * kSecond;

TEST(SensorGrid, FramesBeginWhenTheLastPacketOfABatchArrives) {
  SensorGrid grid(kSensor, kEpoch);
  Boundary b;
  ASSERT_TRUE(grid.arrived(1, kEpoch + kPeriod + 300, b));
  EXPECT_EQ(b.frame, 1u);
  EXPECT_EQ(b.time_ns, kEpoch + kPeriod + 300);
  EXPECT_FALSE(b.held);
  ASSERT_TRUE(grid.arrived(2, kEpoch + 2 * kPeriod - 700, b));
  EXPECT_EQ(b.frame, 2u);
  EXPECT_EQ(b.time_ns, kEpoch + 2 * kPeriod - 700);
  EXPECT_EQ(b.skipped, 0u);
}

TEST(SensorGrid, BoundariesThatWereWorkedThroughAreSkippedFrames) {
  SensorGrid grid(kSensor, kEpoch);
  Boundary b;
  ASSERT_TRUE(grid.arrived(1, kEpoch + kPeriod, b));
  ASSERT_TRUE(grid.arrived(4, kEpoch + 4 * kPeriod, b));
  EXPECT_EQ(b.frame, 4u);
  EXPECT_EQ(b.skipped, 2u);
}

TEST(SensorGrid, ASilentSensorIsReplacedByTheClockInTheRhythmLastSeen) {
  SensorGrid grid(kSensor, kEpoch);
  Boundary b;
  ASSERT_TRUE(grid.arrived(1, kEpoch + kPeriod, b));
  EXPECT_EQ(grid.deadline(), kEpoch + 2 * kPeriod + kGrace);
  grid.held(grid.deadline() + 5, b);
  EXPECT_TRUE(b.held);
  EXPECT_EQ(b.frame, 2u);
  EXPECT_EQ(b.time_ns, kEpoch + 2 * kPeriod + kGrace);
  grid.held(grid.deadline(), b);
  EXPECT_EQ(b.time_ns, kEpoch + 3 * kPeriod + kGrace);
  EXPECT_EQ(b.skipped, 0u);
}

TEST(SensorGrid, ASensorThatWasNeverHeardDoesNotKeepFramesFromBeginning) {
  SensorGrid grid(kSensor, kEpoch);
  Boundary b;
  grid.held(grid.deadline(), b);
  EXPECT_EQ(b.frame, 1u);
  EXPECT_TRUE(b.held);
}

TEST(SensorGrid, AStandstillWhileTheSensorIsSilentSkipsFramesAndKeepsTheirPhase) {
  SensorGrid grid(kSensor, kEpoch);
  Boundary b;
  grid.held(grid.deadline(), b);
  const TimeNs phase = b.time_ns;
  grid.held(phase + 5 * kPeriod + 7, b);
  EXPECT_EQ(b.time_ns, phase + 5 * kPeriod);
  EXPECT_EQ(b.skipped, 4u);
  EXPECT_EQ(b.frame, 6u);
}

TEST(SensorGrid, ABatchThatComesRightAfterAFrameByTheClockIsLeftToTheNext) {
  SensorGrid grid(kSensor, kEpoch);
  Boundary b;
  ASSERT_TRUE(grid.arrived(1, kEpoch + kPeriod, b));
  grid.held(grid.deadline(), b);
  const TimeNs arrival = b.time_ns + kMillisecond;
  EXPECT_FALSE(grid.arrived(2, arrival, b));
  EXPECT_EQ(grid.deadline(), arrival + kPeriod + kGrace) << "the next one is waited for";
  ASSERT_TRUE(grid.arrived(3, arrival + kPeriod, b));
  EXPECT_EQ(b.frame, 3u);
  EXPECT_EQ(b.skipped, 0u);
  EXPECT_FALSE(b.held);
}

// As the follower does it: what is later than the deadline begins by the clock.
TEST(SensorGrid, AfterABatchThatWasLateFramesAreTheSensorsAgain) {
  EXPECT_TRUE(rc::check([] {
    const TimeNs late = *rc::gen::inRange<TimeNs>(0, 3 * kPeriod);
    SensorGrid grid(kSensor, kEpoch);
    Boundary b;
    std::uint64_t held_at_the_end = 0;
    for (std::uint64_t index = 1; index <= 30; ++index) {
      const TimeNs arrival =
          kEpoch + static_cast<TimeNs>(index) * kPeriod + (index >= 10 ? late : 0);
      while (grid.deadline() < arrival) {
        grid.held(grid.deadline(), b);
        if (index > 12) ++held_at_the_end;
      }
      const bool begun = grid.arrived(index, arrival, b);
      if (index > 12) RC_ASSERT(begun);
    }
    RC_ASSERT(held_at_the_end == 0u);
  }));
}

// Whatever comes when: frames count up by one and what was skipped, and their boundaries never go
// back or crowd.
TEST(SensorGrid, FramesCountUpAndAreAtLeastHalfAPeriodApart) {
  EXPECT_TRUE(rc::check([](const std::vector<std::uint32_t>& gaps) {
    SensorGrid grid(kSensor, kEpoch);
    Boundary b;
    TimeNs now = kEpoch;
    std::uint64_t index = 0, frame = 0;
    TimeNs before = 0;
    for (const std::uint32_t gap : gaps) {
      const TimeNs arrives = now + gap % (3 * kPeriod);
      while (grid.deadline() < arrives) {
        grid.held(grid.deadline(), b);
        RC_ASSERT(b.frame == frame + b.skipped + 1);
        RC_ASSERT(b.time_ns - before >= kPeriod / 2);
        frame = b.frame;
        before = b.time_ns;
      }
      if (grid.arrived(++index, arrives, b)) {
        RC_ASSERT(b.frame == frame + b.skipped + 1);
        RC_ASSERT(before == 0 || b.time_ns - before >= kPeriod / 2);
        frame = b.frame;
        before = b.time_ns;
      }
      now = arrives;
    }
  }));
}

// By the real clock: never early, on the grid, and what was slept through is skipped.
TEST(ClockFrames, AFollowerReturnsOnTheGridAndNeverEarly) {
  for (const TimeNs spin : {TimeNs{0}, 200 * kMicrosecond}) {
    const FrameClock clock(now_ns(), kMillisecond, 0);
    const ClockFrames frames(clock);
    auto follower = frames.follow_actuate(spin);
    constexpr TimeNs kLag = 300 * kMicrosecond;
    std::uint64_t before = 0;
    for (int i = 0; i < 20; ++i) {
      const Boundary b = follower.next(kLag);
      EXPECT_GE(now_ns(), b.time_ns + kLag);
      EXPECT_EQ(b.time_ns, clock.boundary(b.frame));
      EXPECT_TRUE(before == 0 || b.frame == before + b.skipped + 1);
      before = b.frame;
      if (i == 10) sleep_until(now_ns() + 5 * kMillisecond);
      EXPECT_TRUE(i != 11 || b.skipped >= 4);
    }
  }
}

// Real threads: both follow the boundaries that packets made. The grace is endless, so that no
// delay of the machine makes a frame by the clock.
TEST(SensorFrames, BothThreadsFollowThePackets) {
  constexpr std::uint64_t kFrames = 50;
  SensorFrames frames({.packets = 4, .period_ns = kMillisecond, .grace_ns = 1000 * kSecond});
  std::atomic<std::uint64_t> computed{0};
  std::vector<TimeNs> announced, begun, released;
  std::thread frame([&] {
    auto follower = frames.follow_frame(0);
    for (std::uint64_t k = 1; k <= kFrames; ++k) {
      begun.push_back(follower.next(0).time_ns);
      computed = k;
      computed.notify_one();
    }
  });
  std::thread actuate([&] {
    auto follower = frames.follow_actuate(0);
    for (Boundary b; b.frame < kFrames;) {
      b = follower.next(1);
      EXPECT_GE(now_ns(), b.time_ns + 1);
      released.push_back(b.time_ns);
    }
  });
  TimeNs arrival = 0;
  for (std::uint64_t k = 1; k <= kFrames; ++k) {
    arrival = std::max(now_ns(), arrival + kMillisecond);
    for (int i = 0; i < 4; ++i) frames.packet(arrival);
    announced.push_back(arrival);
    for (std::uint64_t seen = computed; seen < k; seen = computed) computed.wait(seen);
  }
  frame.join();
  actuate.join();
  EXPECT_EQ(begun, announced);
  ASSERT_FALSE(released.empty());
  EXPECT_EQ(released.back(), announced.back());
  for (const TimeNs time : released) EXPECT_NE(std::ranges::find(announced, time), announced.end());
}

}  // namespace
}  // namespace lss
