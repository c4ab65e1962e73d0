// Flips of several seeds add up.

#include "tests/campaign/flip_results.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <stdexcept>

namespace lss::campaign {
namespace {

using testing::HasSubstr;

FlipResults of_seed(unsigned seed) {
  FlipResults results{.commit = "abc", .part = "state", .seeds = {seed}, .vehicles = {}};
  FlipCounts& counts = results.vehicles["talaris"];
  counts.bytes = {{"bus", 100}};
  counts.parts = {{"bus", {seed, 2, 0, 0, 1, 0}}};
  counts.state = {seed, 2, 0, 0, 1, 0};
  counts.places = {{"bus: grid +8", {0, 0, 0, 0, 1, 0}}};
  counts.hung = {{"bus", seed}};
  counts.scenarios = 1;
  counts.simulated_s = 10;
  counts.slowest_detection_s = 0.1 * seed;
  return results;
}

std::string why_no_sum(const FlipResults& other) {
  try {
    (void)merge({of_seed(1), other});
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return "merged";
}

TEST(FlipResults, OfSeveralSeedsAddUp) {
  std::vector<FlipResults> all;
  for (const unsigned seed : {3u, 1u, 2u}) {
    const std::string text = to_text(of_seed(seed));
    all.push_back(flips_from_text(text, "file"));
    EXPECT_EQ(to_text(all.back()), text);
  }
  const FlipResults sum = merge(all);
  EXPECT_EQ(sum.seeds, (std::vector{1u, 2u, 3u}));
  const FlipCounts& counts = sum.vehicles.at("talaris");
  EXPECT_EQ(counts.bytes.at("bus"), 100u);
  EXPECT_EQ(counts.parts.at("bus"), (FlipTally{6, 6, 0, 0, 3, 0}));
  EXPECT_EQ(counts.state, counts.parts.at("bus"));
  EXPECT_EQ(counts.places.at("bus: grid +8")[4], 3u);
  EXPECT_EQ(counts.hung.at("bus"), 6u);
  EXPECT_EQ(counts.scenarios, 3u);
  EXPECT_DOUBLE_EQ(counts.simulated_s, 30);
  EXPECT_DOUBLE_EQ(counts.slowest_detection_s, 0.3);
  EXPECT_THAT(document(sum), HasSubstr("| **state** | 100 | 15 | 6 (40.000 %"));
}

TEST(FlipResults, ThatDoNotBelongTogetherAreRefused) {
  EXPECT_EQ(why_no_sum(of_seed(2)), "merged");
  EXPECT_THAT(why_no_sum(of_seed(1)), HasSubstr("seed 1 of talaris comes twice"));
  FlipResults other = of_seed(2);
  other.commit = "def";
  EXPECT_THAT(why_no_sum(other), HasSubstr("different commits: abc and def"));
  other = of_seed(2);
  other.protect = false;
  EXPECT_THAT(why_no_sum(other), HasSubstr("not all of protected memory"));
  EXPECT_THROW((void)flips_from_text("{}", "file"), std::runtime_error);
}

}  // namespace
}  // namespace lss::campaign
