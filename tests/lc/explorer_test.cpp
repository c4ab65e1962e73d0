#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <array>
#include <set>
#include <string>
#include <vector>

#include "daemon/vehicles/zebro/modes.h"
#include "tools/lss-lc/vehicle.h"

namespace lss::zebro {
namespace {

constexpr std::uint16_t kTwoModules = 0x41;  // a leg and the panel

const lc::Verified& vehicle() { return *lc::verified_vehicle("zebro"); }
lc::Model model_of(const lc::Table& table, std::uint16_t modules = vehicle().modules) {
  return vehicle().model(table, modules);
}

std::string told(const lc::Exploration& e) {
  if (!e.violation) return "";
  std::string text = e.violation->property + "\n";
  lc::ControllerState state = model_of(kTable).begin;
  for (const lc::Happening h : e.violation->trace) {
    state = lc::step(kTable, state, h.event, h.subject).next;
    text += lc::text(vehicle(), h) + " -> " + lc::text(vehicle(), state) + "\n";
  }
  return text;
}

#ifndef LSS_SANITIZED  // for its time
TEST(Explorer, ThereAreNoFewerStatesThanInTheModelOfTheZebroThesis) {
  const lc::Exploration e = lc::explore(model_of(kTable));
  EXPECT_GE(e.states, 122'195U);
  EXPECT_LE(static_cast<double>(e.bytes) / static_cast<double>(e.states), 24);
}
#endif

// A toy table with a mistake three events deep: the trace is the shortest one.
TEST(Explorer, ABrokenPropertyComesWithItsShortestTrace) {
  lc::Model m = model_of(kTable, kTwoModules);
  static constexpr std::array kNever = {lc::StateProperty{
      "never a second strategy", "test",
      [](const lc::Table&, const lc::ControllerState& s) { return s.strategy < 2; }}};
  m.states = lc::state_properties<kNever>();
  const lc::Exploration e = lc::explore(m);
  ASSERT_TRUE(e.violation.has_value());
  EXPECT_EQ(e.violation->property, "never a second strategy");
  ASSERT_EQ(e.violation->trace.size(), 3U) << told(e);
  EXPECT_EQ(e.violation->trace[1].event, lc::Event::solve);
  EXPECT_EQ(e.violation->trace[2].event, lc::Event::next_strategy);
  EXPECT_FALSE(e.complete);
}

TEST(Explorer, MoreStatesThanAllowedIsNoVerdict) {
  const lc::Exploration e = lc::explore(model_of(kTable, kTwoModules), {.max_states = 100});
  EXPECT_FALSE(e.complete);
  EXPECT_FALSE(e.violation.has_value());
}

TEST(Explorer, NoStateIsLeftOut) {
  const lc::Model m = model_of(kTable, kTwoModules);
  std::set<lc::Key> seen{lc::pack(m.begin)};
  std::vector<lc::Key> left{lc::pack(m.begin)};
  while (!left.empty()) {
    const lc::ControllerState state = lc::unpack(left.back());
    left.pop_back();
    for (const lc::Happening h : m.happenings) {
      const lc::Key next = lc::pack(lc::step(kTable, state, h.event, h.subject).next);
      if (seen.insert(next).second) left.push_back(next);
    }
  }
  const lc::Exploration e = lc::explore(m);
  EXPECT_EQ(e.states, seen.size());
  EXPECT_EQ(e.transitions, seen.size() * m.happenings.size());
}

// Levels of this model fill several pieces, so that threads do share them.
TEST(Explorer, ThreadsChangeNothingInTheResult) {
  lc::Model m = model_of(kTable, kTwoModules);
  const auto expect_same = [](const lc::Exploration& a, const lc::Exploration& b) {
    EXPECT_EQ(a.states, b.states);
    EXPECT_EQ(a.transitions, b.transitions);
    EXPECT_EQ(a.taken, b.taken);
    EXPECT_EQ(a.depth, b.depth);
    EXPECT_EQ(a.row, b.row);
    EXPECT_EQ(a.complete, b.complete);
    EXPECT_EQ(told(a), told(b));
  };
  const lc::Exploration whole = lc::explore(m, {.threads = 1});
  EXPECT_GT(whole.states, 1000U);
  static constexpr std::array kNever = {
      lc::StepProperty{"never walking", "test", lc::kChange, [](const lc::Transition& t) {
                         return t.result.next.mode != static_cast<std::uint8_t>(Mode::walking);
                       }}};
  lc::Model broken = m;
  broken.steps = lc::step_properties<kNever>();
  lc::Model lost = m;  // a world that goes round in circles
  static constexpr std::array kNoReturn = {lc::Return{
      "back to SolveErrors", [](const lc::ControllerState& s) { return s.strategy == 6; },
      [](const lc::ControllerState& s) {
        return lc::Happening{s.strategy != 0 && s.silent == 0 ? lc::Event::next_strategy
                             : s.strategy != 0                ? lc::Event::unsolved
                             : s.state == State::fatal_error  ? lc::Event::solve
                                                              : lc::Event::emergency_stop,
                             0};
      }}};
  lost.returns = kNoReturn;
  const lc::Exploration one_broken = lc::explore(broken, {.threads = 1}),
                        one_lost = lc::explore(lost, {.threads = 1}),
                        one_part = lc::explore(m, {.max_states = 1000, .threads = 1});
  EXPECT_EQ(one_broken.violation.value().property, "never walking");
  EXPECT_EQ(one_lost.violation.value().property, "back to SolveErrors");
  for (const unsigned threads : {2U, 3U, 8U}) {
    expect_same(lc::explore(m, {.threads = threads}), whole);
    expect_same(lc::explore(broken, {.threads = threads}), one_broken);
    expect_same(lc::explore(lost, {.threads = threads}), one_lost);
    expect_same(lc::explore(m, {.max_states = 1000, .threads = threads}), one_part);
  }
}

TEST(Explorer, AllPropertiesInOneFunctionAreTheSameAsEachAlone) {
  static constexpr std::array kTwo = {
      lc::StepProperty{"a", "test", lc::kChange, [](const lc::Transition&) { return false; }},
      lc::StepProperty{"b", "test", lc::kLinks | lc::kActions,
                       [](const lc::Transition& t) { return t.result.row == 0; }}};
  constexpr lc::StepProperties kProperties = lc::step_properties<kTwo>();
  lc::Result result;
  for (result.row = 0; result.row < 2; ++result.row) {
    const lc::ControllerState before;
    const lc::Transition transition{kTable, before, {}, result};
    for (unsigned about = 0; about < lc::kAbouts; ++about) {
      const bool wanted =
          (about & lc::kChange) == 0 && ((about & ~unsigned{lc::kChange}) == 0 || result.row == 0);
      EXPECT_EQ(kProperties.all[about](transition), wanted) << about << ' ' << result.row;
    }
  }
}

TEST(Explorer, WhatDoesNotPackIsKnown) {
  EXPECT_TRUE(rc::check([] {
    const auto any = [](unsigned bits) {  // often with room, sometimes not
      return *rc::gen::inRange<unsigned>(0, (1U << bits) + 2);
    };
    lc::ControllerState s;
    s.state = static_cast<State>(any(2));
    s.mode = static_cast<std::uint8_t>(any(5));
    s.goal = static_cast<std::uint8_t>(any(4));
    s.links = static_cast<std::uint8_t>(any(3));
    s.strategy = static_cast<std::uint8_t>(any(3));
    s.flags = *rc::gen::arbitrary<std::uint8_t>();
    s.silent = static_cast<std::uint16_t>(any(2));
    s.unheard = static_cast<std::uint16_t>(any(2));
    s.isolated = static_cast<std::uint16_t>(any(2));
    RC_ASSERT(lc::packs(s) == (lc::unpack(lc::pack(s)) == s));
  }));
}

TEST(Explorer, AStateIsThePackedOneUnpacked) {
  EXPECT_TRUE(rc::check([] {
    lc::ControllerState s;
    s.state = static_cast<State>(*rc::gen::inRange(0, 4));
    s.mode = *rc::gen::inRange<std::uint8_t>(0, 32);
    s.goal = *rc::gen::inRange<std::uint8_t>(0, 16);
    s.flags = *rc::gen::arbitrary<std::uint8_t>();
    s.links = *rc::gen::inRange<std::uint8_t>(0, 8);
    s.strategy = *rc::gen::inRange<std::uint8_t>(0, 8);
    s.silent = *rc::gen::arbitrary<std::uint16_t>();
    s.unheard = static_cast<std::uint16_t>(*rc::gen::arbitrary<std::uint16_t>() & ~s.silent);
    s.isolated =
        static_cast<std::uint16_t>(*rc::gen::arbitrary<std::uint16_t>() & ~(s.silent | s.unheard));
    RC_ASSERT(lc::unpack(lc::pack(s)) == s);
  }));
}

}  // namespace
}  // namespace lss::zebro
