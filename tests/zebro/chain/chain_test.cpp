// The chain itself: it walks, and the same options give the same run.

#include "tests/zebro/chain/chain.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <random>
#include <utility>
#include <vector>

#include "idl/angles.h"
#include "tests/zebro/chain/wire_check.h"
#include "tools/lss-sim/zebro/vehicle.h"

namespace lss::zebro {
namespace {

#ifdef LSS_SANITIZED
constexpr auto kPlant = sim::zebro::PlantKind::kinematic;  // the other takes too long
#else
constexpr auto kPlant = sim::zebro::PlantKind::dart;
#endif

TEST(ZebroChain, StandsWalksAndComesToASafeStop) {
  Chain chain({.plant = kPlant});
  ASSERT_TRUE(chain.stand());
  EXPECT_GT(chain.body().position_m.z(), 0.04);
  ASSERT_TRUE(chain.walk());
  chain.run(7);  // aligning the legs moves the body, too, and is not reckoned
  const auto from = chain.body().position_m;
  const double said_m = chain.telemetry().distance_m;
  chain.run(20);
  EXPECT_EQ(chain.mode(), Mode::walking);
  const double walked_m = (chain.body().position_m - from).norm();
  EXPECT_GT(walked_m, 0.15);
  EXPECT_NEAR(walked_m, chain.telemetry().distance_m - said_m, 0.02);
  const auto stop = chain.send(lss::CommandKind::stop, {1});
  ASSERT_TRUE(chain.run_until(State::idle, 30));
  chain.run(0.1);  // until the last module has said that its motor is off
  EXPECT_EQ(chain.last_ack(stop)->phase, Phase::completed);
  EXPECT_EQ(chain.supervisor().fault_count, 0u);
  EXPECT_EQ(chain.bus().frames_dropped, 0u);
}

// Frames last 20 ms; two frames on the wire 4.2 ms (docs/icd-zebro.md section 10). Of these 30 the
// first emergency stop began after 0.000 ms at least, median 2.884 ms, 4.105 ms at most.
TEST(ZebroChain, AnEmergencyStopIsOnTheWireBeforeTheNextFrame) {
  std::vector<double> phases_s{0.0005, 0.006, 0.019}, begun_ms;
  std::mt19937 random(1);
  while (phases_s.size() < 30)
    phases_s.push_back(std::uniform_real_distribution<double>(0, 0.02)(random));
  for (unsigned seed = 0; const double into_frame_s : phases_s) {
    SCOPED_TRACE(into_frame_s);
    Chain chain({.seed = ++seed, .plant = sim::zebro::PlantKind::kinematic});
    ASSERT_TRUE(chain.stand());
    ASSERT_TRUE(chain.walk());
    chain.run(into_frame_s);
    chain.forget();
    const TimeNs asked_ns = chain.now();
    const auto stop = chain.send(lss::CommandKind::emergency_stop, {}, "stranger");
    ASSERT_EQ(chain.last_ack(stop)->phase, Phase::accepted) << "by the listener";
    chain.run(0.3);
    EXPECT_EQ(emergency_on_wire(chain.wire(), chain.parameters().bus, asked_ns, chain.now()), "");
    const auto stopped = std::ranges::find_if(chain.wire(), [&](const WireFrame& f) {
      return f.begin_ns >= asked_ns && f.code() == Code::emergency_stop;
    });
    ASSERT_NE(stopped, chain.wire().end());
    begun_ms.push_back(static_cast<double>(stopped->begin_ns - asked_ns) * 1e-6);
    EXPECT_EQ(chain.state(), State::fatal_error);
    EXPECT_EQ(chain.last_ack(stop)->phase, Phase::completed);
    EXPECT_FALSE(chain.has(FaultId::stop_not_followed));
    ASSERT_TRUE(chain.solve());
    EXPECT_TRUE(chain.stand()) << "orders pass again";
  }
  std::ranges::sort(begun_ms);
  std::printf("on the wire after %.3f ms at least, median %.3f ms, %.3f ms at most, of %zu\n",
              begun_ms.front(), begun_ms[begun_ms.size() / 2], begun_ms.back(), begun_ms.size());
}

TEST(ZebroChain, TheSameSeedGivesTheSameRunToTheBit) {
  const auto run = [](unsigned seed) {
    Chain chain({.seed = seed, .plant = kPlant});
    chain.inject("noise:0.001");
    EXPECT_TRUE(chain.stand());
    EXPECT_TRUE(chain.walk(false, 0.3, gnc::zebro::Speed::medium));
    chain.run(1.2345);
    chain.inject("leg-stuck:2");
    chain.run(3);
    return std::pair(chain.wire(), chain.body().position_m);
  };
  const auto same = [](const WireFrame& a, const WireFrame& b) {
    return a.begin_ns == b.begin_ns && a.frame.address == b.frame.address &&
           a.frame.code == b.frame.code && a.frame.data == b.frame.data;
  };
  const auto [wire, at] = run(5);
  const auto [wire_again, at_again] = run(5);
  EXPECT_TRUE(std::ranges::equal(wire, wire_again, same));
  EXPECT_EQ(at, at_again);
  const auto [other_wire, other_at] = run(6);
  EXPECT_FALSE(std::ranges::equal(wire, other_wire, same));
  EXPECT_NE(at, other_at);
}

// A module that was reset counts from 0 until its leg passes the Hall sensor, then from where it
// is.
// [Conf-3]
TEST(ZebroChain, AFaultyLegNearItsSensorIsMovedFreeNoFurtherThanItShould) {
  constexpr std::size_t kLeg = 2;
  for (const double past_deg : {3.0, 8.0, 14.0, 19.0}) {
    Chain chain({.plant = sim::zebro::PlantKind::kinematic});
    ASSERT_TRUE(chain.stand());
    ASSERT_TRUE(chain.walk());
    const auto angle_rad = [&] { return chain.world().robot().shafts()[kLeg].angle_rad; };
    const auto past_sensor_deg = [&] { return std::remainder(angle_rad() / kDegree - 180, 360); };
    ASSERT_TRUE(chain.run_until(
        [&] { return past_sensor_deg() > past_deg && past_sensor_deg() < 90; }, 10));
    chain.inject("driver-fault:3");
    ASSERT_TRUE(chain.run_until(State::fatal_error, 0.1));
    chain.run(1);
    const double from_rad = angle_rad();
    double back_rad = 0, forth_rad = 0;
    chain.send(lss::CommandKind::solve);
    ASSERT_TRUE(chain.run_until(State::solve_errors, 0.1));
    chain.run_until(
        [&] {
          back_rad = std::max(back_rad, from_rad - angle_rad());
          forth_rad = std::max(forth_rad, angle_rad() - from_rad);
          return chain.state() != State::solve_errors;
        },
        60);
    EXPECT_EQ(chain.state(), State::idle);
    EXPECT_EQ(chain.supervisor().controller.isolated, 0);
    EXPECT_NEAR(back_rad / kDegree, 20, 2) << past_deg;
    EXPECT_LT(forth_rad / kDegree, 2) << past_deg;
    EXPECT_NEAR(angle_rad() / kDegree, from_rad / kDegree, 2) << past_deg;
  }
}

}  // namespace
}  // namespace lss::zebro
