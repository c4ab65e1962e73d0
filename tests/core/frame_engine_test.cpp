#include "daemon/runtime/frame_engine.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <thread>
#include <utility>
#include <vector>

#include "drivers/lockstep/lockstep.h"
#include "tests/support/copies.h"

namespace lss {
namespace {

constexpr TimeNs kPeriod = 20 * kMillisecond;

// Steps both threads of an engine by hand, in any order.
struct Stage {
  ClockFrames frames{FrameClock(0, kPeriod, 5 * kMillisecond)};
  FrameEngine<ClockFrames, int> engine{frames,
                                       {.period_ns = kPeriod, .max_consecutive_overruns = 3}};
  TimeNs start_ns = now_ns();
  TimingPoints timing{};
  Released seen{};
  std::vector<int> sent;

  Boundary boundary(std::uint64_t frame, std::uint64_t skipped = 0) const {
    return {frame, start_ns + static_cast<TimeNs>(frame) * kPeriod, skipped, false};
  }
  void compute(std::uint64_t frame, std::uint64_t skipped = 0) {
    engine.begin(
        boundary(frame, skipped),
        [&](const Boundary& b, const Released& released, TimingPoints&) {
          seen = released;
          return static_cast<int>(b.frame) * 10;
        },
        [&](const TimingPoints& t) { timing = t; });
  }
  void release(std::uint64_t frame, std::uint64_t skipped = 0) {
    engine.due(boundary(frame, skipped), [&](int command) { sent.push_back(command); });
  }
};

TEST(FrameEngine, ReleasesTheCommandOfItsFrame) {
  Stage s;
  for (std::uint64_t k = 1; k <= 3; ++k) {
    s.compute(k);
    s.release(k);
  }
  EXPECT_EQ(s.sent, (std::vector{10, 20, 30}));
  s.compute(4);
  EXPECT_EQ(s.seen.overruns, 0u);
  EXPECT_FALSE(s.seen.limit);
  EXPECT_GE(s.timing.released_ns, s.start_ns);
  EXPECT_EQ(s.engine.frames(), 4u);
}

TEST(FrameEngine, ALateCommandIsRepeatedOnceAndThenNothingIsReleased) {
  Stage s;
  s.compute(1);
  s.release(1);
  s.release(2);
  s.release(3);
  EXPECT_EQ(s.sent, (std::vector{10, 10}));
  s.compute(3);
  EXPECT_EQ(s.timing.overruns, 2u);
  EXPECT_EQ(s.timing.commands_repeated, 1u);
  s.compute(4);
  s.release(4);
  EXPECT_EQ(s.sent, (std::vector{10, 10, 40}));
}

TEST(FrameEngine, TheReleaseGetsTheNumberOfItsFrame) {
  Stage s;
  std::vector<std::pair<int, std::uint64_t>> sent;
  const auto release = [&](int command, const Boundary& b) { sent.emplace_back(command, b.frame); };
  s.compute(1);
  s.engine.due(s.boundary(1), release);
  s.engine.due(s.boundary(2), release);
  EXPECT_EQ(sent, (std::vector<std::pair<int, std::uint64_t>>{{10, 1}, {10, 2}}));
}

TEST(FrameEngine, ACommandThatCameTooLateIsNotReleasedAsTheNextOne) {
  Stage s;
  s.compute(1);
  s.release(1);
  s.release(2);  // repeats
  s.compute(2);
  s.release(3);  // of frame 2 there is a command now, of frame 3 there is none
  EXPECT_EQ(s.sent, (std::vector{10, 10}));
}

// Radiation, while a command waits for its release.
TEST(FrameEngine, AFlippedBitOfAWaitingCommandIsCorrectedAndTwoReleaseNothing) {
  constexpr std::uint64_t kFrame = 12'345'679;
  constexpr int kCommand = 10 * static_cast<int>(kFrame);
  for (const std::size_t damaged : {0u, 1u, 2u}) {
    Stage s;
    s.compute(kFrame);
    const auto copies = testing_support::copies_of(kCommand, bytes_of(s.engine));
    ASSERT_EQ(copies.size(), 2u);
    testing_support::damage(copies, damaged);
    s.release(kFrame);
    const bool corrected = damaged != 2;
    EXPECT_EQ(s.sent, corrected ? std::vector{kCommand} : std::vector<int>{}) << damaged;
    s.compute(kFrame + 1);
    EXPECT_EQ(s.timing.overruns, corrected ? 0u : 1u);
  }
}

TEST(FrameEngine, NothingIsReleasedBeforeTheFirstCommand) {
  Stage s;
  s.release(1);
  EXPECT_TRUE(s.sent.empty());
}

TEST(FrameEngine, OverrunsInARowReachTheLimitAndOneInTimeEndsTheRow) {
  Stage s;
  s.compute(1);
  s.release(1);
  s.release(2);
  s.release(3);
  s.compute(3);
  EXPECT_FALSE(s.seen.limit);
  s.release(4);
  s.compute(4);
  EXPECT_TRUE(s.seen.limit);
  s.compute(5);
  s.release(5);
  s.compute(6);
  EXPECT_FALSE(s.seen.limit);
}

TEST(FrameEngine, ALimitThatWasReachedBetweenTwoFramesIsNotForgotten) {
  Stage s;
  s.compute(1);
  s.release(1);
  s.compute(12, 10);
  s.release(12, 10);  // in time after a standstill: the limit
  s.release(13);      // another report before the frame thread looks again
  s.compute(14);
  EXPECT_TRUE(s.seen.limit);
  s.release(14);
  s.compute(15);
  EXPECT_FALSE(s.seen.limit) << "reported once";
}

TEST(FrameEngine, ThreadsRunUntilTheyAreStopped) {
  ClockFrames frames{FrameClock(now_ns(), kMillisecond, 0)};
  FrameEngine<ClockFrames, int> engine{
      frames, {.period_ns = kMillisecond, .offset_ns = 500 * kMicrosecond}};
  std::atomic<int> released{0};
  std::thread actuate([&] { engine.actuate([&](int) { ++released; }); });
  std::thread frame([&] {
    engine.frame([](const Boundary&, const Released&, TimingPoints&) { return 1; },
                 [&](const TimingPoints& t) {
                   if (t.frame >= 20 && released > 0) engine.stop();
                 });
  });
  frame.join();
  actuate.join();
  EXPECT_GT(engine.frames(), 0u);
  EXPECT_GT(engine.releases(), 0u);
}

// Frames by the sensor, edges between their releases: nothing is early, and all in order.
struct Work {
  TimeNs due_ns = INT64_MAX;
  int edges = 0, early = 0;
  TimeNs next_wake() const noexcept { return due_ns; }
  void run(TimeNs now) noexcept {
    if (now < due_ns) return;
    due_ns = INT64_MAX;
    ++edges;
  }
};

// In simulated time, which no machine is too slow for. 0: all was as it should be.
int work_between_releases() {
  constexpr TimeNs kStep = kMillisecond;
  char folder[] = "/tmp/frame-engine-XXXXXX";
  if (::mkdtemp(folder) == nullptr || !lockstep::create(folder, {.speed = 0}).empty()) return 1;
  Work work;
  SensorFrames frames({.packets = 1, .period_ns = 4 * kStep, .grace_ns = kStep});
  FrameEngine<SensorFrames, int> engine(frames, {.period_ns = 4 * kStep, .offset_ns = 2 * kStep});
  int releases = 0;
  std::thread actuate([&] {
    const lockstep::Part part("actuate");
    engine.actuate(
        [&](int, const Boundary& b) {
          if (now_ns() != b.time_ns + 2 * kStep) ++work.early;
          work.due_ns = now_ns() + kStep;
          ++releases;
        },
        work);
  });
  std::thread frame([&] {
    const lockstep::Part part("frame");
    engine.frame([](const Boundary&, const Released&, TimingPoints&) { return 1; },
                 [&](const TimingPoints& t) {
                   if (t.frame >= 20) engine.stop();
                 });
  });
  const bool begun = lockstep::begin(2);
  frame.join();
  actuate.join();
  std::filesystem::remove_all(folder);
  std::fprintf(stderr, "%d releases, %d edges, %d not on time\n", releases, work.edges, work.early);
  return begun && releases >= 18 && work.early == 0 && work.edges == releases ? 0 : 1;
}

TEST(FrameEngine, TheActuateThreadDoesItsWorkBetweenReleases) {
  EXPECT_EXIT(std::_Exit(work_between_releases()), testing::ExitedWithCode(0), "");
}

TEST(FrameEngine, AStandstillCountsEveryFrameThatWasSleptThrough) {
  Stage s;
  s.compute(1);
  s.release(1);
  s.compute(12, 10);
  EXPECT_EQ(s.timing.frames_skipped, 10u);
  s.release(12, 10);
  EXPECT_EQ(s.sent, (std::vector{10, 120}));
  s.compute(13);
  EXPECT_EQ(s.seen.overruns, 10u);
  EXPECT_TRUE(s.seen.limit);
}

TEST(FrameEngine, MarginIsWhatIsLeftUntilTheRelease) {
  Stage s;
  s.start_ns = now_ns() - kPeriod;
  s.compute(1);
  EXPECT_LE(s.timing.margin_ns, 5 * kMillisecond);
  s.start_ns = now_ns() - 2 * kPeriod - 6 * kMillisecond;
  s.compute(2);
  EXPECT_LE(s.timing.margin_ns, -kMillisecond) << "it is late";
}

}  // namespace
}  // namespace lss
