// Dead reckoning with dead legs, in the air or dragging on the ground, against the true way: the
// bound in docs/gait-zebro.md is of these runs.

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <random>

#include "tests/support/everything.h"
#include "tests/zebro/chain/chain.h"
#include "tests/zebro/chain/legs.h"
#include "tools/lss-sim/zebro/vehicle.h"

namespace lss::zebro {
namespace {

constexpr double kWalked_s = 120;
constexpr double kShare = 0.15, kPlay_m = 0.01;  // of the true way, and at its ends
constexpr unsigned kSeeds = 5;

class LameWalk : public testing::TestWithParam<Legs> {};

TEST_P(LameWalk, IsReckonedAsFarAsItGoes) {
  for (unsigned seed = 1; seed <= kSeeds; ++seed) {
    if (seed > 1 && !testing_support::everything()) break;
    SCOPED_TRACE(seed);
    Chain chain({.seed = seed, .plant = sim::zebro::PlantKind::kinematic});
    ASSERT_TRUE(chain.stand());
    ASSERT_TRUE(chain.walk());
    std::mt19937 random(seed * 31 + static_cast<unsigned>(GetParam().legs.front()));
    chain.run(std::uniform_real_distribution<double>(3, 15)(random));
    for (const int leg : GetParam().legs) chain.inject("module-dead:" + std::to_string(leg));
    ASSERT_TRUE(chain.run_until(State::fatal_error, 2));
    ASSERT_TRUE(chain.solve());
    ASSERT_TRUE(chain.stand());
    ASSERT_TRUE(chain.walk());
    const double said_m = chain.telemetry().distance_m;
    double true_m = 0;
    auto before = chain.body();
    chain.run_until(
        [&] {
          const auto body = chain.body();
          true_m += (before.attitude.conjugate() * (body.position_m - before.position_m)).x();
          before = body;
          return chain.mode() != Mode::walking;
        },
        kWalked_s);
    ASSERT_EQ(chain.mode(), Mode::walking);
    const double reckoned_m = chain.telemetry().distance_m - said_m;
    std::printf("%s seed %u: true %.3f m, reckoned %.3f m\n", GetParam().name, seed, true_m,
                reckoned_m);
    EXPECT_NEAR(reckoned_m, true_m, kShare * std::abs(true_m) + kPlay_m);
  }
}

INSTANTIATE_TEST_SUITE_P(Zebro, LameWalk, one_or_two_legs(), name_of_legs);

}  // namespace
}  // namespace lss::zebro
