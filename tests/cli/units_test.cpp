#include "tools/lss-cli/show/units.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <limits>

#include "idl/angles.h"
#include "tools/lss-cli/session/waker.h"
#include "tools/lss-cli/show/failure.h"
#include "tools/lss-cli/show/output.h"

namespace lss::cli {
namespace {

TEST(Screen, FitsTheTerminalWithItsMostImportantLinesFirst) {
  EXPECT_EQ(fitted("one\ntwo", 24, 80), "one\ntwo");
  EXPECT_EQ(fitted("one\ntwo\nthree\nfour", 3, 80),
            "one\ntwo\n... 2 more lines: make the window higher, or: lss-cli status");
  EXPECT_EQ(fitted("12345678\nabc", 24, 5), "12345\nabc");
  EXPECT_EQ(fitted("\x1b[1;31m12345678\x1b[0m", 24, 5), "\x1b[1;31m12345\x1b[0m");
  EXPECT_EQ(fitted("m/s\u00b2m/s\u00b2", 24, 5), "m/s\u00b2m");
}

TEST(Units, ATimeTooLongForTheClockLastsForYears) {
  constexpr std::chrono::hours kYears(20 * 365 * 24);
  for (const double s : {9.223e9, 1e10, 1e300, std::numeric_limits<double>::infinity()}) {
    EXPECT_TRUE(seconds(s) > kYears) << s;
    EXPECT_TRUE(Clock::now() + seconds(s) > Clock::now() + kYears) << s;
  }
  EXPECT_TRUE(seconds(0.2) == std::chrono::milliseconds(200));
  EXPECT_TRUE(seconds(86'400) == std::chrono::hours(24));
}

TEST(Units, AnAngleIsInDegreesUnlessItSaysOtherwise) {
  EXPECT_NEAR(parse_quantity("30", "rad", "heading"), 30 * kDegree, 1e-12);
  EXPECT_NEAR(parse_quantity("30deg", "rad", "heading"), 30 * kDegree, 1e-12);
  EXPECT_NEAR(parse_quantity("-12.5 deg", "rad", "heading"), -12.5 * kDegree, 1e-12);
  EXPECT_NEAR(parse_quantity("+90°", "rad", "heading"), 90 * kDegree, 1e-12);
  EXPECT_DOUBLE_EQ(parse_quantity("1.5rad", "rad", "heading"), 1.5);
}

TEST(Units, ATimeIsInSecondsUnlessItSaysOtherwise) {
  EXPECT_DOUBLE_EQ(parse_quantity("20", "s", "time"), 20);
  EXPECT_DOUBLE_EQ(parse_quantity("20s", "s", "time"), 20);
  EXPECT_DOUBLE_EQ(parse_quantity("500ms", "s", "time"), 0.5);
  EXPECT_DOUBLE_EQ(parse_quantity("1.5min", "s", "time"), 90);
  EXPECT_DOUBLE_EQ(parse_quantity("2h", "s", "time"), 7200);
}

TEST(Units, WhatIsNoFiniteNumberWithAKnownUnitIsAUsageError) {
  for (const char* text :
       {"", "abc", "nan", "inf", "-inf", "1e999", "30grad", "10 m", "s", "--5", "5s5"}) {
    for (const char* unit : {"rad", "s"}) {
      try {
        const double value = parse_quantity(text, unit, "it");
        ADD_FAILURE() << "'" << text << "' was read as " << value << " " << unit;
      } catch (const Failure& e) {
        EXPECT_EQ(e.code(), ExitCode::usage);
      }
    }
  }
  EXPECT_THROW(parse_quantity("3deg", "", "leg"), Failure);
  EXPECT_DOUBLE_EQ(parse_quantity("3 m/s", "m/s", "speed"), 3);
}

TEST(Units, ASetIsItsNumbersDividedByCommas) {
  EXPECT_EQ(parse_set("1,3,8", 0xFF, "valves"), 0x85);
  EXPECT_EQ(parse_set("2", 0x0F, "fans"), 2);
  EXPECT_EQ(format_quantity(0x85, "set"), "1,3,8");
  EXPECT_EQ(format_set(0), "none");
  for (const char* text : {"", "0", "9", "1,9", "1;3", "1 3", ",", "1,,3", "x", "-1", "1.5", "33"})
    EXPECT_THROW(parse_set(text, 0xFF, "valves"), Failure) << text;
}

RC_GTEST_PROP(Units, ASetThatIsShownReadsBackAsItself, ()) {
  const auto set = *rc::gen::inRange<std::uint64_t>(1, 256);
  RC_ASSERT(parse_set(format_set(set), 0xFF, "it") == static_cast<double>(set));
}

TEST(Units, ADurationIsLongerThanNothing) {
  EXPECT_THROW(parse_duration_s("0", "--for"), Failure);
  EXPECT_THROW(parse_duration_s("-5s", "--for"), Failure);
  EXPECT_DOUBLE_EQ(parse_duration_s("1ms", "--for"), 0.001);
}

RC_GTEST_PROP(Units, AnAngleThatIsShownReadsBackAsItself, ()) {
  const double degrees = *rc::gen::inRange(-3600, 3600) / 10.0;
  RC_ASSERT(std::abs(parse_quantity(format_quantity(degrees * kDegree, "rad"), "rad", "it") -
                     degrees * kDegree) < 1e-9);
}

TEST(Units, DurationsAreShownAsPeopleSayThem) {
  EXPECT_EQ(format_duration(0.43), "0.4 s");
  EXPECT_EQ(format_duration(12.3), "12 s");
  EXPECT_EQ(format_duration(200), "3 min 20 s");
  EXPECT_EQ(format_duration(7500), "2 h 5 min");
}

}  // namespace
}  // namespace lss::cli
