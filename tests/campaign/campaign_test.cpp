// A few scenarios of each vehicle, and that a scenario is the same each time; `lss-campaign` plays
// hundreds.

#include "tests/campaign/campaign.h"

#include <gtest/gtest.h>

#include "tests/campaign/dice.h"
#include "tests/support/everything.h"

namespace lss::campaign {
namespace {

class Campaign : public testing::TestWithParam<std::size_t> {};

TEST_P(Campaign, NoRequirementIsViolated) {
  const Subject& subject = subjects()[GetParam()];
  for (const unsigned number : {1U, 2U, 10U}) {
    // A tenth has rigid bodies, which take ten times as long: at each commit those of one vehicle.
    if (number % 10 == 0 && !testing_support::in_sample(GetParam(), subjects().size())) continue;
    const campaign::Run run = subject.play(number);
    EXPECT_GT(run.faults, 0u);
    std::string story;
    for (const std::string& line : run.story) story += line + "\n";
    for (const std::string& what : run.broken)
      ADD_FAILURE() << subject.vehicle << " " << number << ": " << what << "\n" << story;
  }
}

TEST_P(Campaign, AScenarioIsTheSameEachTime) {
  const Subject& subject = subjects()[GetParam()];
  const campaign::Run once = subject.play(3), again = subject.play(3);
  EXPECT_EQ(once.story, again.story);
  EXPECT_EQ(once.frames, again.frames);
  EXPECT_EQ(once.rejected, again.rejected);
  EXPECT_EQ(once.slowest_rest_s, again.slowest_rest_s);
}

INSTANTIATE_TEST_SUITE_P(Vehicles, Campaign, testing::Range(std::size_t{0}, subjects().size()),
                         [](const auto& which) {
                           return std::string(subjects()[which.param].vehicle);
                         });

TEST(CampaignDice, StayInTheirRanges) {
  Dice dice(1);
  double least = 1, most = 0;
  for (int i = 0; i < 10'000; ++i) {
    const double drawn = dice.between(0, 1);
    least = std::min(least, drawn);
    most = std::max(most, drawn);
    const int whole = dice.whole(-1, 2);
    ASSERT_TRUE(whole >= -1 && whole <= 2);
  }
  EXPECT_GE(least, 0);
  EXPECT_LT(most, 1);
  EXPECT_LT(least, 0.01);
  EXPECT_GT(most, 0.99);
}

}  // namespace
}  // namespace lss::campaign
