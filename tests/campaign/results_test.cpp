// A campaign in shards is the same campaign; scripts of a search are scenarios, and get shorter.

#include "tests/campaign/results.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/campaign/dice.h"
#include "tests/campaign/script.h"

namespace lss::campaign {
namespace {

using testing::HasSubstr;

Results part(Shard shard, unsigned runs = 6) {
  Results results{.commit = "abc", .first = 1, .runs = runs, .shard = shard, .summaries = {}};
  Summary& summary = results.summaries.emplace_back(subjects().front());
  for (unsigned i = shard.number - 1; i < runs; i += shard.of) {
    Run run;
    static_cast<Tally&>(run) = {.simulated_s = 10.0 + i,
                                .frames = 100,
                                .faults = i,
                                .commands = 2,
                                .rejected = 1,
                                .stops = i % 2,
                                .slowest_rest_s = 0.1 * i};
    run.number = 1 + i;
    if (i == 3) run.broken = {"1 s: falls"};
    run.outcome = i < 2 ? "upright" : "fell over";
    summary.add(run);
  }
  return results;
}

std::string why_not(const std::vector<Results>& shards) {
  try {
    (void)merge(shards);
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return "merged";
}

TEST(CampaignResults, ShardsAddUpToTheWhole) {
  std::vector<Results> shards;
  for (unsigned i = 1; i <= 4; ++i) {
    const std::string text = to_text(part({i, 4}));
    shards.push_back(from_text(text, "file"));
    EXPECT_EQ(to_text(shards.back()), text);
  }
  std::swap(shards[0], shards[2]);
  EXPECT_EQ(to_text(merge(shards)), to_text(part({})));
}

TEST(CampaignResults, WhatIsNoWholeCampaignIsRefused) {
  EXPECT_EQ(why_not({part({1, 2}), part({2, 2})}), "merged");
  EXPECT_THAT(why_not({part({1, 3}), part({3, 3})}), HasSubstr("shard 2/3 is missing"));
  EXPECT_THAT(why_not({part({1, 2}), part({1, 2})}), HasSubstr("shard 1/2 comes twice"));
  EXPECT_THAT(why_not({part({1, 2}), part({2, 2}, 8)}), HasSubstr("of different campaigns"));
  Results other = part({2, 2});
  other.commit = "def";
  EXPECT_THAT(why_not({part({1, 2}), other}), HasSubstr("of different commits: abc and def"));
  other = part({1, 2});
  other.summaries.clear();
  EXPECT_THAT(why_not({part({2, 2}), other}), HasSubstr("of different vehicles"));
  EXPECT_THAT(why_not({}), HasSubstr("nothing"));
}

TEST(CampaignResults, AForeignFileIsRefused) {
  for (const char* text :
       {"", "[]", "{}", R"({"lss":"recording"})", R"({"lss":"campaign","commit":3})"})
    EXPECT_THROW((void)from_text(text, "file"), std::runtime_error) << text;
}

TEST(CampaignResults, AShardIsANumberOfANumber) {
  EXPECT_EQ(parse_shard("2/8").number, 2u);
  EXPECT_EQ(parse_shard("2/8").of, 8u);
  for (const char* text : {"", "2", "0/8", "9/8", "2/", "/8", "2/8x", "-1/8", "a/b"})
    EXPECT_THROW((void)parse_shard(text), std::runtime_error) << text;
}

TEST(CampaignScript, IsWrittenInHexadecimalDigits) {
  EXPECT_EQ(to_hex(Script{0x00, 0x1a, 0xff}), "001aff");
  EXPECT_EQ(from_hex("001aff"), (Script{0x00, 0x1a, 0xff}));
  for (const char* text : {"0", "0g", "001af", "zz"}) EXPECT_FALSE(from_hex(text)) << text;
}

TEST(CampaignScript, ShrinksToWhatMakesItFail) {
  Script script(200, 77);
  const auto fails = [](const Script& s) {
    return std::ranges::count_if(s, [](std::uint8_t byte) { return byte >= 50; }) >= 3;
  };
  EXPECT_EQ(shrink(script, fails, 100'000), (Script{0, 50, 50, 50})) << "whole choices";
  unsigned plays = 0;
  (void)shrink(
      script, [&](const Script& s) { return ++plays > 0 && fails(s); }, 20);
  EXPECT_EQ(plays, 20u);
}

TEST(CampaignScript, IsAScenarioWithItsOwnChoices) {
  const Script script = {0x80, 0x00, 0xff, 0xff};
  Dice dice{std::span<const std::uint8_t>(script)};
  EXPECT_EQ(dice.between(0, 2), 1.0);
  EXPECT_EQ(dice.whole(1, 3), 3);
  EXPECT_EQ(dice.whole(1, 3), 1) << "after its end: zeros";
  for (const Subject& subject : subjects()) {
    if (subject.vehicle != std::string("zebro")) continue;  // the fastest
    const Script any(64, 0x5a);
    const campaign::Run once = subject.play_script(any, nullptr),
                        again = subject.play_script(any, nullptr);
    EXPECT_THAT(once.broken, testing::IsEmpty());
    EXPECT_EQ(once.story, again.story);
    EXPECT_NE(once.story, subject.play_script(Script(64, 0xa5), nullptr).story);
  }
}

}  // namespace
}  // namespace lss::campaign
