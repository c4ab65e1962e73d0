// Solving the same again and again has an end. [Conf-3] [Oper-6]

#include <gtest/gtest.h>

#include "idl/zebro/codes.h"
#include "world.h"

namespace lss::zebro {
namespace {

Parameters three_rounds() {
  Parameters p;
  p.solver.rounds = 3;
  return p;
}

// Begins to stand up, and the leg jams at once.
void jam(World& w, std::size_t leg) {
  w.send(lss::CommandKind::start, {1});
  ASSERT_TRUE(w.run_until(Mode::standing_up, 5));
  w.modules[leg].flags |= kFlagOverCurrent;
  ASSERT_TRUE(w.run_until([&] { return w.state() == State::fatal_error; }, 0.2));
}

// The result of `solve`; none: it led to Idle.
Reason solve(World& w) {
  const std::size_t before = w.acks.size();
  w.send(lss::CommandKind::solve);
  w.step();
  w.run_until([&] { return w.state() != State::solve_errors; }, 120);
  if (w.state() == State::idle) return Reason::none;
  for (std::size_t i = before; i < w.acks.size(); ++i) {
    if (w.acks[i].phase == Phase::rejected || w.acks[i].phase == Phase::failed)
      return w.acks[i].verdict.reason;
  }
  return Reason::none;
}

// Each alone is solved: after it was moved free it works.
void solve_as_often_as_allowed(World& w, std::size_t leg) {
  w.run(0.2);
  for (int i = 0; i < 3; ++i) {
    ASSERT_NO_FATAL_FAILURE(jam(w, leg));
    ASSERT_EQ(solve(w), Reason::none) << i;
  }
  ASSERT_NO_FATAL_FAILURE(jam(w, leg));
}

// [Conf-3] [Oper-6]
TEST(SolveRounds, TheSameFaultOfTheSameModuleIsSolvedSoOftenAndThenByAPerson) {
  World w(three_rounds());
  ASSERT_NO_FATAL_FAILURE(solve_as_often_as_allowed(w, 2));
  for (int i = 0; i < 3; ++i) EXPECT_EQ(solve(w), reasons::solved_too_often);
  EXPECT_EQ(w.state(), State::fatal_error);
  EXPECT_TRUE(w.has(FaultId::module_over_current, 3)) << "it is still reported";
  const Ack& refused = *w.last(Phase::rejected);
  EXPECT_EQ(refused.verdict.subject, 3);
  EXPECT_EQ(refused.verdict.measured, 3);
  EXPECT_EQ(refused.verdict.limit, 3);
  w.send(lss::CommandKind::reset, {-1});
  w.step();
  EXPECT_EQ(w.state(), State::fatal_error);
  EXPECT_EQ(solve(w), Reason::none) << "a person says that it is well";
}

TEST(SolveRounds, WhatIsNotSolvedCountsAsWell) {
  World w(three_rounds());
  ASSERT_TRUE(w.stand());
  w.modules[6].alive = false;
  ASSERT_TRUE(w.run_until([&] { return w.state() == State::fatal_error; }, 1));
  for (int i = 0; i < 3; ++i) EXPECT_EQ(solve(w), Reason::not_solved);
  EXPECT_EQ(solve(w), reasons::solved_too_often);
}

TEST(SolveRounds, AnotherModuleHasItsOwn) {
  World w(three_rounds());
  ASSERT_NO_FATAL_FAILURE(solve_as_often_as_allowed(w, 2));
  w.send(lss::CommandKind::reset, {-1});
  w.step();
  ASSERT_EQ(solve(w), Reason::none);
  for (const std::size_t leg : {0u, 1u, 2u, 3u, 4u, 5u}) {
    ASSERT_NO_FATAL_FAILURE(jam(w, leg));
    EXPECT_EQ(solve(w), Reason::none) << leg;
  }
}

// The stretch may be in pieces, with stops in between, but not with emergencies.
TEST(SolveRounds, AfterAStretchOfOperationTheyCountAgain) {
  for (const bool healthy : {true, false}) {
    Parameters p = three_rounds();
    p.solver.healthy_ns = 40 * kSecond;
    World w(p);
    w.run(0.2);
    for (int i = 0; i < 6; ++i) {
      for (int piece = 0; healthy && piece < 2; ++piece) {
        ASSERT_TRUE(w.stand());
        w.run(20);
        w.send(lss::CommandKind::stop, {1});
        ASSERT_TRUE(w.run_until([&] { return w.state() == State::idle; }, 20));
      }
      ASSERT_NO_FATAL_FAILURE(jam(w, 4));
      const Reason became = solve(w);
      EXPECT_EQ(became, healthy || i < 3 ? Reason::none : reasons::solved_too_often) << i;
      if (became != Reason::none) break;
    }
  }
}

TEST(SolveRounds, EmergencyStopsByCommandDoNotCount) {
  World w(three_rounds());
  w.run(0.2);
  for (int i = 0; i < 8; ++i) {
    w.send(lss::CommandKind::emergency_stop, {}, "anyone");
    w.step();
    EXPECT_EQ(solve(w), Reason::none) << i;
  }
}

}  // namespace
}  // namespace lss::zebro
