// Parameters of D.I.A.N.A. Ardito that change while it runs.
#include <gtest/gtest.h>

#include <cmath>

#include "idl/angles.h"
#include "world.h"

namespace lss::ardito {
namespace {

TEST(ArditoParameters, TheBeaconRunsAsLongAsItWasSetTo) {
  World w;
  w.run(0.5);
  EXPECT_EQ(w.set("safety.beacon_s", 2).phase, Phase::completed);
  w.send(lss::CommandKind::start, {0});
  w.step();
  const TimeNs from = w.time_ns_;
  ASSERT_TRUE(w.run_until([&] { return w.out_.command.wheel[0].enabled; }, 10));
  EXPECT_GE(w.time_ns_ - from, 2 * kSecond);
  EXPECT_LE(w.time_ns_ - from, 2 * kSecond + 2 * World::kPeriod);
}

TEST(ArditoParameters, AllThreeInstancesOfTheControllerTakeTheHeadingLimit) {
  Parameters narrow;
  narrow.mobility.max_sigma_rad = 2 * kDegree;
  World w(narrow);
  w.run(0.5);
  EXPECT_EQ(w.set("mobility.heading_limit_deg", 5).phase, Phase::completed);
  w.acks.clear();  // the start waits for its own
  ASSERT_TRUE(w.start_and_drive(0.3, 5 * kDegree));
  w.run(5);
  EXPECT_NEAR(std::abs(w.vehicle_.command().estimate.sigma_rad), 5 * kDegree, 0.5 * kDegree);
  EXPECT_EQ(w.vehicle_.mobility().report().upsets, 0U);
  // A gain is not changed under way.
  EXPECT_EQ(w.set("mobility.ratio_p", 0.4).verdict.reason, Reason::not_in_state);
}

TEST(ArditoParameters, GainsThatAreUnstableTogetherAreRefused) {
  World w;
  w.run(0.5);
  EXPECT_EQ(w.set("mobility.ratio_i", 30).verdict.reason, Reason::parameter_together);
}

}  // namespace
}  // namespace lss::ardito
