#include <gtest/gtest.h>

#include "world.h"

namespace lss::zebro {
namespace {

TEST(Supervisor, AnswersACommandAcceptedExecutingAndCompleted) {
  World w;
  w.run(0.2);
  w.send(lss::CommandKind::start, {0});
  ASSERT_TRUE(w.run_until([&] { return w.last(Phase::completed) != nullptr; }, 1));
  ASSERT_GE(w.acks.size(), 3u);
  EXPECT_EQ(w.acks[0].phase, Phase::accepted);
  EXPECT_EQ(w.acks[1].phase, Phase::executing);
  EXPECT_EQ(w.acks[2].phase, Phase::completed);
  EXPECT_EQ(w.mode(), Mode::holding);
}

TEST(Supervisor, RejectsAMotionCommandOfASecondSource) {
  World w;
  ASSERT_TRUE(w.stand());
  w.send(CommandKind::walk, {1, 0, 3}, "intruder");
  w.step();
  EXPECT_EQ(w.acks.back().phase, Phase::rejected);
  EXPECT_EQ(w.acks.back().verdict.reason, Reason::not_authorised);
  EXPECT_EQ(w.mode(), Mode::standing);
}

TEST(Supervisor, TakesAnEmergencyStopFromASecondSource) {
  World w;
  ASSERT_TRUE(w.stand());
  w.send(lss::CommandKind::emergency_stop, {}, "anyone");
  w.step();
  EXPECT_EQ(w.state(), State::fatal_error);
  EXPECT_TRUE(w.all_stopped());
  EXPECT_TRUE(w.has(FaultId::emergency_stop));
}

TEST(Supervisor, ReleasesAuthorityWithTheStop) {
  World w;
  ASSERT_TRUE(w.stand());
  EXPECT_EQ(w.supervisor_.state().authority, source("test"));
  w.send(lss::CommandKind::stop, {1});
  ASSERT_TRUE(w.run_until([&] { return w.state() == State::idle; }, 20));
  EXPECT_EQ(w.supervisor_.state().authority, Name{});
}

// [O-Int-2]
TEST(Supervisor, WithoutHeartbeatTheVehicleComesToASafeStopAndEndsIdle) {
  World w;
  ASSERT_TRUE(w.stand());
  w.send(CommandKind::walk, {1, 0, 3});
  w.run(5);
  ASSERT_EQ(w.mode(), Mode::walking);
  w.heartbeat_ = false;
  w.run(1.1);
  EXPECT_EQ(w.mode(), Mode::finishing_step);
  ASSERT_NE(w.last(Phase::failed), nullptr);
  EXPECT_EQ(w.last(Phase::failed)->verdict.reason, Reason::lease_expired);
  EXPECT_TRUE(w.run_until([&] { return w.state() == State::idle; }, 25));
}

TEST(Supervisor, ADetachedLeaseIsRenewedByAnyonesHeartbeat) {
  World w;
  w.run(0.2);
  w.send(lss::CommandKind::start, {1}, "elsewhere", kFlagDetached);
  EXPECT_TRUE(w.run_until(Mode::standing, 40));
  w.run(5);
  EXPECT_EQ(w.mode(), Mode::standing);
}

TEST(Supervisor, AnAttachedLeaseIsNotRenewedByAnother) {
  World w;
  w.run(0.2);
  w.send(lss::CommandKind::start, {0}, "elsewhere");
  w.run(2);
  EXPECT_EQ(w.state(), State::idle);
}

TEST(Supervisor, WithoutAnyContactInTimeItIsAnEmergency_O_Int_2) {
  World w({}, {.obc_timeout_ns = 500 * kMillisecond});
  ASSERT_TRUE(w.stand());
  w.heartbeat_ = false;
  w.run(0.6);
  EXPECT_EQ(w.state(), State::fatal_error);
  EXPECT_TRUE(w.has(FaultId::obc_silent));
  EXPECT_TRUE(w.all_stopped());
}

TEST(Supervisor, ADryRunSaysWhatWouldHappenAndDoesNothing) {
  World w;
  w.run(0.2);
  w.send(lss::CommandKind::start, {0}, "test", kFlagDryRun);
  w.step();
  EXPECT_EQ(w.acks.back().phase, Phase::accepted);
  EXPECT_EQ(w.state(), State::idle);
  w.send(CommandKind::walk, {1, 0, 3}, "test", kFlagDryRun);
  w.step();
  EXPECT_EQ(w.acks.back().phase, Phase::rejected);
  EXPECT_EQ(w.acks.back().verdict.reason, Reason::not_in_state);
}

TEST(Supervisor, ANewCommandSupersedesTheRunningOne) {
  World w;
  ASSERT_TRUE(w.stand());
  w.send(CommandKind::walk, {1, 0, 3});
  w.run(1);
  w.send(CommandKind::stand);
  w.step();
  ASSERT_NE(w.last(Phase::superseded), nullptr);
  EXPECT_EQ(w.last(Phase::superseded)->kind, static_cast<std::uint16_t>(CommandKind::walk));
  EXPECT_TRUE(w.run_until(Mode::standing, 20));
}

TEST(Supervisor, ARejectionOfASilentModuleNamesItWithWhatWasMeasuredAndAllowed) {
  World w;
  w.modules[2].alive = false;
  w.run(0.2);
  w.send(lss::CommandKind::start, {0});
  w.step();
  EXPECT_EQ(w.acks.back().phase, Phase::rejected);
  EXPECT_EQ(w.acks.back().verdict.reason, Reason::never_heard);
  EXPECT_EQ(w.acks.back().verdict.subject, 3);
}

TEST(Supervisor, FaultsLatchUntilTheyAreSolved_Oper_6) {
  World w;
  ASSERT_TRUE(w.stand());
  w.modules[1].alive = false;
  w.run(1);
  ASSERT_EQ(w.state(), State::fatal_error);
  w.modules[1].alive = true;
  w.run(2);
  EXPECT_EQ(w.state(), State::fatal_error) << "an emergency does not end by itself";
  EXPECT_TRUE(w.has(FaultId::module_silent, 2));
  w.send(lss::CommandKind::solve);
  ASSERT_TRUE(w.run_until([&] { return w.state() == State::idle; }, 12));
  EXPECT_EQ(w.supervisor_.state().fault_count, 0u);
}

// [Oper-6]
TEST(Supervisor, WhatCannotBeSolvedEndsInFatalErrorAgain) {
  World w;
  ASSERT_TRUE(w.stand());
  w.modules[6].alive = false;  // the panel, which nothing can do without
  w.run(1);
  w.send(lss::CommandKind::solve);
  w.step();
  ASSERT_EQ(w.state(), State::solve_errors);
  EXPECT_TRUE(w.run_until([&] { return w.state() == State::fatal_error; }, 40));
  ASSERT_NE(w.last(Phase::failed), nullptr);
  EXPECT_EQ(w.last(Phase::failed)->verdict.reason, Reason::not_solved);
}

// Reports about a slow machine must not slow it down further.
TEST(Supervisor, LateCommandsAreToldAtOnceThenNowAndThenAndNoneIsForgotten) {
  World w;
  w.run(0.2);
  const auto told = [&] {
    std::vector<double> counts;
    for (const EventRecord& event : w.events) {
      if (event.id == static_cast<std::uint16_t>(EventId::frame_late))
        counts.push_back(event.argument[0]);
    }
    return counts;
  };
  w.in_.late_commands = 1;
  w.step();
  EXPECT_EQ(told(), std::vector<double>{1});
  for (const TimeNs end = w.time_ns_ + 2 * kSecond; w.time_ns_ < end; w.step())
    ++w.in_.late_commands;
  const auto late = static_cast<double>(w.in_.late_commands);
  EXPECT_EQ(told(), std::vector<double>{1});
  EXPECT_EQ(w.supervisor_.state().late_commands, w.in_.late_commands);
  w.run(10);
  EXPECT_EQ(told(), (std::vector<double>{1, late})) << "the rest, once, when it is time";
}

}  // namespace
}  // namespace lss::zebro
