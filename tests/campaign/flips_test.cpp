// Some flipped bits of each vehicle; `lss-campaign --flips` flips tens of thousands.

#include "tests/campaign/flips.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <stdexcept>
#include <string>

#include "tests/campaign/campaign.h"

namespace lss::campaign {
namespace {

class FlippedBits : public testing::TestWithParam<std::size_t> {
 protected:
  FlipCounts flip(const FlipPlan& plan) { return subjects()[GetParam()].flip(plan); }
  // Each flip in this part has one of these outcomes.
  void expect_all(unsigned flips, const char* part, std::initializer_list<FlipOutcome> outcomes) {
    const FlipCounts counts = flip({.flips = flips, .part = part});
    std::uint64_t found = 0;
    for (const FlipOutcome outcome : outcomes)
      found += counts.state[static_cast<std::size_t>(outcome)];
    EXPECT_EQ(found, flips) << flip_table(subjects()[GetParam()].vehicle, counts);
  }
};

// Any bit of it, wherever it is: also padding is compared.
TEST_P(FlippedBits, InTheVehicleAreAllCorrected) {
  expect_all(200, "vehicle", {FlipOutcome::corrected});
}

TEST_P(FlippedBits, InTheSupervisorReachNoBus) {
  expect_all(60, "supervisor", {FlipOutcome::corrected, FlipOutcome::none});
}

// The orders wait for their release; what is beside them goes to no bus.
TEST_P(FlippedBits, InTheOrdersReachNoBus) { expect_all(200, "outputs", {FlipOutcome::none}); }

// A run ends as soon as nothing is left of its flip; where only the bit is left, it goes on with
// others.
TEST_P(FlippedBits, HaveTheOutcomeThatTheWholeRunHas) {
  for (const bool protect : {false, true}) {
    FlipPlan plan{.seed = 2, .flips = 24, .to_the_end = true, .protect = protect, .part = "state"};
    const FlipCounts whole = flip(plan);
    plan.to_the_end = false;
    EXPECT_EQ(flip(plan).parts, whole.parts);
  }
}

TEST_P(FlippedBits, AreRefusedForAPartThatIsNotThere) {
  EXPECT_THROW(flip({.flips = 1, .part = "none"}), std::invalid_argument);
}

INSTANTIATE_TEST_SUITE_P(Vehicles, FlippedBits, testing::Range(std::size_t{0}, subjects().size()),
                         [](const auto& which) {
                           return std::string(subjects()[which.param].vehicle);
                         });

TEST(Flips, HaveTheWilsonInterval) {
  const Interval none = wilson(0, 100), half = wilson(50, 100);  // Wilson 1927, z = 1.96
  EXPECT_EQ(none.low, 0);
  EXPECT_NEAR(none.high, 0.0370, 1e-4);
  EXPECT_NEAR(half.low, 0.4038, 1e-4);
  EXPECT_NEAR(half.high, 0.5962, 1e-4);
}

TEST(Flips, FindTheDaemonsFunctionsAndNoneOfTheTests) {
  bool step = false;
  for (const FlipPart& part : program_parts()) {
    step = step || part.name.starts_with("lss::lc::step(");
    EXPECT_EQ(part.name.find("lss::sim::"), std::string::npos) << part.name;
    EXPECT_FALSE(part.name.starts_with("lss::campaign::")) << part.name;
  }
  EXPECT_TRUE(step);
}

TEST(Flips, ACopyThatAbortsOrHangsCountsAsRestarted) {
  EXPECT_EQ(in_a_copy([]() -> FlipResult { std::abort(); }, 1).outcome, FlipOutcome::restarted);
  EXPECT_EQ(in_a_copy([]() -> FlipResult { throw 1; }, 1).outcome, FlipOutcome::restarted);
  EXPECT_FALSE(in_a_copy([]() -> FlipResult { std::abort(); }, 1).hung);
  const auto hang = []() -> FlipResult {
    for (volatile int i = 0;;) static_cast<void>(i);
  };
  const auto wait = []() -> FlipResult {
    for (;;) pause();
  };
  for (const FlipResult& result : {in_a_copy(hang, 1), in_a_copy(wait, 1)}) {
    EXPECT_EQ(result.outcome, FlipOutcome::restarted);
    EXPECT_TRUE(result.hung);
  }
  EXPECT_EQ(in_a_copy([] { return FlipResult{FlipOutcome::silent}; }, 1).outcome,
            FlipOutcome::silent);
}

}  // namespace
}  // namespace lss::campaign
