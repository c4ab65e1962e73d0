#pragma once

// Safety suite: every loss and failure has its fault, a safe command in time, and stays until it is
// solved; and the gate. See safety_suite.h.

#include "daemon/cycle/text.h"
#include "scene.h"

namespace lss::safety {

template <class T>
class SafetyFaults : public testing::Test {};
TYPED_TEST_SUITE_P(SafetyFaults);

// [Oper-5] [Oper-6] [P-Int-2] [Prod-4]
TYPED_TEST_P(SafetyFaults, EachStopsEverythingInTimeAndLastsUntilItIsSolved) {
  using T = TypeParam;
  for (const auto& fault : faults<T>()) {
    SCOPED_TRACE(fault.name);
    const auto w = moving<T>();
    ASSERT_NE(w, nullptr);
    w->run(1);
    ASSERT_EQ(w->state(), State::operational) << "before its cause";
    w->acks.clear();
    const bool commanded = w->supervisor_.state().active.kind != 0;
    fault.cause(*w);
    ASSERT_TRUE(w->run_until(State::fatal_error, fault.within_s + 1e-3)) << where<T>(*w);
    EXPECT_TRUE(stopped<T>(*w)) << "in the frame that saw it";
    EXPECT_TRUE(w->has(fault.id, fault.subject)) << info(fault.id)->name;
    if (commanded) {
      ASSERT_NE(w->last(Phase::failed), nullptr) << "of the command that ran";
      EXPECT_EQ(w->last(Phase::failed)->verdict.reason, Reason::emergency);
    }
    EXPECT_EQ(w->supervisor_.state().authority, Name{});
    EXPECT_TRUE(stays_stopped<T>(*w, 2));
    w->alter = nullptr;
    if (fault.heal) fault.heal(*w);
    EXPECT_TRUE(stays_stopped<T>(*w, 2)) << "an emergency does not end by itself";
    EXPECT_TRUE(w->has(fault.id, fault.subject)) << "it latches";
    EXPECT_EQ(answer_to<T>(*w, request_of(*T::logic().command(1))).verdict.reason,
              Reason::not_in_state);
    ASSERT_TRUE(is_solved<T>(*w));
    EXPECT_TRUE(comes_to_motion<T>(*w));
  }
}

// [P-Int-2]
TYPED_TEST_P(SafetyFaults, TheLossOfAModuleStopsEverythingInTimeEverywhere) {
  using T = TypeParam;
  const auto all = faults<T>();
  ASSERT_TRUE(std::ranges::any_of(all, [](const auto& fault) { return fault.everywhere; }));
  for (const auto& place : places<T>()) {
    for (const auto& fault : all) {
      if (!fault.everywhere) continue;
      SCOPED_TRACE(place.name + ", " + fault.name);
      const auto w = at<T>(place);
      ASSERT_NE(w, nullptr);
      if (airborne<T>(*w)) continue;  // it lands first
      fault.cause(*w);
      if (place.state == State::operational) {
        ASSERT_TRUE(w->run_until(State::fatal_error, fault.within_s + 1e-3)) << where<T>(*w);
        EXPECT_TRUE(stopped<T>(*w)) << "in the frame that saw it";
        EXPECT_TRUE(w->has(fault.id, fault.subject)) << info(fault.id)->name;
      }
      EXPECT_TRUE(stays_sound<T>(*w, 2));
      EXPECT_NE(w->state(), State::operational);
      for (const auto& any : all) {
        if (any.heal) any.heal(*w);
      }
      ASSERT_TRUE(w->run_until([&] { return w->state() != State::solve_errors; }, 90));
      EXPECT_TRUE(recovers<T>(*w));
    }
  }
}

// Outside Operational nothing moves after any loss.
TYPED_TEST_P(SafetyFaults, NoneMovesAnythingInIdle) {
  using T = TypeParam;
  for (const auto& fault : faults<T>()) {
    SCOPED_TRACE(fault.name);
    const auto w = fresh<T>();
    w->run(2);
    fault.cause(*w);
    EXPECT_TRUE(stays_sound<T>(*w, 5));
    EXPECT_NE(w->state(), State::operational);
  }
}

// What a bus reported before it stood still must not look well.
TYPED_TEST_P(SafetyFaults, ABusThatStandsStillIsNotSolved) {
  using T = TypeParam;
  for (const auto& fault : faults<T>()) {
    if (fault.id != FaultId::bus_stuck) continue;
    SCOPED_TRACE(fault.name);
    const auto w = moving<T>();
    ASSERT_NE(w, nullptr);
    w->run(1);
    fault.cause(*w);
    const auto stands = w->alter;
    w->alter = [stands](WorldOf<T>& world) {
      stands(world);
      world.in_.sample_count = 0;
    };
    ASSERT_TRUE(w->run_until(State::fatal_error, fault.within_s + 1e-3)) << where<T>(*w);
    w->send(CommandKind::solve);
    w->step();
    ASSERT_EQ(w->state(), State::solve_errors);
    ASSERT_TRUE(w->run_until([&] { return w->state() != State::solve_errors; }, 300));
    EXPECT_EQ(w->state(), State::fatal_error);
  }
}

// Its motor may be on. It is solved when it obeys, or goes on without the module.
TYPED_TEST_P(SafetyFaults, AModuleThatDisobeysIsAnEmergencyInIdleTooUntilItObeys) {
  using T = TypeParam;
  for (const auto& fault : faults<T>()) {
    if (!fault.name.starts_with("disobeys")) continue;
    SCOPED_TRACE(fault.name);
    const auto w = fresh<T>();
    w->run(2);
    ASSERT_EQ(w->state(), State::idle);
    fault.cause(*w);
    ASSERT_TRUE(w->run_until(State::fatal_error, fault.within_s + 1e-3)) << where<T>(*w);
    EXPECT_TRUE(stopped<T>(*w)) << "in the frame that saw it";
    EXPECT_TRUE(w->has(fault.id, fault.subject)) << info(fault.id)->name;
    w->send(CommandKind::solve);
    w->step();
    ASSERT_EQ(w->state(), State::solve_errors);
    ASSERT_TRUE(w->run_until([&] { return w->state() != State::solve_errors; }, 300));
    if (w->supervisor_.controller().isolated != 0) continue;
    EXPECT_EQ(w->state(), State::fatal_error);
    w->alter = nullptr;
    if (fault.heal) fault.heal(*w);
    EXPECT_TRUE(is_solved<T>(*w));
  }
}

// The second comes while the first is solved.
TYPED_TEST_P(SafetyFaults, OneThatComesWhileErrorsAreSolvedStopsEverythingAgain) {
  using T = TypeParam;
  const auto all = faults<T>();
  for (std::size_t i = 0; i < all.size(); ++i) {
    SCOPED_TRACE(all[i].name);
    const auto w = moving<T>();
    ASSERT_NE(w, nullptr);
    w->send(CommandKind::emergency_stop);
    w->run(0.5);
    w->send(CommandKind::solve);
    w->step();
    ASSERT_EQ(w->state(), State::solve_errors);
    all[i].cause(*w);
    EXPECT_TRUE(stays_sound<T>(*w, 5));
    EXPECT_NE(w->state(), State::operational);
  }
}

TYPED_TEST_P(SafetyFaults, AStopThatTheCycleDoesNotFollowIsAnEmergency) {
  using T = TypeParam;
  const auto w = moving<T>();
  ASSERT_NE(w, nullptr);
  w->alter = [](WorldOf<T>& world) { T::stop_pending(world.in_.bus) = true; };
  w->step();
  w->step();
  EXPECT_EQ(w->state(), State::operational) << "it may be on its way";
  w->step();
  EXPECT_EQ(w->state(), State::fatal_error);
  EXPECT_TRUE(stopped<T>(*w));
  EXPECT_TRUE(w->has(FaultId::stop_not_followed));
}

TYPED_TEST_P(SafetyFaults, CorrectedMemoryIsReportedAndLostMemoryIsAnEmergency) {
  using T = TypeParam;
  const auto w = moving<T>();
  ASSERT_NE(w, nullptr);
  const auto step_with = [&w](MemoryCheck found) {
    w->alter = [found](WorldOf<T>& world) { world.in_.memory = found; };
    w->step();
  };
  step_with(MemoryCheck::corrected);
  EXPECT_EQ(w->state(), State::operational);
  ASSERT_FALSE(w->events.empty());
  EXPECT_TRUE(std::ranges::count(w->events, static_cast<std::uint16_t>(EventId::memory_corrected),
                                 &EventRecord::id));
  step_with(MemoryCheck::lost);
  EXPECT_TRUE(w->has(FaultId::memory_lost));
  if (airborne<T>(*w)) return;  // it lands first
  EXPECT_EQ(w->state(), State::fatal_error);
  EXPECT_TRUE(stopped<T>(*w));
}

// ---- the gate

template <class T>
using CommandOf = typename WorldOf<T>::Vehicle::Command;

template <class T>
void expect_replaced(WorldOf<T>& w, const CommandOf<T>& wanted) {
  const std::uint64_t before = w.supervisor_.state().safe_commands;
  w.out_.command = w.vehicle_.gate(wanted, w.supervisor_, w.time_ns_);
  EXPECT_TRUE(stopped<T>(w)) << "what leaves the gate";
  EXPECT_EQ(w.supervisor_.state().safe_commands, before + 1) << "counted";
  EXPECT_TRUE(w.has(FaultId::gate_closed));
  EXPECT_EQ(w.state(), State::fatal_error);
  EXPECT_TRUE(stays_stopped<T>(w, 1));
}

// [Env-2]
TYPED_TEST_P(SafetyFaults, TheGateReplacesEveryBadCommandByTheSafeOne) {
  using T = TypeParam;
  for (std::size_t i = 0; i < T::bad_commands().size(); ++i) {
    SCOPED_TRACE("bad command " + std::to_string(i));
    const auto w = moving<T>();
    ASSERT_NE(w, nullptr);
    CommandOf<T> bad = w->out_.command;
    T::bad_commands()[i](bad);
    ASSERT_NE(bad, w->out_.command);
    expect_replaced<T>(*w, bad);
  }
}

TYPED_TEST_P(SafetyFaults, TheGateLetsTheVehiclesOwnCommandPass) {
  using T = TypeParam;
  const auto w = moving<T>();
  ASSERT_NE(w, nullptr);
  w->run(2);
  EXPECT_TRUE(w->vehicle_.gate(w->out_.command, w->supervisor_, w->time_ns_) == w->out_.command);
  EXPECT_EQ(w->supervisor_.state().safe_commands, 0u);
}

TYPED_TEST_P(SafetyFaults, TheGateStopsACommandOfAnotherFrame) {
  using T = TypeParam;
  for (const TimeNs shift : {TimeNs{-1}, TimeNs{1}}) {
    const auto w = moving<T>();
    ASSERT_NE(w, nullptr);
    CommandOf<T> stale = w->out_.command;
    stale.issued_ns += shift;
    expect_replaced<T>(*w, stale);
  }
}

// A command that moves the vehicle, as it is in motion, in each state but Operational.
TYPED_TEST_P(SafetyFaults, NothingThatMovesPassesTheGateOutsideOperational) {
  using T = TypeParam;
  for (const auto& place : places<T>()) {
    if (place.state == State::operational) continue;
    SCOPED_TRACE(place.name);
    const auto w = at<T>(place), other = moving<T>();
    ASSERT_TRUE(w != nullptr && other != nullptr);
    // To the same time: nothing else is wrong with it.
    while (w->time_ns_ < other->time_ns_ && w->state() == place.state) w->step();
    while (other->time_ns_ < w->time_ns_) other->step();
    ASSERT_TRUE(T::moves(*other)) << where<T>(*other);
    if (w->time_ns_ != other->time_ns_) continue;  // solved before
    expect_replaced<T>(*w, other->out_.command);
  }
}

TYPED_TEST_P(SafetyFaults, CodesOfItsOwnHaveANumberOfTheirOwnAndATextThatLeavesNoPlaceholder) {
  using T = TypeParam;
  own_codes = T::logic().codes;
  const auto distinct = [](std::span<const CodeInfo> own, std::span<const CodeInfo> shared) {
    for (const CodeInfo& code : own) {
      EXPECT_EQ(find_code(shared, code.number), nullptr) << code.name;
      EXPECT_EQ(find_code(own, code.number), &code) << code.name;
      EXPECT_STRNE(code.text, "") << code.name;
    }
  };
  distinct(own_codes.faults, kFaults);
  distinct(own_codes.reasons, kReasons);
  distinct(own_codes.events, kEvents);
  for (const CodeInfo& code : own_codes.faults) EXPECT_STRNE(code.advice, "") << code.name;
  for (const CodeInfo& code : own_codes.events) {
    const EventRecord event{.id = code.number, .argument = {-1, 1e9, 0, 99}};
    EXPECT_EQ(event_text(event, {}, {}).find('{'), std::string::npos) << code.name;
  }
}

REGISTER_TYPED_TEST_SUITE_P(
    SafetyFaults, CodesOfItsOwnHaveANumberOfTheirOwnAndATextThatLeavesNoPlaceholder,
    EachStopsEverythingInTimeAndLastsUntilItIsSolved,
    TheLossOfAModuleStopsEverythingInTimeEverywhere, NoneMovesAnythingInIdle,
    AModuleThatDisobeysIsAnEmergencyInIdleTooUntilItObeys, ABusThatStandsStillIsNotSolved,
    OneThatComesWhileErrorsAreSolvedStopsEverythingAgain,
    AStopThatTheCycleDoesNotFollowIsAnEmergency,
    CorrectedMemoryIsReportedAndLostMemoryIsAnEmergency, TheGateReplacesEveryBadCommandByTheSafeOne,
    TheGateLetsTheVehiclesOwnCommandPass, TheGateStopsACommandOfAnotherFrame,
    NothingThatMovesPassesTheGateOutsideOperational);

}  // namespace lss::safety
