// The chain itself: it hops, edges of valves come at their own times, and the same options give
// the same run.

#include "tests/talaris/chain/chain.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <sstream>
#include <tuple>

#include "tests/talaris/chain/campaigns.h"

namespace lss::talaris {
namespace {

using sim::talaris::Stand;

TEST(TalarisChain, PulsesComeAtTheirDelaysWithinTheFrame) {
  Chain chain({.config = "valves", .world = {.plant = {.stand = Stand::load}}});
  ASSERT_TRUE(chain.start());
  chain.send(CommandKind::duty_cycle);
  ASSERT_TRUE(chain.run_until(Mode::duty_cycle, 1));
  chain.send(CommandKind::pulse, {0b100, 0.073, 0.041, 3});
  ASSERT_TRUE(chain.run_until([&] { return chain.orders().pulse[2].on_ns != 0; }, 1));
  const TimeNs frame_ns = chain.frame_ns();
  chain.run(0.25);
  const TimeNs release_ns = frame_ns + 5 * kMillisecond;
  EXPECT_EQ(chain.edges_now().opened_ns[2], frame_ns + 200 * kMillisecond + 46 * kMillisecond)
      << "the second pulse is under way";
  EXPECT_EQ(chain.edges_now().shut_ns[2], release_ns + 114 * kMillisecond);
  EXPECT_EQ(chain.edges_now().counters.worst_late_ns, 0);
}

TEST(TalarisChain, AnEmergencyStopDoesNotWaitForTheFrame) {
  Chain chain({.config = "valves", .world = {.plant = {.stand = Stand::load}}});
  ASSERT_TRUE(chain.start());
  chain.send(CommandKind::valve, {0b1, 1, 5});
  ASSERT_TRUE(chain.run_until([&] { return chain.telemetry().valves[0].open; }, 1));
  chain.run(0.05);
  ASSERT_EQ(chain.world().valve_node().outputs(), 1);
  chain.send(lss::CommandKind::emergency_stop);
  chain.run(0.003);
  EXPECT_EQ(chain.world().valve_node().outputs(), 0);
  EXPECT_TRUE(chain.run_until(State::fatal_error, 0.5));
}

TEST(TalarisChain, TheSameSeedGivesTheSameHopToTheBit) {
  const auto run = [](unsigned seed) {
    const Flown flown = fly({.request = {.height_m = 1, .distance_m = 3},
                             .adjust = [](Parameters& p) { p.navigation.calibration_s = 4; }},
                            seed);
    EXPECT_TRUE(flown.came_down) << flown.text();
    return std::tuple(flown.along_m, flown.across_m, flown.gas_s, flown.down_m_s);
  };
  const auto first = run(5);
  EXPECT_EQ(first, run(5));
  EXPECT_NE(first, run(6));
}

// LSS_SEEDS="41 64" LSS_FAULTS="imu-silent" LSS_FAULT_AT=6, or LSS_WIDE=1: to look at single
// flights.
TEST(TalarisChain, FlightsThatAreAskedFor) {
  const char* seeds = std::getenv("LSS_SEEDS");
  if (seeds == nullptr) GTEST_SKIP() << "set LSS_SEEDS to fly hops and see how they ended";
  FlightPlan plan;
  if (const char* faults = std::getenv("LSS_FAULTS")) {
    std::istringstream words(faults);
    for (std::string word; words >> word;) plan.faults.push_back(word);
  }
  if (std::getenv("LSS_WIDE") != nullptr) plan = wide_flight();
  if (const char* at = std::getenv("LSS_FAULT_AT")) plan.fault_s = std::atof(at);
  std::istringstream words(seeds);
  for (unsigned seed = 0; words >> seed;) std::printf("%s\n", fly(plan, seed).text().c_str());
}

}  // namespace
}  // namespace lss::talaris
