// Supervisor, watch and solver of Lunar Zebro together: every property is satisfied when one thing
// fails, and two; and the exploration finds defects that are planted in them.

#include <gtest/gtest.h>

#include <algorithm>
#include <ostream>
#include <string>
#include <vector>

#include "tests/support/everything.h"
#include "tools/lss-lc/zebro/composed.h"

namespace lss::zebro {
namespace {

using lc::Event;
using lc::Row;

std::string told(const lc::Composition& c) {
  if (!c.violation) return "";
  std::string text = c.violation->property + "\n";
  for (const std::string& line : c.violation->trace) text += line + "\n";
  return text;
}

// [Oper-5] [Oper-6] [Conf-3] [O-Int-2] [P-Int-2]
TEST(Composition, EachSingleFailureAtEachStepIsAnsweredInTimeAndEndsWell) {
  const lc::Composition c = compose({.failures = 1});
  EXPECT_FALSE(c.violation) << told(c);
  EXPECT_GT(c.choices, 5000U);
}

#ifndef LSS_SANITIZED  // for its time
// By the kind of the first one, of LF or LM; the second one of these or of the rest.
class TwoFailures : public testing::TestWithParam<std::size_t> {};

TEST_P(TwoFailures, AreAnsweredInTimeAndEndWell) {
  LSS_SKIP_OUTSIDE_SAMPLE(GetParam(), kFailures);
  const lc::Depth depth{
      .failures = 2, .every = false, .only = kFailureNames[GetParam()], .modules = 0x05};
  const lc::Composition c = compose(depth);
  EXPECT_FALSE(c.violation) << told(c);
  const bool often = depth.only == "silent" || depth.only == "jammed";
  EXPECT_GT(c.choices, often ? 10'000U : 1000U);
}

INSTANTIATE_TEST_SUITE_P(Composition, TwoFailures, testing::Range(std::size_t{0}, kFailures),
                         [](const auto& of) {
                           std::string name = kFailureNames[of.param];
                           std::ranges::replace(name, ' ', '_');
                           return name;
                         });
#endif

// A defect of one part, its property, and the failure in which it shows. Those of the code:
// planted/planted.py.
struct Defect {
  using Options = void (*)(Composed::Options&);  // of times that the parts are given
  using Rows = void (*)(Row&);                   // of the supervisor's table

  Defect(const char* called, const char* of, const char* by, Options altered)
      : name(called), property(of), failure(by), options(altered) {}
  Defect(const char* called, const char* of, const char* by, Rows altered, unsigned several = 1)
      : name(called), property(of), failure(by), row(altered), failures(several) {}

  const char* name;
  const char* property;
  const char* failure;
  Options options = nullptr;
  Rows row = nullptr;
  unsigned failures = 1;

  friend void PrintTo(const Defect& defect, std::ostream* out) { *out << defect.name; }
};

void drop(Row& row, Event event, State state) {
  if (row.event == event) row.from = static_cast<lc::StateSet>(row.from & ~lc::in(state));
}
void without(Row& row, Event event, lc::ActionSet actions) {
  if (row.event == event) row.actions &= ~actions;
}

const Defect kDefects[] = {
    {"watch gives a silent module twice the time",
     "each loss leads to a safe state within its time", "silent",
     [](Composed::Options& o) { o.parameters.module_silent_ns *= 2; }},
    {"watch gives a late movement six times the time",
     "each loss leads to a safe state within its time", "frozen",
     [](Composed::Options& o) { o.parameters.locomotion.late_limit_s *= 6; }},
    {"supervisor gives a lost client twice the time",
     "each loss leads to a safe state within its time", "client lost",
     [](Composed::Options& o) { o.lease_ms *= 2; }},
    {"supervisor ignores a lost client", "each loss leads to a safe state within its time",
     "client lost", [](Row& r) { drop(r, Event::lease_expired, State::operational); }},
    {"supervisor ignores fatal faults in operation",
     "each loss leads to a safe state within its time", "jammed",
     [](Row& r) { drop(r, Event::emergency, State::operational); }},
    {"supervisor does not obey an emergency stop while errors are solved",
     "an emergency stop is obeyed from each state", "emergency stop",
     [](Row& r) { drop(r, Event::emergency_stop, State::solve_errors); }, 2},
    {"supervisor's emergency stop stops no module", "an emergency stop is obeyed from each state",
     "emergency stop",
     [](Row& r) {
       without(r, Event::emergency_stop, lc::kEmergencyStop);
       without(r, Event::emergency, lc::kEmergencyStop);  // the fault that goes with it
     }},
    {"solver has twice the time", "no endless solving", "unplugged",
     [](Composed::Options& o) { o.parameters.solver.budget_ns *= 2; }},
    {"solver is not ended when it gave up", "no endless solving", "unplugged",
     [](Row& r) { drop(r, Event::unsolved, State::solve_errors); }},
    {"solver reports success when it gave up", "solved is what is solved", "unplugged",
     [](Row& r) {
       if (r.event == Event::unsolved) r.to = State::idle;
     }},
    {"isolation is not applied",
     "whatever can be isolated and leaves a gait ends in Operational again", "silent",
     [](Row& r) { without(r, event::isolate, lc::kIsolate); }},
    // The gate closes: Idle is never reached.
    {"a stop leaves the motors on",
     "whatever can be isolated and leaves a gait ends in Operational again", "silent",
     [](Row& r) { without(r, event::motion_done, lc::kMotorsOff); }},
};

class PlantedDefect : public testing::TestWithParam<Defect> {};

TEST_P(PlantedDefect, IsFoundByTheExploration) {
  const Defect& defect = GetParam();
  std::vector<Row> common(lc::kCommonRows.rows.begin(), lc::kCommonRows.rows.end()),
      own(kTable.rows->rows.begin(), kTable.rows->rows.end());
  for (std::vector<Row>* rows : {&common, &own}) {
    for (Row& row : *rows) {
      if (defect.row) defect.row(row);
    }
  }
  const lc::Rows common_rows(common), own_rows(own);
  lc::Table table = kTable;
  table.common = &common_rows;
  table.rows = &own_rows;
  Logic logic = zebro::logic();
  logic.table = &table;
  Composed::Options options{.logic = &logic};
  if (defect.options) defect.options(options);
  const lc::Composition c =
      compose({.failures = defect.failures, .every = false, .only = defect.failure}, options);
  ASSERT_TRUE(c.violation.has_value());
  EXPECT_EQ(c.violation->property, defect.property) << told(c);
  EXPECT_FALSE(c.violation->trace.empty());
}

INSTANTIATE_TEST_SUITE_P(Zebro, PlantedDefect, testing::ValuesIn(kDefects), [](const auto& of) {
  std::string name;
  bool begins = true;
  for (const char c : std::string(of.param.name)) {
    const bool letter = std::isalpha(static_cast<unsigned char>(c)) != 0;
    if (letter) name += begins ? static_cast<char>(std::toupper(static_cast<unsigned char>(c))) : c;
    begins = !letter;
  }
  return name;
});

}  // namespace
}  // namespace lss::zebro
