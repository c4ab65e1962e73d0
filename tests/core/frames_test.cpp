#include "daemon/runtime/frames.h"

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <chrono>
#include <cstdint>
#include <future>
#include <span>
#include <thread>
#include <vector>

namespace lss {
namespace {

constexpr TimeNs kPeriod = 200 * kMillisecond;
constexpr TimeNs kGrace = 15 * kMillisecond;
constexpr SensorFramesParameters kSensor{.packets = 40, .period_ns = kPeriod, .grace_ns = kGrace};
constexpr TimeNs kEpoch = 1000 * kSecond;

class SensorGridTest : public testing::Test {
 protected:
  // After a period the packet of this frame, after several that of another one.
  bool arrive(std::uint64_t first, std::uint64_t second, int periods) {
    return grid.arrived(first, kEpoch + kPeriod, b) &&
           grid.arrived(second, kEpoch + periods * kPeriod, b);
  }
  SensorGrid grid{kSensor, kEpoch};
  Boundary b;
};

TEST_F(SensorGridTest, FramesBeginWhenTheLastPacketOfABatchArrives) {
  ASSERT_TRUE(grid.arrived(1, kEpoch + kPeriod + 300, b));
  EXPECT_EQ(b.frame, 1u);
  EXPECT_EQ(b.time_ns, kEpoch + kPeriod + 300);
  EXPECT_FALSE(b.held);
  ASSERT_TRUE(grid.arrived(2, kEpoch + 2 * kPeriod - 700, b));
  EXPECT_EQ(b.frame, 2u);
  EXPECT_EQ(b.time_ns, kEpoch + 2 * kPeriod - 700);
  EXPECT_EQ(b.skipped, 0u);
}

TEST_F(SensorGridTest, BoundariesThatWereWorkedThroughAreSkippedFrames) {
  ASSERT_TRUE(arrive(1, 4, 4));
  EXPECT_EQ(b.frame, 4u);
  EXPECT_EQ(b.skipped, 2u);
}

TEST_F(SensorGridTest, ASilentSensorIsReplacedByTheClockInTheRhythmLastSeen) {
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

TEST_F(SensorGridTest, ASensorThatWasNeverHeardDoesNotKeepFramesFromBeginning) {
  grid.held(grid.deadline(), b);
  EXPECT_EQ(b.frame, 1u);
  EXPECT_TRUE(b.held);
}

TEST_F(SensorGridTest, AStandstillWhileTheSensorIsSilentSkipsFramesAndKeepsTheirPhase) {
  grid.held(grid.deadline(), b);
  const TimeNs phase = b.time_ns;
  grid.held(phase + 5 * kPeriod + 7, b);
  EXPECT_EQ(b.time_ns, phase + 5 * kPeriod);
  EXPECT_EQ(b.skipped, 4u);
  EXPECT_EQ(b.frame, 6u);
}

TEST_F(SensorGridTest, ABatchThatComesRightAfterAFrameByTheClockIsLeftToTheNext) {
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

TEST_F(SensorGridTest, ADriverThatBeginsToCountAgainHasNotLostFrames) {
  ASSERT_TRUE(arrive(7, 1, 2));
  EXPECT_EQ(b.frame, 2u);
  EXPECT_EQ(b.skipped, 0u);
}

// Counted by the sensor's own numbers: the frame ends with the first packet that is not lost of
// number 40 n or later.
TEST(SensorGrid, LostPacketsNeverShiftTheFramesAfterThem) {
  EXPECT_TRUE(rc::check([](const std::vector<std::uint8_t>& luck) {
    constexpr TimeNs kPacket = kPeriod / 40;
    SensorGrid grid(kSensor, kEpoch);
    Boundary b;
    std::uint64_t frame = 0, ended = 0;
    for (std::uint64_t number = 1; number <= 40 * 20; ++number) {
      const TimeNs arrival = kEpoch + static_cast<TimeNs>(number) * kPacket;
      const bool lost = number < luck.size() * 8 && (luck[number / 8] >> number % 8 & 1) != 0;
      while (grid.deadline() < arrival) {
        grid.held(grid.deadline(), b);
        frame = b.frame;
      }
      if (lost || number / 40 == ended) continue;
      ended = number / 40;
      if (!grid.arrived(ended, arrival, b)) continue;
      RC_ASSERT(b.frame == frame + 1 + b.skipped);
      frame = b.frame;
      const TimeNs late = b.time_ns - kEpoch - static_cast<TimeNs>(ended) * kPeriod;
      RC_ASSERT(late >= 0);
      RC_ASSERT(late <= kGrace || number < luck.size() * 8);
      if (number >= luck.size() * 8 + 80) RC_ASSERT(late == 0);
    }
    RC_ASSERT(frame == 20u);
  }));
}

// As in the follower: a frame later than the deadline begins by the clock.
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

// In any sequence: frame numbers increase by one plus the skipped frames, and their boundaries
// never go back or crowd.
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

// By the real clock: never early, on the grid, and missed frames are skipped.
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

// Notes when it is run.
struct Edges {
  std::vector<TimeNs> due{};
  std::vector<TimeNs> run_ns{};
  TimeNs next_wake() const { return run_ns.size() < due.size() ? due[run_ns.size()] : INT64_MAX; }
  void run(TimeNs now) {
    while (next_wake() <= now) run_ns.push_back(now);
  }
};

struct Followed {
  explicit Followed(TimeNs period, TimeNs spin = 0)
      : frames({.packets = 40, .period_ns = period, .grace_ns = kMillisecond}),
        frame(frames.follow_frame(0)),
        actuate(frames.follow_actuate(spin)) {}
  // The frame thread's turn.
  TimeNs begin(std::uint64_t index) {
    frames.announce(index, now_ns());
    return frame.next(0).time_ns;
  }
  SensorFrames frames;
  SensorFrames::FrameFollower frame;
  SensorFrames::ActuateFollower actuate;
};

TEST(ActuateFollower, DoesItsWorkOnTimeAndTheReleaseGoesFirst) {
  for (const TimeNs spin : {TimeNs{0}, 200 * kMicrosecond}) {
    Followed f(kSecond, spin);
    const TimeNs begun = f.begin(1);
    Edges edges;
    for (int i = 1; i <= 4; ++i) edges.due.push_back(begun + i * kMillisecond);
    EXPECT_EQ(f.actuate.next(3 * kMillisecond, edges).time_ns, begun);
    EXPECT_GE(now_ns(), begun + 3 * kMillisecond);
    // the third is due with the release, which goes first; a machine that was late with the second
    // by as much ran it then
    ASSERT_GE(edges.run_ns.size(), 2u);
    ASSERT_TRUE(edges.run_ns.size() == 2 || edges.run_ns[1] >= edges.due[2]);
    const TimeNs second = f.begin(2);
    EXPECT_EQ(f.actuate.next(5 * kMillisecond, edges).time_ns, second);
    ASSERT_EQ(edges.run_ns.size(), 4u);
    for (std::size_t i = 0; i < 4; ++i) EXPECT_GE(edges.run_ns[i], edges.due[i]) << i;
  }
}

TEST(ActuateFollower, DoesItsWorkWhileNoFrameBegins) {
  Followed f(4 * kMillisecond);
  const TimeNs begun = f.begin(1);
  Edges edges{.due = {begun + 2 * kMillisecond, begun + 3 * kMillisecond}};
  EXPECT_EQ(f.actuate.next(kMillisecond, edges).time_ns, begun);
  EXPECT_TRUE(edges.run_ns.empty());
  const Boundary given_up = f.actuate.next(kMillisecond, edges);
  EXPECT_TRUE(given_up.held);
  EXPECT_EQ(given_up.frame, 2u);
  EXPECT_EQ(given_up.time_ns, begun + 4 * kMillisecond);
  EXPECT_EQ(edges.run_ns.size(), 2u);
  // Begun after all, too late: not once more.
  f.frames.announce(2, given_up.time_ns);
  f.frame.next(0);
  const TimeNs third = f.begin(3);
  EXPECT_EQ(f.actuate.next(0, edges).time_ns, third);
}

TEST(ActuateFollower, AFollowerThatSkippedFramesThatNeverCameFollowsTheNextOne) {
  Followed f(4 * kMillisecond);
  f.frames.start(now_ns() - kSecond);
  auto actuate = f.frames.follow_actuate(0);
  Boundary b;
  while (b.frame < 20) b = actuate.next(0);
  const TimeNs begun = f.begin(1);
  b = actuate.next(kMillisecond);
  EXPECT_EQ(b.time_ns, begun);
  EXPECT_EQ(b.frame, 1u);
  EXPECT_EQ(b.skipped, 0u);
}

TEST(ActuateFollower, AWakeUpBeginsTheWorkAtOnce) {
  struct Rung {
    std::atomic<bool> asked{false};
    std::promise<void> done{};
    TimeNs next_wake() const { return INT64_MAX; }
    void run(TimeNs) {
      if (asked.exchange(false)) done.set_value();
    }
  } work;
  Followed f(1000 * kSecond);
  std::thread actuate([&] { EXPECT_EQ(f.actuate.next(0, work).frame, 1u); });
  work.asked = true;
  f.frames.wake_actuate();
  EXPECT_EQ(work.done.get_future().wait_for(std::chrono::seconds(30)), std::future_status::ready);
  f.begin(1);
  actuate.join();
}

class FlippedFrames : public testing::Test {
 protected:
  // The next frame of the sensor; never waits.
  Boundary next(std::uint64_t index) {
    f.frames.announce(index, begun_ns + static_cast<TimeNs>(index - 1) * kPeriod);
    f.frames.stop();
    return f.frame.next(0);
  }
  std::span<std::uint8_t> memory() {  // behind the reference
    return std::span<std::uint8_t>(bytes_of(f.frame)).subspan(sizeof(void*));
  }
  Followed f{kPeriod};
  TimeNs begun_ns = f.begin(1);
};

TEST_F(FlippedFrames, EachBitThatFlipsWhileTheThreadWaitsIsCorrected) {
  std::uint64_t index = 1;
  for (std::size_t bit = 0; bit < 8 * memory().size(); ++bit) {
    memory()[bit / 8] ^= static_cast<std::uint8_t>(1u << bit % 8);
    const Boundary b = next(++index);
    ASSERT_EQ(b.frame, index) << bit;
    ASSERT_EQ(b.time_ns, begun_ns + static_cast<TimeNs>(index - 1) * kPeriod) << bit;
    ASSERT_EQ(b.skipped, 0u) << bit;
    ASSERT_FALSE(f.frames.take_memory_lost()) << bit;
  }
}

TEST_F(FlippedFrames, BothCopiesDamagedAreReportedAndFramesCountOn) {
  const auto period = std::bit_cast<std::array<std::uint8_t, sizeof(TimeNs)>>(kPeriod);
  std::uint8_t flips = 0x40;
  for (auto rest = memory(); !rest.empty(); rest = rest.subspan(1)) {
    if (rest.size() < period.size() || !std::ranges::equal(rest.first(period.size()), period))
      continue;
    rest[7] ^= flips;
    flips >>= 1;
  }
  ASSERT_EQ(flips, 0x10);
  begun_ns = now_ns() - kPeriod;
  EXPECT_EQ(next(2).frame, 2u);
  EXPECT_TRUE(f.frames.take_memory_lost());
  EXPECT_FALSE(f.frames.take_memory_lost());
  EXPECT_EQ(next(3).frame, 3u);
}

TEST(SensorFrames, AStopEndsAllWaits) {
  SensorFrames frames({.packets = 40, .period_ns = kSecond, .grace_ns = 1000 * kSecond});
  auto frame = std::async(std::launch::async, [&] { frames.follow_frame(0).next(0); });
  auto actuate = std::async(std::launch::async, [&] { frames.follow_actuate(0).next(0); });
  frames.stop();
  EXPECT_EQ(frame.wait_for(std::chrono::seconds(30)), std::future_status::ready);
  EXPECT_EQ(actuate.wait_for(std::chrono::seconds(30)), std::future_status::ready);
}

}  // namespace
}  // namespace lss
