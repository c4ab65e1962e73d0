#include "tools/lss-ground/daemons.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tools/lss-cli/session/wire.h"

namespace lss::ground {
namespace {

using std::chrono::seconds;
using testing::IsEmpty;
using testing::SizeIs;

const Clock::time_point kStart{seconds(100)};

lss_Instance started(int pid, const char* host = "obc") {
  lss_Instance instance{.boot = 7, .started_utc_ns = pid * 1000, .pid = pid, .host = {}};
  cli::put(instance.host, host);
  return instance;
}

TEST(Daemons, OneThatWasStartedAgainIsNoSecondOne) {
  Daemons daemons;
  for (int s = 0; s < 20; ++s) daemons.heard(started(1), kStart + seconds(s));
  for (int s = 20; s < 40; ++s) {
    daemons.heard(started(2), kStart + seconds(s));
    EXPECT_THAT(daemons.rivals(kStart + seconds(s)), IsEmpty()) << s;
  }
}

TEST(Daemons, TwoThatSpeakInTurnsAreRivalsUntilOneIsSilentForTenSeconds) {
  Daemons daemons;
  daemons.heard(started(1), kStart);
  daemons.heard(started(1, "other"), kStart + seconds(1));
  EXPECT_THAT(daemons.rivals(kStart + seconds(1)), IsEmpty()) << "it may have been started again";
  daemons.heard(started(1), kStart + seconds(2));
  const auto rivals = daemons.rivals(kStart + seconds(2));
  ASSERT_THAT(rivals, SizeIs(2));
  EXPECT_EQ(cli::text(rivals[0].host), "obc");
  EXPECT_EQ(cli::text(rivals[1].host), "other");
  for (int s = 3; s < 11; ++s) {
    daemons.heard(started(1), kStart + seconds(s));
    EXPECT_THAT(daemons.rivals(kStart + seconds(s)), SizeIs(2)) << s;
  }
  EXPECT_THAT(daemons.rivals(kStart + seconds(11)), IsEmpty());
}

TEST(Daemons, WhoDoesNotSayWhoItIsCountsForNothingAndAMultitudeHasABound) {
  Daemons daemons;
  for (int i = 0; i < 3; ++i) {
    daemons.heard(started(0), kStart + seconds(i));
    daemons.heard(started(1), kStart + seconds(i));
  }
  EXPECT_THAT(daemons.rivals(kStart + seconds(3)), IsEmpty());
  for (int round = 0; round < 2; ++round) {
    for (int pid = 1; pid < 100; ++pid) daemons.heard(started(pid), kStart + seconds(4));
    daemons.heard(started(1), kStart + seconds(5));
  }
  EXPECT_THAT(daemons.rivals(kStart + seconds(5)), SizeIs(testing::Le(Daemons::kMost)));
}

}  // namespace
}  // namespace lss::ground
