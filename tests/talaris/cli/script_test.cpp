#include "tools/lss-cli/talaris/script.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tools/lss-cli/show/failure.h"

namespace lss::cli::talaris {
namespace {

using lss::talaris::StepKind;
using testing::HasSubstr;
using testing::StartsWith;

std::string refusal(const char* text) {
  try {
    parse_script(text, "a.script");
  } catch (const Failure& e) {
    EXPECT_EQ(e.code(), ExitCode::usage);
    return e.what();
  }
  return "was taken";
}

TEST(Script, ALineIsATimeAndWhatIsDoneThen) {
  const auto steps = parse_script(
      "# two pulses, then the fans\n"
      "0      valves 1,3  for 100ms\n"
      "\n"
      "500ms  fans all    throttle 0.3   # slowly\n"
      "1min   fans 2      rpm 12000\n",
      "a.script");
  ASSERT_EQ(steps.size(), 3U);
  EXPECT_EQ(steps[0].line, 2);
  EXPECT_EQ(steps[0].kind, StepKind::pulse);
  EXPECT_EQ(steps[0].which, 0b101);
  EXPECT_DOUBLE_EQ(steps[0].value, 0.1);
  EXPECT_EQ(steps[1].kind, StepKind::throttle);
  EXPECT_EQ(steps[1].which, 0b1111);
  EXPECT_DOUBLE_EQ(steps[1].at_s, 0.5);
  EXPECT_EQ(steps[2].kind, StepKind::rpm);
  EXPECT_EQ(steps[2].which, 0b10);
  EXPECT_DOUBLE_EQ(steps[2].value, 12000);
  EXPECT_DOUBLE_EQ(steps[2].at_s, 60);
}

TEST(Script, WhatCannotBeReadIsReportedWithItsLine) {
  EXPECT_THAT(refusal("0 valves 1 for 0.1\n0 valves 9 for 0.1"), StartsWith("a.script:2: "));
  EXPECT_THAT(refusal("0 valves 1"), HasSubstr("five words"));
  EXPECT_THAT(refusal("0 wheels 1 for 0.1"), HasSubstr("wheels"));
  EXPECT_THAT(refusal("0 valves 1 rpm 3"), HasSubstr("valves ... rpm"));
  EXPECT_THAT(refusal("0 fans 5 throttle 0.1"), HasSubstr("1,2,3,4"));
  EXPECT_THAT(refusal("soon valves 1 for 0.1"), HasSubstr("soon"));
  EXPECT_THAT(refusal("0 valves 1 for long"), HasSubstr("long"));
  EXPECT_THAT(refusal("1 valves 1 for 0.1\n0 valves 2 for 0.1"), HasSubstr("back in time"));
}

TEST(Script, NothingToDoAndTooMuchToDoAreErrors) {
  EXPECT_THAT(refusal("# nothing\n"), HasSubstr("no line"));
  std::string many;
  for (int i = 0; i <= lss::talaris::kMaxScriptSteps; ++i) many += "0 valves 1 for 0.1\n";
  EXPECT_THAT(refusal(many.c_str()), HasSubstr("256"));
}

// With the lead of 5 s; the last line need not end last.
TEST(Script, LastsUntilTheEndOfWhatItDoesLast) {
  EXPECT_DOUBLE_EQ(duration_s(parse_script("0 valves 1 for 20s\n8s fans all rpm 12000\n", "a")),
                   25);
  EXPECT_DOUBLE_EQ(duration_s(parse_script("0 valves 1 for 2s\n8s fans all rpm 12000\n", "a")), 13);
}

}  // namespace
}  // namespace lss::cli::talaris
