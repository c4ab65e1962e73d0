#include "tools/lss-cli/show/names.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "idl/edit_distance.h"

namespace lss::cli {
namespace {

const std::vector<std::string> kVerbs = {"status", "start", "stop",  "stand",
                                         "stow",   "walk",  "watch", "lay-down"};

TEST(Names, TheNearestNameIsTheOneThatWasMeant) {
  EXPECT_EQ(nearest("wlak", kVerbs), "walk");
  EXPECT_EQ(nearest("stauts", kVerbs), "status");
  EXPECT_EQ(nearest("lay", kVerbs), "lay-down");
  EXPECT_EQ(nearest("laydown", kVerbs), "lay-down");
}

TEST(Names, AnotherWordIsNotGuessedAt) {
  EXPECT_EQ(nearest("fly", kVerbs), "");
  EXPECT_EQ(nearest("zzzzzzzz", kVerbs), "");
  EXPECT_EQ(did_you_mean("zzzzzzzz", kVerbs), "");
  EXPECT_EQ(nearest("walk", {}), "");
}

TEST(Names, SwappedNeighboursAreOneMistake) {
  EXPECT_EQ(edit_distance("walk", "wlak"), 1U);
  EXPECT_EQ(edit_distance("", "walk"), 4U);
  EXPECT_EQ(edit_distance("stow", "stop"), 1U);
}

RC_GTEST_PROP(Names, TheDistanceIsSymmetricAndZeroOnlyForEqualWords,
              (const std::string& a, const std::string& b)) {
  RC_ASSERT(edit_distance(a, b) == edit_distance(b, a));
  RC_ASSERT((edit_distance(a, b) == 0) == (a == b));
}

}  // namespace
}  // namespace lss::cli
