#pragma once

// Safety suite: a commanded reset of a module, which is away for a while and comes back or does
// not. See safety_suite.h.

#include "scene.h"

namespace lss::safety {

template <class T>
class SafetyResets : public testing::Test {};
TYPED_TEST_SUITE_P(SafetyResets);

// Seconds until a module that stays away is a fault.
template <class T>
double reset_s() {
  return static_cast<double>(T::parameters().reset_ns) * 1e-9;
}

template <class T>
WorldPtr<T> in_reset(std::uint16_t module, double for_s = 0) {
  auto w = fresh<T>();
  w->run(6);
  w->events.clear();
  w->send(CommandKind::reset, {static_cast<double>(module)});
  w->executed = [world = w.get()] { world->out_.command = {}; };  // the module acts as this says
  w->step();
  w->executed = nullptr;
  EXPECT_NE(w->answer(CommandKind::reset, Phase::executing), nullptr);
  T::take_away(*w, module);
  w->run(for_s);
  return w;
}

template <class T>
void expect_well(const WorldOf<T>& w) {
  EXPECT_EQ(w.state(), State::idle);
  EXPECT_EQ(w.supervisor_.state().fault_count, 0u);
  EXPECT_TRUE(safe<T>(w));
}

template <class T>
Verdict try_start(WorldOf<T>& w) {
  return answer_to<T>(w, request_of(*T::logic().command(1))).verdict;
}

// [Oper-4]
TYPED_TEST_P(SafetyResets, OfAModuleIsNoEmergencyAndEndsWhenItIsBack) {
  using T = TypeParam;
  for (const std::uint16_t module : T::kResettable) {
    SCOPED_TRACE(module);
    const auto w = in_reset<T>(module, reset_s<T>() / 2);
    expect_well<T>(*w);
    EXPECT_EQ(w->answer(CommandKind::reset, Phase::completed), nullptr);
    ASSERT_NE(w->heard(EventId::reset_begun), nullptr);
    EXPECT_EQ(w->heard(EventId::reset_begun)->subject, module);
    const Verdict refused = try_start<T>(*w);
    EXPECT_EQ(refused.reason, Reason::module_silent);
    EXPECT_EQ(refused.subject, module);
    EXPECT_GT(refused.measured, refused.limit);
    T::bring_back(*w, module);
    ASSERT_TRUE(w->run_until(
        [&] { return w->answer(CommandKind::reset, Phase::completed) != nullptr; }, 1));
    ASSERT_NE(w->heard(EventId::reset_ended), nullptr);
    EXPECT_EQ(w->heard(EventId::reset_ended)->subject, module);
    w->run(1);
    expect_well<T>(*w);
    EXPECT_EQ(try_start<T>(*w).reason, Reason::none);
  }
}

TYPED_TEST_P(SafetyResets, OfAllModulesEndsWithTheLastOfThemAndItMovesAfterIt) {
  using T = TypeParam;
  const auto w = fresh<T>();
  w->run(6);
  w->send(CommandKind::reset, {0});
  w->executed = [&] { w->out_.command = {}; };
  w->step();
  w->executed = nullptr;
  std::vector<std::uint16_t> all(T::kResettable.begin(), T::kResettable.end());
  if constexpr (requires { T::kAlsoReset; })
    all.insert(all.end(), T::kAlsoReset.begin(), T::kAlsoReset.end());
  for (const std::uint16_t module : all) T::take_away(*w, module);
  w->run(1);
  for (const std::uint16_t module : all) {
    EXPECT_EQ(w->answer(CommandKind::reset, Phase::completed), nullptr);
    T::bring_back(*w, module);
    w->run(0.2);
  }
  ASSERT_TRUE(
      w->run_until([&] { return w->answer(CommandKind::reset, Phase::completed) != nullptr; }, 1));
  expect_well<T>(*w);
  EXPECT_TRUE(comes_to_motion<T>(*w));
}

// [Oper-4]
TYPED_TEST_P(SafetyResets, AModuleThatStaysAwayIsAFaultAtItsDeadline) {
  using T = TypeParam;
  for (const std::uint16_t module : T::kResettable) {
    SCOPED_TRACE(module);
    const auto w = in_reset<T>(module, reset_s<T>() - 0.2);
    expect_well<T>(*w);
    ASSERT_TRUE(w->run_until(State::fatal_error, 0.6));
    EXPECT_TRUE(w->has(FaultId::module_silent, module));
    EXPECT_TRUE(stopped<T>(*w));
    const Ack* failed = w->answer(CommandKind::reset, Phase::failed);
    ASSERT_NE(failed, nullptr);
    EXPECT_EQ(failed->verdict.reason, Reason::module_silent);
    EXPECT_EQ(failed->verdict.subject, module);
    EXPECT_EQ(w->answer(CommandKind::reset, Phase::completed), nullptr);
  }
}

TYPED_TEST_P(SafetyResets, AModuleThatWasNotCommandedIsAFaultAsEver) {
  using T = TypeParam;
  const std::uint16_t one = T::kResettable[0], other = T::kResettable[1];
  const auto w = in_reset<T>(one, 0.5);
  T::take_away(*w, other);
  ASSERT_TRUE(w->run_until(State::fatal_error, 1));
  EXPECT_TRUE(w->has(FaultId::module_silent, other));
  EXPECT_FALSE(w->has(FaultId::module_silent, one));
  T::bring_back(*w, one);
  w->run(1);
  EXPECT_NE(w->answer(CommandKind::reset, Phase::completed), nullptr);
}

TYPED_TEST_P(SafetyResets, ALaterOneTakesItsPlaceAndBothModulesAreExcused) {
  using T = TypeParam;
  const std::uint16_t one = T::kResettable[0], other = T::kResettable[1];
  const auto w = in_reset<T>(one, 0.5);
  w->send(CommandKind::reset, {static_cast<double>(other)});
  w->executed = [&] { w->out_.command = {}; };
  w->step();
  w->executed = nullptr;
  T::take_away(*w, other);
  const Ack* superseded = w->answer(CommandKind::reset, Phase::superseded);
  ASSERT_NE(superseded, nullptr);
  EXPECT_EQ(superseded->verdict.reason, Reason::superseded);
  w->run(1);
  T::bring_back(*w, other);
  w->run(1);
  EXPECT_NE(w->answer(CommandKind::reset, Phase::completed), nullptr);
  expect_well<T>(*w);
  T::bring_back(*w, one);
  w->run(1);
  expect_well<T>(*w);
  EXPECT_EQ(try_start<T>(*w).reason, Reason::none);
}

// The order did not reach it, or another took its place.
TYPED_TEST_P(SafetyResets, ThatWasNotSeenFailsAndTheModuleIsNoFault) {
  using T = TypeParam;
  const std::uint16_t module = T::kResettable[0];
  const auto w = fresh<T>();
  w->run(6);
  w->executed = [&] { w->out_.command = {}; };  // it does not reach the module
  w->send(CommandKind::reset, {static_cast<double>(module)});
  w->run(reset_s<T>() + 1);
  const Ack* failed = w->answer(CommandKind::reset, Phase::failed);
  ASSERT_NE(failed, nullptr);
  EXPECT_EQ(failed->verdict.reason, Reason::not_reset);
  EXPECT_EQ(failed->verdict.subject, module);
  EXPECT_EQ(w->state(), State::idle);
  EXPECT_EQ(w->supervisor_.state().fault_count, 0u);
}

TYPED_TEST_P(SafetyResets, OfAModuleThatIsAwayBringsItBackAndSolveGoesOn) {
  using T = TypeParam;
  const std::uint16_t module = T::kResettable[1];
  const auto w = fresh<T>();
  w->run(6);
  T::take_away(*w, module);
  ASSERT_TRUE(w->run_until(State::fatal_error, 1));
  w->send(CommandKind::reset, {static_cast<double>(module)});
  w->run(1);
  T::bring_back(*w, module);
  ASSERT_TRUE(
      w->run_until([&] { return w->answer(CommandKind::reset, Phase::completed) != nullptr; }, 2));
  EXPECT_TRUE(is_solved<T>(*w));
}

TYPED_TEST_P(SafetyResets, AStartInTheSameFrameIsRefused) {
  using T = TypeParam;
  const auto w = fresh<T>();
  w->run(6);
  w->send(CommandKind::reset, {static_cast<double>(T::kResettable[0])});
  w->put(request_of(*T::logic().command(1)));
  w->step();
  EXPECT_EQ(w->state(), State::idle);
}

TYPED_TEST_P(SafetyResets, AModuleThatWasNeverHeardKeepsItInIdleAndIsNamed) {
  using T = TypeParam;
  for (const std::uint16_t module : T::kResettable) {
    SCOPED_TRACE(module);
    const auto w = fresh<T>();
    T::take_away(*w, module);
    w->run(1);
    const Verdict refused = try_start<T>(*w);
    EXPECT_EQ(refused.reason, Reason::never_heard);
    EXPECT_EQ(refused.subject, module);
    EXPECT_EQ(w->state(), State::idle);
  }
}

// [Oper-6]
TYPED_TEST_P(SafetyResets, AVitalModuleThatStaysAwayEndsInFatalErrorAgain) {
  using T = TypeParam;
  const auto w = moving<T>();
  ASSERT_NE(w, nullptr);
  std::uint16_t vital = T::kResettable[0];
  if constexpr (requires { T::kVital; }) vital = T::kVital;
  T::take_away(*w, vital);
  ASSERT_TRUE(w->run_until(State::fatal_error, 2));
  w->send(CommandKind::solve);
  w->step();
  ASSERT_EQ(w->state(), State::solve_errors);
  ASSERT_TRUE(w->run_until(State::fatal_error, 90));
  EXPECT_TRUE(stopped<T>(*w));
  const Ack* failed = w->answer(CommandKind::solve, Phase::failed);
  ASSERT_NE(failed, nullptr);
  EXPECT_EQ(failed->verdict.reason, Reason::not_solved);
  EXPECT_TRUE(stays_stopped<T>(*w, 2));
}

TYPED_TEST_P(SafetyResets, IsRefusedWhileItIsNotAtRestEverywhere) {
  using T = TypeParam;
  for (const auto& place : places<T>()) {
    if (place.state == State::idle || place.state == State::fatal_error) continue;
    SCOPED_TRACE(place.name);
    const auto w = at<T>(place);
    ASSERT_NE(w, nullptr);
    for (const double module : {0.0, static_cast<double>(T::kResettable[0])})
      EXPECT_EQ(w->why(CommandKind::reset, {module}), Reason::not_in_state);
  }
}

REGISTER_TYPED_TEST_SUITE_P(
    SafetyResets, OfAModuleIsNoEmergencyAndEndsWhenItIsBack,
    OfAllModulesEndsWithTheLastOfThemAndItMovesAfterIt, AModuleThatStaysAwayIsAFaultAtItsDeadline,
    AModuleThatWasNotCommandedIsAFaultAsEver, ALaterOneTakesItsPlaceAndBothModulesAreExcused,
    ThatWasNotSeenFailsAndTheModuleIsNoFault, OfAModuleThatIsAwayBringsItBackAndSolveGoesOn,
    AStartInTheSameFrameIsRefused, AModuleThatWasNeverHeardKeepsItInIdleAndIsNamed,
    AVitalModuleThatStaysAwayEndsInFatalErrorAgain, IsRefusedWhileItIsNotAtRestEverywhere);

}  // namespace lss::safety
