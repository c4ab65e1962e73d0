#include "tools/lss-sim/frame/faults.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tools/lss-sim/frame/runner.h"
#include "tools/lss-sim/zebro/vehicle.h"

namespace lss::sim {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

class Faults : public testing::Test {
 protected:
  Fault parse(const char* text) { return parse_fault(text, kinds_).value(); }
  std::string wrong(const char* text) {
    const auto fault = parse_timed_fault(text, kinds_);
    return fault ? "accepted" : fault.error();
  }

  std::unique_ptr<VehicleKind> vehicle_ = make_zebro_kind();
  std::vector<FaultKind> kinds_ = fault_kinds_of(*vehicle_);
};

TEST_F(Faults, TimesAreReadWithTheirUnits) {
  EXPECT_DOUBLE_EQ(parse_timed_fault("5s:module-dead:3", kinds_)->at_s, 5);
  EXPECT_DOUBLE_EQ(parse_timed_fault("0.5s:bus-cut", kinds_)->at_s, 0.5);
  EXPECT_DOUBLE_EQ(parse_timed_fault("500ms:bus-cut", kinds_)->at_s, 0.5);
  EXPECT_DOUBLE_EQ(parse_timed_fault("2min:clear", kinds_)->at_s, 120);
}

TEST_F(Faults, ArgumentsAreReadAndOptionalOnesHaveDefaults) {
  EXPECT_THAT(parse("noise:0.01").values, ElementsAre(0.01));
  EXPECT_THAT(parse("over-current:2").values, ElementsAre(2, 1.0));
  EXPECT_THAT(parse("over-current:2:0.7").values, ElementsAre(2, 0.7));
  EXPECT_THAT(parse("temperature:3:-40").values, ElementsAre(3, -40));
}

TEST_F(Faults, EveryKindReadsBackWhatItWrites) {
  for (const FaultKind& kind : kinds_) {
    Fault fault{.kind = &kind, .values = {}, .clear = false};
    for (const FaultArgument& argument : kind.arguments) fault.values.push_back(argument.max);
    const auto again = parse_fault(to_text(fault), kinds_);
    ASSERT_TRUE(again) << again.error();
    EXPECT_EQ(again->kind, fault.kind);
    EXPECT_EQ(again->values, fault.values);
  }
}

TEST_F(Faults, AnUnknownKindIsRefusedWithTheNearestNameAndTheList) {
  EXPECT_THAT(wrong("5s:modul-ded:3"), HasSubstr("did you mean 'module-dead'"));
  EXPECT_THAT(wrong("5s:xyzzy"), HasSubstr("hall-lost"));
  EXPECT_THAT(wrong("5s:xyzzy"), testing::Not(HasSubstr("did you mean")));
}

TEST_F(Faults, WrongArgumentsAreRefusedWithTheirRange) {
  for (const auto& [text, said] : {std::pair{"5s:module-dead:8", "from 1 to 7"},
                                   {"5s:module-dead:1.5", "whole number"},
                                   {"5s:module-dead", "needs N"},
                                   {"5s:noise:nan", "must be a number from 0 to 1"},
                                   {"5s:noise:0.1x", "must be a number"},
                                   {"5s:bus-cut:1", "too many arguments"}}) {
    EXPECT_THAT(wrong(text), HasSubstr(said)) << text;
  }
}

TEST_F(Faults, AMissingOrSenselessTimeIsRefused) {
  for (const char* text :
       {"", ":", "module-dead:3", "5:noise:1", "-5s:noise:1", "s:noise:1", "5s"}) {
    EXPECT_THAT(wrong(text), HasSubstr("TIME:KIND")) << text;
  }
}

class Board : public Faults {
 protected:
  std::vector<std::string> acts_;
  bool in_force_ = true;
  FaultBoard board_{[this](const Fault& fault, bool attach) {
                      acts_.push_back((attach ? "+" : "-") + to_text(fault));
                    },
                    [this](const Fault&) { return in_force_; }};
};

TEST_F(Board, KeepsEachModulesFaultAndReplacesItsOwn) {
  board_.inject(parse("module-dead:3"));
  board_.inject(parse("module-dead:4"));
  board_.inject(parse("temperature:3:50"));
  board_.inject(parse("temperature:3:60"));
  EXPECT_THAT(board_.attached(), ElementsAre("module-dead:3", "module-dead:4", "temperature:3:60"));
}

TEST_F(Board, ClearsOneUnitOneKindOrAll) {
  for (const char* text : {"module-dead:3", "module-dead:4", "noise:0.5", "bus-cut"}) {
    board_.inject(parse(text));
  }
  board_.inject(parse("clear:module-dead:4"));
  EXPECT_THAT(board_.attached(), ElementsAre("module-dead:3", "noise:0.5", "bus-cut"));
  board_.inject(parse("clear:noise"));
  EXPECT_THAT(board_.attached(), ElementsAre("module-dead:3", "bus-cut"));
  acts_.clear();
  board_.inject(parse("clear"));
  EXPECT_THAT(board_.attached(), IsEmpty());
  EXPECT_THAT(acts_, ElementsAre("-module-dead:3", "-bus-cut"));
}

TEST_F(Board, AMomentaryFaultActsButDoesNotStay) {
  board_.inject(parse("module-reset:3"));
  EXPECT_THAT(acts_, ElementsAre("+module-reset:3"));
  EXPECT_THAT(board_.attached(), IsEmpty());
}

TEST_F(Board, DropsAFaultThatEndedByItself) {
  board_.inject(parse("driver-fault:2"));
  in_force_ = false;
  EXPECT_THAT(board_.attached(), IsEmpty());
}

}  // namespace
}  // namespace lss::sim
