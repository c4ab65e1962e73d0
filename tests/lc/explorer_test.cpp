#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <algorithm>
#include <array>
#include <string>

#include "daemon/vehicles/zebro_modes.h"
#include "tools/lss-lc/mutations.h"
#include "tools/lss-lc/zebro.h"

namespace lss::zebro {
namespace {

#ifdef LSS_SANITIZED
constexpr bool kSlow = true;
#else
constexpr bool kSlow = false;
#endif
constexpr std::uint16_t kTwoModules = 0x41;  // a leg and the panel
constexpr std::uint16_t kModulesHere = kSlow ? kTwoModules : kAllModules;

std::string told(const lc::Exploration& e) {
  if (!e.violation) return "";
  std::string text = e.violation->property + "\n";
  lc::ControllerState state = model_of(kTable, kModulesHere).begin;
  for (const lc::Happening h : e.violation->trace) {
    state = lc::step(kTable, state, h.event, h.subject).next;
    text += lss::zebro::text(kTable, h) + " -> " + lss::zebro::text(state) + "\n";
  }
  return text;
}

// [Des-1] [Prod-1] [Prod-3] [Func-5] [Oper-5] [Oper-6] [Oper-7] [Conf-3]
TEST(Explorer, EveryPropertyHoldsInEveryReachableState) {
  const lc::Exploration e = lc::explore(model_of(kTable, kModulesHere));
  EXPECT_TRUE(e.complete) << told(e);
  EXPECT_EQ(std::count(e.row.begin(), e.row.end(), 0U), 0) << "rows that nothing ever takes";
  if (kSlow) return;
  EXPECT_GE(e.states, 122'195U) << "no fewer than the model of the Zebro thesis has";
  EXPECT_LE(static_cast<double>(e.octets) / static_cast<double>(e.states), 24);
}

#ifndef LSS_SANITIZED  // for its time
TEST(Explorer, EveryBrokenTransitionOfTheTableIsNoticed) {
  const lc::Mutations m = lc::mutate(
      kTable, [](const lc::Table& table) { return model_of(table, kTwoModules); },
      static_cast<std::uint8_t>(std::size(kModeNames)), static_cast<std::uint8_t>(Goal::leg) + 1);
  EXPECT_GT(m.count, 1500U);
  EXPECT_EQ(m.caught + m.equivalent, m.count);
  for (const std::string& survivor : m.survivors) ADD_FAILURE() << "not noticed: " << survivor;
}
#endif

// A toy table with a mistake three events deep: the trace is the shortest one.
TEST(Explorer, ABrokenPropertyComesWithItsShortestTrace) {
  lc::Model m = model_of(kTable, kTwoModules);
  static const std::array kNever = {lc::StateProperty{
      "never solving with an isolated leg", "test",
      [](const lc::Table&, const lc::ControllerState& s) { return s.isolated == 0; }}};
  m.states = kNever;
  const lc::Exploration e = lc::explore(m);
  ASSERT_TRUE(e.violation.has_value());
  EXPECT_EQ(e.violation->property, "never solving with an isolated leg");
  ASSERT_EQ(e.violation->trace.size(), 3U) << told(e);
  EXPECT_EQ(e.violation->trace[1].event, lc::Event::solve);
  EXPECT_EQ(e.violation->trace[2].event, event::isolate);
  EXPECT_FALSE(e.complete);
}

TEST(Explorer, MoreStatesThanAllowedIsNoVerdict) {
  const lc::Exploration e = lc::explore(model_of(kTable, kTwoModules), 100);
  EXPECT_FALSE(e.complete);
  EXPECT_FALSE(e.violation.has_value());
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
