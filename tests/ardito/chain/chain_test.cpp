// The chain itself: it drives and stops, and the same options give the same run.

#include "tests/ardito/chain/chain.h"

#include <gtest/gtest.h>

#include <cmath>
#include <tuple>

namespace lss::ardito {
namespace {

Chain::Options with_short_lamp(unsigned seed) {
  return {.seed = seed, .adjust = [](Parameters& p) { p.beacon_ns = 1500 * kMillisecond; }};
}

TEST(ArditoChain, StartsDrivesAndComesToASafeStop) {
  Chain chain(with_short_lamp(1));
  ASSERT_TRUE(chain.start());
  ASSERT_TRUE(chain.drive(0.5));
  chain.run(3);
  const sim::ardito::BodyState body = chain.world().rover().body();
  EXPECT_NEAR(body.velocity_m_s.norm(), 0.5, 0.02);
  EXPECT_NEAR(chain.telemetry().measured_m_s, 0.5, 0.02);
  EXPECT_NEAR(chain.telemetry().distance_m, body.position_m.x(), 0.05);
  chain.send(lss::CommandKind::stop);
  ASSERT_TRUE(chain.run_until(State::idle, 10));
  chain.run(0.5);
  EXPECT_LT(chain.world().rover().body().velocity_m_s.norm(), 0.01);
  EXPECT_EQ(chain.supervisor().fault_count, 0u);
}

TEST(ArditoChain, TheSameSeedGivesTheSameRunToTheBit) {
  const auto run = [](unsigned seed) {
    Chain chain(with_short_lamp(seed));
    chain.inject("noise:0.001");
    EXPECT_TRUE(chain.start());
    EXPECT_TRUE(chain.drive(0.4, 0.03));
    chain.run(0.7123);
    chain.inject("E-TM:3");
    chain.run(0.5);
    const Eigen::Vector3d at = chain.world().rover().body().position_m;
    return std::tuple(at.x(), at.y(), at.z(), chain.telemetry().wheels[5].current_A,
                      chain.telemetry().bus_frames_received);
  };
  const auto first = run(5);
  EXPECT_EQ(first, run(5));
  EXPECT_NE(first, run(6));
}

}  // namespace
}  // namespace lss::ardito
