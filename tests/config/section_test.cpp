#include "daemon/config/section.h"

#include <gtest/gtest.h>

namespace lss::config {
namespace {

class SectionTest : public ::testing::Test {
 protected:
  Section read(std::string_view text) {
    table_ = toml::parse(text);
    return {&table_, "", "f.toml", errors_};
  }
  // What is said of a text when these keys are read.
  std::string errors_of(std::string_view text, std::initializer_list<const char*> keys) {
    Section s = read(text);
    for (const char* key : keys) s.number(key, 0, 0, 9);
    s.finish();
    return errors_.text();
  }
  toml::table table_;
  Errors errors_;
};

TEST_F(SectionTest, ValuesAreReadAndAbsentKeysFallBack) {
  Section s = read("a = 1.5\nb = 2\nc = true\nd = 'x'\ne = 'half'\nf = [1, 2]\ng = ['lo']");
  EXPECT_EQ(s.number("a", 0, 0, 2), 1.5);
  EXPECT_EQ(s.number("b", 0, 0, 2), 2.0);  // a whole number is a number too
  EXPECT_TRUE(s.flag("c", false));
  EXPECT_EQ(s.text("d", ""), "x");
  EXPECT_EQ(s.choice("e", 0, {"full", "half"}), 1u);
  EXPECT_EQ(s.integers("f", {}, 2, 0, 9), (std::vector<std::int64_t>{1, 2}));
  EXPECT_EQ(s.numbers("f", {}, 2, 0, 9), (std::vector<double>{1, 2}));
  EXPECT_EQ(s.numbers("none", {0.5}, 1, 0, 9), std::vector<double>{0.5});
  EXPECT_EQ(s.texts("g", {}), std::vector<std::string>{"lo"});
  EXPECT_EQ(s.number("none", 7, 0, 9), 7.0);
  EXPECT_EQ(s.integer("none", 8, 0, 9), 8);
  EXPECT_EQ(s.text("none", "z"), "z");
  s.finish();
  EXPECT_EQ(errors_.text(), "");
}

TEST_F(SectionTest, RangesIncludeTheirEnds) {
  Section s = read("a = 1\nb = 2.0");
  EXPECT_EQ(s.integer("a", 5, 1, 2), 1);
  EXPECT_EQ(s.number("b", 5, 1, 2), 2.0);
  EXPECT_TRUE(errors_.empty());
}

TEST_F(SectionTest, WrongValuesAreErrorsWithFileLineAndColumn) {
  Section s = read("a = 'x'\nb = 11\nc = 1.5\nd = 1");
  EXPECT_EQ(s.number("a", 3, 0, 9), 3.0);
  EXPECT_EQ(s.number("b", 4, 0, 10), 4.0);
  EXPECT_EQ(s.integer("c", 5, 0, 10), 5);
  EXPECT_EQ(s.flag("d", false), false);
  EXPECT_EQ(errors_.text(),
            "f.toml:1:5: a: is a text; a number is expected\n"
            "f.toml:2:5: b: 11 is out of range 0 to 10\n"
            "f.toml:3:5: c: is a number with a fraction; a whole number is expected\n"
            "f.toml:4:5: d: is a whole number; true or false is expected\n");
}

TEST_F(SectionTest, NotANumberAndInfinityAreErrors) {
  Section s = read("a = nan\nb = inf\nc = -inf");
  for (const char* key : {"a", "b", "c"}) EXPECT_EQ(s.number(key, 1, -1e300, 1e300), 1.0);
  EXPECT_EQ(errors_.text(),
            "f.toml:1:5: a: is not a finite number\n"
            "f.toml:2:5: b: is not a finite number\n"
            "f.toml:3:5: c: is not a finite number\n");
}

TEST_F(SectionTest, AWrongUnitIsNamedWithTheRightOne) {
  EXPECT_EQ(errors_of("period_s = 1\nspeed_rad_s = 2\nbaud_Hz = 3\ntrack = 4",
                      {"period_ms", "speed_deg_s", "baud", "track_mm"}),
            "f.toml:1:1: unknown key period_s; unit of period is ms here: period_ms\n"
            "f.toml:2:1: unknown key speed_rad_s; unit of speed is deg/s here: speed_deg_s\n"
            "f.toml:3:1: unknown key baud_Hz; baud has no unit here: baud\n"
            "f.toml:4:1: unknown key track; unit of track is mm here: track_mm\n");
}

TEST_F(SectionTest, AnUnknownKeyIsNamedWithTheNearestKnownOne) {
  EXPECT_EQ(errors_of("polcy = 1\nzzzzzzzz = 2", {"policy", "rate"}),
            "f.toml:1:1: unknown key polcy; did you mean policy?\n"
            "f.toml:2:1: unknown key zzzzzzzz; known here: policy, rate\n");
}

TEST_F(SectionTest, ASectionThatGoesOutOfScopeReportsItsUnknownKeysOnce) {
  {
    Section root = read("[frame]\nperid_ms = 1");
    Section frame = root.section("frame");
    frame.number("period_ms", 0, 0, 9);
    frame.finish();
    frame.finish();
    Section moved = std::move(frame);
  }
  EXPECT_EQ(errors_.text(),
            "f.toml:2:1: unknown key perid_ms in [frame]; did you mean period_ms?\n");
}

TEST_F(SectionTest, AnUnknownTableIsAnErrorAtItsHeader) {
  read("\n[frme]\nperiod_ms = 1\n[[prt]]\n[zebro.bs]").section("frame");
  const std::string text = errors_.text();
  EXPECT_NE(text.find("f.toml:2:2: unknown table frme; did you mean frame?"), std::string::npos)
      << text;
  EXPECT_NE(text.find("f.toml:4:3: unknown table prt"), std::string::npos) << text;
  EXPECT_NE(text.find("f.toml:5:2: unknown table zebro"), std::string::npos) << text;
}

TEST_F(SectionTest, AMissingTableReadsAsEmptyAndItsErrorsAreItsParents) {
  Section root = read("a = 1");
  root.skip("a");
  Section child = root.section("child");
  EXPECT_EQ(child.number("x", 3, 0, 9), 3.0);
  EXPECT_EQ(child.required_text("y"), "");
  EXPECT_EQ(errors_.text(), "f.toml:1:1: child.y: is missing; it has no default\n");
}

TEST_F(SectionTest, TablesAndValuesInEachOthersPlaceAreErrors) {
  Section root = read("frame = 3\n[port]\nname = 'x'\n[[dds]]\na = 1");
  root.section("frame");
  root.section("dds");
  EXPECT_TRUE(root.sections("port").empty());
  EXPECT_EQ(errors_.text(),
            "f.toml:1:9: frame: is a whole number; a table, [frame], is expected\n"
            "f.toml:2:1: port: is a table; a list of tables, [[port]], is expected\n"
            "f.toml:4:1: dds: is an array; a table, [dds], is expected\n");
}

TEST_F(SectionTest, ListsHaveTheirLengthTypeAndRangeChecked) {
  Section s = read("a = [1, 2]\nb = [1, 'x', 3]\nc = [1, 2, 300]\nd = [1]\ne = 'lo'");
  for (const char* key : {"a", "b", "c"}) s.integers(key, {7, 8, 9}, 3, 0, 255);
  EXPECT_EQ(s.texts("d", {"lo"}), std::vector<std::string>{"lo"});
  s.texts("e", {});
  EXPECT_EQ(errors_.text(),
            "f.toml:1:5: a: must be a list of 3 whole numbers\n"
            "f.toml:2:5: b: must be a list of 3 whole numbers\n"
            "f.toml:3:5: c: 300 is out of range 0 to 255\n"
            "f.toml:4:5: d: must be a list of texts in quotes\n"
            "f.toml:5:5: e: must be a list of texts in quotes\n");
}

TEST_F(SectionTest, ListsOfNumbersHaveTheirLengthTypeAndRangeChecked) {
  Section s = read("a = [0.5, 1]\nb = [0.5, 'x']\nc = [0.5]\nd = [0.5, 3]\ne = [0.5, nan]");
  EXPECT_EQ(s.numbers("a", {}, 2, 0, 1), (std::vector<double>{0.5, 1}));
  for (const char* key : {"b", "c", "d", "e"})
    EXPECT_EQ(s.numbers(key, {7, 8}, 2, 0, 1), (std::vector<double>{7, 8}));
  EXPECT_EQ(errors_.text(),
            "f.toml:2:5: b: must be a list of 2 numbers\n"
            "f.toml:3:5: c: must be a list of 2 numbers\n"
            "f.toml:4:5: d: 3 is out of range 0 to 1\n"
            "f.toml:5:5: e: nan is out of range 0 to 1\n");
}

TEST_F(SectionTest, AWrongChoiceIsNamedWithTheNearestOrAllOfThem) {
  Section s = read("a = 'hlf'\nb = 'other'");
  EXPECT_EQ(s.choice("a", 0, {"full", "half"}), 0u);
  EXPECT_EQ(s.choice("b", 1, {"full", "half"}), 1u);
  EXPECT_EQ(errors_.text(),
            "f.toml:1:5: a: \"hlf\" is no choice; did you mean \"half\"?\n"
            "f.toml:2:5: b: \"other\" is no choice; choose one of: full, half\n");
}

TEST_F(SectionTest, AnErrorOfTheWholeTableIsAtItsHeader) {
  Section root = read("\n[gait]\n");
  root.section("gait").error("", "does not fit");
  EXPECT_EQ(errors_.text(), "f.toml:2:1: gait: does not fit\n");
}

TEST_F(SectionTest, ErrorsComeInTheOrderOfTheFile) {
  Section s = read("a = 1\nb = 2");
  s.error("b", "second");
  s.error("a", "first");
  EXPECT_EQ(errors_.text(), "f.toml:1:5: a: first\nf.toml:2:5: b: second\n");
  s.skip("a");
  s.skip("b");
}

}  // namespace
}  // namespace lss::config
