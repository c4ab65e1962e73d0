// Parameters of Lunar Zebro that change while it runs.
#include "tests/support/parameters.h"

#include <gtest/gtest.h>

#include "daemon/vehicles/zebro/record.h"
#include "daemon/vehicles/zebro/tunables.h"
#include "world.h"

namespace lss::zebro {
namespace {

namespace any = parameters_test;

std::size_t index_of(const char* name) {
  const int index = find_tunable(tuning().infos, name);
  EXPECT_GE(index, 0) << name;
  return static_cast<std::size_t>(index);
}

// Sends and steps; the last answer.
Ack set(World& w, const char* name, double value, const char* from = "test",
        std::uint16_t flags = 0) {
  w.acks.clear();
  w.send(lss::CommandKind::set_parameter, {any::number(index_of(name)), value}, from, flags);
  w.step();
  return w.acks.empty() ? Ack{} : w.acks.back();
}

TEST(ZebroParameters, TheTableIsSound) { any::expect_a_sound_table(tuning()); }
TEST(ZebroParameters, EachIsTakenAndToldInIdle) {
  any::expect_each_is_taken_and_told<World>(tuning());
}
TEST(ZebroParameters, AdjustingAllocatesNothing) {
  any::expect_adjusting_allocates_nothing<World>(tuning());
}
TEST(ZebroParameters, NonsenseIsRefusedWhateverItIs) {
  any::expect_nonsense_is_refused<World>(tuning());
}

TEST(ZebroParameters, ALowerCurrentLimitIsInForceAtOnce) {
  World w;
  ASSERT_TRUE(w.stand());
  w.modules[2].current_mA = 1000;
  w.run(1);
  EXPECT_EQ(w.state(), State::operational);
  EXPECT_EQ(set(w, "limits.current_A", 0.9).phase, Phase::completed);
  w.run(0.2);
  EXPECT_TRUE(w.has(FaultId::current_limit, 3));
  EXPECT_EQ(w.state(), State::fatal_error);
}

TEST(ZebroParameters, StandingUpTakesAsLongAsItWasSetTo) {
  const auto takes_s = [](double stand_up_s) {
    World w;
    w.run(0.2);
    EXPECT_EQ(set(w, "motion.stand_up_s", stand_up_s).phase, Phase::completed);
    EXPECT_TRUE(w.stand());
    return static_cast<double>(w.time_ns_) * 1e-9;
  };
  EXPECT_NEAR(takes_s(7) - takes_s(3), 4, 0.05);
}

TEST(ZebroParameters, TimeForAStrategyIsThatOfTheNextOne) {
  World w;
  w.run(0.2);
  EXPECT_EQ(set(w, "solve.budget_s", 2).phase, Phase::completed);
  w.modules[1].alive = false;
  ASSERT_TRUE(w.run_until([&] { return w.state() == State::fatal_error; }, 5));
  const TimeNs from = w.time_ns_;
  w.send(lss::CommandKind::solve);
  ASSERT_TRUE(w.run_until(
      [&] { return w.last(Phase::failed) != nullptr || w.last(Phase::completed) != nullptr; }, 60));
  EXPECT_LT(w.time_ns_ - from, 12 * kSecond);  // three strategies; with ten seconds each it is more
}

TEST(ZebroParameters, WhatMovesIsNotChangedUnderWay) {
  World w;
  ASSERT_TRUE(w.stand());
  w.send(CommandKind::walk, {1, 0, 3});
  ASSERT_TRUE(w.run_until(Mode::walking, 5));
  const Ack refused = set(w, "gait.flight_s", 4);
  EXPECT_EQ(refused.phase, Phase::rejected);
  EXPECT_EQ(refused.verdict.reason, Reason::not_in_state);
  EXPECT_EQ(refused.verdict.measured, 1);  // Operational
  EXPECT_EQ(w.vehicle_.tunables().value[index_of("gait.flight_s")], 3);
  // Allowed parameters change, and the walk continues, for any source.
  EXPECT_EQ(set(w, "limits.current_A", 1.1).phase, Phase::completed);
  EXPECT_EQ(w.mode(), Mode::walking);
  EXPECT_EQ(w.supervisor_.state().active.kind, static_cast<std::uint16_t>(CommandKind::walk));
}

TEST(ZebroParameters, ARefusalSaysWhatCameAndWhatIsAllowed) {
  World w;
  w.run(0.2);
  const auto above = set(w, "limits.current_A", 12).verdict;
  EXPECT_EQ(above.reason, Reason::parameter_range);
  EXPECT_EQ(above.measured, 12);
  EXPECT_EQ(above.limit, 1.7);
  EXPECT_EQ(above.subject, any::number(index_of("limits.current_A")));
  EXPECT_EQ(w.events.back().id, static_cast<std::uint16_t>(EventId::command_rejected));
  EXPECT_EQ(w.events.back().subject, 0);  // a parameter is no module
  const auto below = set(w, "limits.current_A", 0).verdict;
  EXPECT_EQ(below.limit, 0.05);
  EXPECT_EQ(set(w, "solve.rounds", 2.5).verdict.reason, Reason::parameter_whole);
  // A full turn in so short a flight is faster than a leg may turn.
  EXPECT_EQ(set(w, "gait.flight_s", 1).verdict.reason, Reason::parameter_together);
  EXPECT_EQ(w.vehicle_.tunables().changes, 0U);
  w.acks.clear();
  w.send(lss::CommandKind::set_parameter, {any::number(tuning().infos.size()), 1});
  w.step();
  EXPECT_EQ(w.acks.back().verdict.reason, Reason::no_such_parameter);
  EXPECT_EQ(w.acks.back().verdict.limit, static_cast<double>(tuning().infos.size()));
}

TEST(ZebroParameters, OnlyWhoHoldsAuthorityChangesThem) {
  World w;
  ASSERT_TRUE(w.stand());
  EXPECT_EQ(set(w, "limits.current_A", 1, "another").verdict.reason, Reason::not_authorised);
  EXPECT_EQ(set(w, "limits.current_A", 1).phase, Phase::completed);
}

TEST(ZebroParameters, ADryRunAsksOnly) {
  World w;
  w.run(0.2);
  EXPECT_EQ(set(w, "limits.current_A", 1, "test", kFlagDryRun).phase, Phase::accepted);
  EXPECT_EQ(set(w, "gait.flight_s", 1, "test", kFlagDryRun).verdict.reason,
            Reason::parameter_together);
  EXPECT_EQ(w.vehicle_.tunables().changes, 0U);
}

TEST(ZebroParameters, ASaveIsAskedForOnceAFrameAndAnsweredByOthers) {
  World w;
  w.run(0.2);
  w.acks.clear();
  w.send(lss::CommandKind::save_parameters);
  w.send(lss::CommandKind::save_parameters, {}, "another");
  w.step();
  ASSERT_NE(w.supervisor_.save_asked(), nullptr);
  EXPECT_EQ(w.supervisor_.save_asked()->source, source("test"));
  ASSERT_EQ(w.acks.size(), 3U);  // accepted, executing; and the other one
  EXPECT_EQ(w.acks[1].phase, Phase::executing);
  EXPECT_EQ(w.acks[2].verdict.reason, Reason::busy);
  w.step();
  EXPECT_EQ(w.supervisor_.save_asked(), nullptr);
}

TEST(ZebroParameters, ARecordingInWhichTheyChangeIsReplayedToTheBitAlsoFromTheMiddle) {
  World w;
  any::Recording<World, Vehicle> recording(w);
  recording.run(0.2);
  const auto change = [&](const char* name, double value) {
    w.send(lss::CommandKind::set_parameter, {any::number(index_of(name)), value});
    recording.step();
  };
  change("gait.flight_s", 3.7);
  change("motion.swing_limit_deg_s", 117.3);
  change("solve.rounds", 7);
  change("solve.budget_s", 3.3);
  w.send(lss::CommandKind::start, {2, 1, 0.3, 3});
  for (int s = 0; s < 60 && w.mode() != Mode::walking; ++s) recording.run(1);
  ASSERT_EQ(w.mode(), Mode::walking);
  change("limits.current_A", 1.234);
  recording.remember();
  recording.run(2);
  w.modules[3].current_mA = 1230;  // below the limit as it is, above the one before
  recording.run(2);
  EXPECT_EQ(w.mode(), Mode::walking);
  w.modules[3].current_mA = 1240;
  recording.run(1);
  EXPECT_EQ(w.state(), State::fatal_error);
  w.modules[3].current_mA = 100;
  w.modules[3].alive = false;
  w.send(lss::CommandKind::solve);
  recording.run(8);
  recording.expect_replayed(Parameters{}, logic());
  Parameters other;
  other.current_limit_A = 0.5;  // is set, but not before it starts
  EXPECT_TRUE(recording.differs_with(other, logic()));
}

}  // namespace
}  // namespace lss::zebro
