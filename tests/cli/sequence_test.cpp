#include "tools/lss-cli/verbs/sequence.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/own_domain.h"
#include "tools/lss-cli/show/failure.h"
#include "tools/lss-cli/verbs/steps.h"

namespace lss::cli {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::StartsWith;

// In the company of no daemon.
std::vector<Step> steps_of(std::string_view text, const std::string& name) {
  Options options;
  options.domain = testing_support::own_domain();
  options.timeout_s = 0.1;
  Context context(options);
  return parse_steps(context, text, name);
}

TEST(Sequence, CommandsEndAtSemicolonsAndLineEnds) {
  const std::vector<Line> lines =
      parse_sequence("start; stand\n\n  walk forward --for 10s ;; stop", "-e");
  ASSERT_EQ(lines.size(), 4U);
  EXPECT_THAT(lines[0].words, ElementsAre("start"));
  EXPECT_THAT(lines[2].words, ElementsAre("walk", "forward", "--for", "10s"));
  EXPECT_EQ(lines[1].number, 1);
  EXPECT_EQ(lines[2].number, 3);
}

TEST(Sequence, CommentsAreLeftOutAndQuotesKeepBlanks) {
  const std::vector<Line> lines =
      parse_sequence("# patrol; of the north\nwait '5 s' # rest\nsay \"a;b\" c#d", "f");
  ASSERT_EQ(lines.size(), 2U);
  EXPECT_THAT(lines[0].words, ElementsAre("wait", "5 s"));
  EXPECT_THAT(lines[1].words, ElementsAre("say", "a;b", "c#d"));
}

// The failure of a call; one that says so when there is none.
Failure failure_of(const std::function<void()>& call) {
  try {
    call();
  } catch (const Failure& e) {
    return e;
  }
  return Failure(ExitCode::completed, "was taken", "");
}

TEST(Sequence, AnOpenQuoteIsAnErrorWithItsLine) {
  const Failure e = failure_of([] { parse_sequence("start\nwait '5 s\nstop", "patrol.lss"); });
  EXPECT_EQ(e.code(), ExitCode::usage);
  EXPECT_THAT(e.what(), StartsWith("patrol.lss:2: "));
}

TEST(Sequence, AVerbThatNobodyKnowsIsAnErrorWithItsLineBeforeAnythingIsDone) {
  const Failure e = failure_of([] { steps_of("start\nstand\nwlak forward", "patrol.lss"); });
  EXPECT_EQ(e.code(), ExitCode::unknown_name);
  EXPECT_THAT(e.what(), StartsWith("patrol.lss:3: "));
  EXPECT_THAT(e.advice(), HasSubstr("walk"));
}

TEST(Sequence, AWrongParameterIsAnErrorWithItsLineBeforeAnythingIsDone) {
  const Failure e = failure_of([] { steps_of("start; stand\nwalk --heading 120", "patrol.lss"); });
  EXPECT_EQ(e.code(), ExitCode::usage);
  EXPECT_THAT(e.what(), StartsWith("patrol.lss:2: "));
}

TEST(Sequence, TheOptionsOfTheWholeProgramBelongToTheProgram) {
  EXPECT_THROW(steps_of("walk forward --domain 3", "-e"), Failure);
  EXPECT_THROW(steps_of("run other.lss", "-e"), Failure);
}

TEST(Sequence, IsRefusedAboveItsLimits) {
  EXPECT_THAT(failure_of([] { read_input("/dev/zero"); }).what(),
              HasSubstr("is larger than 1000000 bytes"));
  std::string many;
  for (int i = 0; i < 1001; ++i) many += "stop\n";
  EXPECT_THAT(failure_of([&] { steps_of(many, "f"); }).what(),
              HasSubstr("f has more than 1000 verbs"));
}

}  // namespace
}  // namespace lss::cli
