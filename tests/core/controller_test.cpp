#include "daemon/cycle/controller.h"

#include <gtest/gtest.h>

namespace lss::lc {
namespace {

const Rows kNoRows({});
const Table kNoVehicle{&kNoRows,
                       {},
                       0,
                       {},
                       [](unsigned, const ControllerState&, unsigned) { return Verdict{}; },
                       [](ActionSet, ControllerState&) {},
                       &kCommonRows};

ControllerState in_state(State s) { return {.state = s, .links = 0}; }

// [Oper-5]
TEST(Controller, EmergencyStopFromAnywhereStopsEverythingAndEndsInFatalError) {
  for (const State s : {State::idle, State::operational, State::fatal_error, State::solve_errors}) {
    const Result r = step(kNoVehicle, in_state(s), Event::emergency_stop);
    EXPECT_EQ(r.next.state, State::fatal_error);
    EXPECT_TRUE(r.actions & kEmergencyStop);
  }
}

// [Oper-6]
TEST(Controller, FatalErrorIsLeftOnlyBySolve) {
  for (unsigned e = 0; e < 256; ++e) {
    const Result r = step(kNoVehicle, in_state(State::fatal_error), static_cast<Event>(e));
    if (static_cast<Event>(e) == Event::solve) {
      EXPECT_EQ(r.next.state, State::solve_errors);
    } else {
      EXPECT_EQ(r.next.state, State::fatal_error) << "event " << e;
    }
  }
}

// [Oper-6]
TEST(Controller, SolveErrorsEndsInIdleWhenSolvedElseInFatalError) {
  EXPECT_EQ(step(kNoVehicle, in_state(State::solve_errors), Event::solved).next.state, State::idle);
  EXPECT_EQ(step(kNoVehicle, in_state(State::solve_errors), Event::unsolved).next.state,
            State::fatal_error);
  EXPECT_EQ(step(kNoVehicle, in_state(State::solve_errors), Event::emergency).next.state,
            State::fatal_error);
}

TEST(Controller, WhatNoRowTakesChangesNothingAndSaysWhy) {
  const Result unknown = step(kNoVehicle, in_state(State::idle), static_cast<Event>(200));
  EXPECT_EQ(unknown.verdict.reason, Reason::unknown_command);
  EXPECT_EQ(unknown.next, in_state(State::idle));
  EXPECT_EQ(unknown.actions, 0u);
  EXPECT_EQ(step(kNoVehicle, in_state(State::idle), Event::solve).verdict.reason,
            Reason::not_in_state);
}

}  // namespace
}  // namespace lss::lc
