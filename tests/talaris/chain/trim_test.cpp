// What is not known before lift-off: where the centre of mass is, what it weighs, what the fans and
// valves give; and what pushes it. The first frames in the air show it.

#include <gtest/gtest.h>

#include "tests/talaris/chain/campaigns.h"
#include "tests/talaris/chain/many.h"

namespace lss::talaris {
namespace {

class TalarisAlone : public testing::TestWithParam<Alone> {};

TEST_P(TalarisAlone, IsFlownUpright) {
  for (const Flown& flown : fly_alone(GetParam(), 12)) {
    SCOPED_TRACE(flown.text());
    EXPECT_TRUE(flown.upright());
    EXPECT_LT(flown.down_m_s, 1.3);
    EXPECT_FALSE(wrong(flown)) << "reported as planned";
  }
}

INSTANTIATE_TEST_SUITE_P(Causes, TalarisAlone, testing::ValuesIn(kAlone),
                         [](const auto& which) { return std::string(which.param.name); });

// Within 5 %, of low hops within what two shortest pulses of the valves make.
TEST(TalarisTrim, TheHeightIsTheCommandedOne) {
  constexpr double kLeast_m = 0.05;
  for (const double height_m : {0.3, 1.0, 2.0}) {
    const auto all = sampled_runs(12, [=](unsigned seed) {
      FlightPlan plan;
      plan.request.height_m = height_m;
      plan.request.distance_m = 5;
      return fly(plan, seed);
    });
    for (const Flown& flown : all) {
      SCOPED_TRACE(flown.text());
      EXPECT_TRUE(flown.upright());
      EXPECT_NEAR(flown.max_height_m, height_m, std::max(0.05 * height_m, kLeast_m));
    }
  }
}

// With 19 s in the air, 2 s more, and an attitude that followed more slowly, these landed with 0.52
// to 0.89 m/s sideways: by navigation's drift, or leaning behind the command.
TEST(TalarisTrim, ADayInTheFieldEndsGently) {
  for (const unsigned seed : {34u, 89u, 112u, 147u}) {
    const Flown flown = fly(wide_flight(), seed);
    SCOPED_TRACE(flown.text());
    EXPECT_TRUE(safe(flown));
    EXPECT_LT(flown.air_s, 18);
  }
}

}  // namespace
}  // namespace lss::talaris
