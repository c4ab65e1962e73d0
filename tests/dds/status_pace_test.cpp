// When lss/status is sent.

#include "daemon/publish/status_pace.h"

#include <gtest/gtest.h>

#include <functional>
#include <vector>

namespace lss {
namespace {

class StatusPaceTest : public testing::Test {
 protected:
  // A second later; the seconds of those that were sent.
  bool passes(bool asked = false) {
    report_.time_ns += kSecond;
    report_.frame_index += 50;
    report_.telemetry_dropped += 1;
    if (report_.obc_age_ms >= 0) report_.obc_age_ms += 1000;
    return pace_.is_due(report_, asked);
  }
  int sent_of(int seconds) {
    int sent = 0;
    for (int i = 0; i < seconds; ++i) sent += passes() ? 1 : 0;
    return sent;
  }

  StatusReport report_;
  StatusPace pace_;
};

TEST_F(StatusPaceTest, TheFirstIsSentAndAtRestOneEveryEightSeconds) {
  EXPECT_TRUE(passes());
  EXPECT_EQ(sent_of(7), 0);
  EXPECT_TRUE(passes());
  EXPECT_EQ(sent_of(80), 10);
}

TEST_F(StatusPaceTest, OutsideIdleAndInSimulatedTimeEachIsSent) {
  for (const State state : {State::operational, State::fatal_error, State::solve_errors}) {
    report_.state = state;
    EXPECT_EQ(sent_of(10), 10);
  }
  report_.state = State::idle;
  report_.simulated_time = true;
  EXPECT_EQ(sent_of(10), 10);
}

TEST_F(StatusPaceTest, WhoeverSpokeGetsTheNext) {
  EXPECT_TRUE(passes());
  EXPECT_TRUE(passes(true));
  EXPECT_FALSE(passes());
}

TEST_F(StatusPaceTest, WhatChangesIsSentInItsSecond) {
  const std::vector<std::function<void(StatusReport&)>> changes = {
      [](auto& r) { r.mode = 1; },
      [](auto& r) { r.authority[0] = 'a'; },
      [](auto& r) { r.faults[15].count = 1; },
      [](auto& r) { r.fault_count = 1; },
      [](auto& r) { r.overruns = 1; },
      [](auto& r) { r.commands_rejected = 1; },
      [](auto& r) { r.recording = true; },
      [](auto& r) { r.airborne = true; },
      [](auto& r) { r.threads[0].page_faults = 1; },
      [](auto& r) { r.saved_parameters = SavedState::good; },
  };
  EXPECT_TRUE(passes());
  for (const auto& change : changes) {
    EXPECT_FALSE(passes());
    change(report_);
    EXPECT_TRUE(passes());
  }
}

}  // namespace
}  // namespace lss
