// How long a client listens for daemons that no other daemon has named.

#include <gtest/gtest.h>

#include "tools/lss-cli/session/daemons.h"

namespace lss::cli {
namespace {

using std::chrono::milliseconds;

class LullTest : public testing::Test {
 protected:
  // Looks every `every` for `time`; when it is over, or nothing.
  std::optional<milliseconds> over_within(milliseconds time, milliseconds every) {
    for (const Clock::time_point until = now_ + time; now_ < until;) {
      now_ += every;
      lull_.step(false, now_);
      if (lull_.is_over())
        return std::chrono::duration_cast<milliseconds>(now_ -
                                                        Clock::time_point(milliseconds(1000)));
    }
    return std::nullopt;
  }

  Clock::time_point now_{milliseconds(1000)};
  Lull lull_;
};

TEST_F(LullTest, LastsThreeTenthsOfASecondWhenAllIsHeardAtOnce) {
  lull_.step(true, now_);
  EXPECT_EQ(over_within(milliseconds(1000), milliseconds(10)), milliseconds(300));
}

TEST_F(LullTest, LastsThreeTimesAsLongAsTheNewsTookAndAtMostASecond) {
  lull_.step(false, now_);
  now_ += milliseconds(200);
  lull_.step(true, now_);
  EXPECT_EQ(over_within(milliseconds(2000), milliseconds(10)), milliseconds(800));
}

TEST_F(LullTest, BeginsAgainWithEachNews) {
  lull_.step(true, now_);
  EXPECT_EQ(over_within(milliseconds(290), milliseconds(10)), std::nullopt);
  now_ += milliseconds(1);
  lull_.step(true, now_);
  EXPECT_FALSE(lull_.is_over());
}

// When this process gets little CPU time, so do its DDS threads.
TEST_F(LullTest, TakesLongerWhenTheProcessRunsSeldom) {
  lull_.step(true, now_);
  EXPECT_EQ(over_within(milliseconds(5000), milliseconds(100)), milliseconds(3000));
}

}  // namespace
}  // namespace lss::cli
