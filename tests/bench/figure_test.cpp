// When a figure of lss-bench has met its goal, and the kernel that the document names.

#include <gtest/gtest.h>

#include "tests/bench/programs.h"
#include "tests/bench/report.h"

namespace lss::bench {
namespace {

std::optional<Met> met(double ratio, double aa_ratio, double goal) {
  Figure f = figure_of("i", "wake-up", "us", ratio, 1, goal);
  f.aa_ratio = aa_ratio;
  return f.met();
}

TEST(Figure, IsUndecidedWhenTheReferenceDiffersFromItselfByMoreThanTheRatioFromItsGoal) {
  EXPECT_EQ(met(1.039, 1.001, 1.05), Met::yes);
  EXPECT_EQ(met(1.039, 1.199, 1.05), Met::undecided);
  EXPECT_EQ(met(1.039, 1 / 1.199, 1.05), Met::undecided) << "either way";
  EXPECT_EQ(met(1.061, 1.005, 1.05), Met::no);
  EXPECT_EQ(met(1.061, 1.199, 1.05), Met::undecided);
  EXPECT_EQ(met(0.5, 1.199, 1.05), Met::yes);
}

// Two runs that shared one had two vehicles of one name on it: seen as a failed bench.growth.
TEST(Domain, OfARunIsItsOwnUntilItEnds) {
  std::vector<int> domains;
  for (const int index : {0, 1, 7}) {
    domains.push_back(domain(index));
    EXPECT_EQ(domain(index), domains.back());
    const std::string path = "/tmp/lss-e2e-domain-" + std::to_string(domains.back()) + ".lock";
    const int file = ::open(path.c_str(), O_RDWR | O_CLOEXEC);
    ASSERT_GE(file, 0) << path;
    EXPECT_NE(::flock(file, LOCK_EX | LOCK_NB), 0) << "another run could take " << path;
    ::close(file);
  }
  EXPECT_TRUE(domains[0] != domains[1] && domains[1] != domains[2] && domains[2] != domains[0]);
}

TEST(Cycles, ThatDidNotEndCountAsAWholePeriod) {
  const Cycles all = with_incomplete({16'900, 17'000, 17'000, 17'000, 17'040}, 20'000);
  EXPECT_EQ(all.us, (Samples{17'000, 20'000, 20'000, 17'040}));
  EXPECT_EQ(all.incomplete, 2);
  EXPECT_EQ(median(all.us), 20'000) << "half of them took longer";
}

TEST(Figure, WithoutAReferenceOfItsOwnIsJudgedAsItIs) {
  EXPECT_EQ(met(1.039, kNone, 1.05), Met::yes);
  EXPECT_EQ(met(1.051, kNone, 1.05), Met::no);
  EXPECT_EQ(met(1.039, 1.199, kNone), std::nullopt);
  Figure absolute = figure_of("ii", "sigma", "us", 59, 20, 60);
  absolute.absolute = true;
  absolute.aa_ratio = 2;
  EXPECT_EQ(absolute.met(), Met::yes);
}

TEST(Report, NamesThePreemptionThatTheVersionOfTheKernelStates) {
  EXPECT_EQ(preemption("#1 SMP PREEMPT_RT Debian 6.12.57-1"), "PREEMPT_RT");
  EXPECT_EQ(preemption("#1 SMP PREEMPT_DYNAMIC Debian 6.12.57-1"),
            "PREEMPT_DYNAMIC, not PREEMPT_RT");
  EXPECT_EQ(preemption("#1 SMP Debian 5.10.0-1"), "not PREEMPT_RT");
}

}  // namespace
}  // namespace lss::bench
