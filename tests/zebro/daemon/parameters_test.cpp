// Parameters of Lunar Zebro that change while it runs.
#include <gtest/gtest.h>

#include "idl/zebro/codes.h"
#include "world.h"

namespace lss::zebro {
namespace {

TEST(ZebroParameters, ALowerCurrentLimitIsInForceAtOnce) {
  World w;
  ASSERT_TRUE(w.stand());
  w.modules[2].current_mA = 1000;
  w.run(1);
  EXPECT_EQ(w.state(), State::operational);
  EXPECT_EQ(w.set("limits.current_A", 0.9).phase, Phase::completed);
  w.run(0.2);
  EXPECT_TRUE(w.has(faults::current_limit, 3));
  EXPECT_EQ(w.state(), State::fatal_error);
}

TEST(ZebroParameters, StandingUpTakesAsLongAsItWasSetTo) {
  const auto takes_s = [](double stand_up_s) {
    World w;
    w.run(0.2);
    EXPECT_EQ(w.set("motion.stand_up_s", stand_up_s).phase, Phase::completed);
    EXPECT_TRUE(w.stand());
    return static_cast<double>(w.time_ns_) * 1e-9;
  };
  EXPECT_NEAR(takes_s(7) - takes_s(3), 4, 0.05);
}

TEST(ZebroParameters, TimeForAStrategyIsThatOfTheNextOne) {
  World w;
  w.run(0.2);
  EXPECT_EQ(w.set("solve.budget_s", 2).phase, Phase::completed);
  w.modules[1].alive = false;
  ASSERT_TRUE(w.run_until([&] { return w.state() == State::fatal_error; }, 5));
  const TimeNs from = w.time_ns_;
  w.send(lss::CommandKind::solve);
  ASSERT_TRUE(w.run_until(
      [&] { return w.last(Phase::failed) != nullptr || w.last(Phase::completed) != nullptr; }, 60));
  EXPECT_LT(w.time_ns_ - from, 12 * kSecond);  // three strategies; with ten seconds each it is more
}

// A full turn in so short a flight is faster than a leg may turn.
TEST(ZebroParameters, AGaitThatTurnsLegsTooFastIsRefused) {
  World w;
  w.run(0.2);
  EXPECT_EQ(w.set("gait.flight_s", 1).verdict.reason, Reason::parameter_together);
  EXPECT_EQ(w.events.back().id, static_cast<std::uint16_t>(EventId::command_rejected));
  EXPECT_EQ(w.events.back().subject, 0);  // a parameter is no module
  EXPECT_EQ(w.vehicle_.tunables().changes, 0U);
}

// Its centre of mass is ahead: the shorter the double stance, the further back are the feet that
// carry when a group lands.
TEST(ZebroParameters, TimesWithWhichAGaitWouldFallAreRefused) {
  Parameters p;
  for (double& x_m : p.locomotion.hips.x_m) x_m -= 0.025;
  World w(p);
  w.run(0.2);
  EXPECT_EQ(w.set("gait.double_stance_s", 0.6).phase, Phase::completed);
  EXPECT_EQ(w.set("gait.double_stance_s", 0.2).verdict.reason, Reason::parameter_together);
}

TEST(ZebroParameters, ATimeOfLyingDownThatASilentOBCWouldBreakOffIsRefused) {
  World w;
  w.run(0.2);
  EXPECT_EQ(w.set("motion.lay_down_s", 20).phase, Phase::completed);
  EXPECT_EQ(w.set("motion.lay_down_s", 25).verdict.reason, Reason::parameter_together);
}

// 30 s of silence less 10 s of a safe stop.
TEST(ZebroParameters, ALeaseWhoseSafeStopASilentOBCWouldBreakOffIsRefused) {
  const auto start = [](World& w, std::uint32_t lease_ms) {
    w.acks.clear();
    w.put({.source = safety::source("test"),
           .kind = static_cast<std::uint16_t>(lss::CommandKind::start),
           .lease_ms = lease_ms,
           .parameter = {1}});
    w.step();
    const Ack* refused = w.last(Phase::rejected);
    return refused != nullptr ? refused->verdict : Verdict{};
  };
  World w;
  w.run(0.2);
  const Verdict refused = start(w, 20'001);
  EXPECT_EQ(refused.reason, Reason::bad_lease);
  EXPECT_EQ(refused.limit, 20'000);
  EXPECT_EQ(w.set("motion.lay_down_s", 8).phase, Phase::completed);
  EXPECT_EQ(start(w, 20'000).limit, 15'000);
  ASSERT_EQ(start(w, 15'000).reason, Reason::none);
  ASSERT_TRUE(w.run_until(Mode::standing, 40));
  w.heartbeat_ = false;
  EXPECT_TRUE(w.run_until(State::idle, 30));
  EXPECT_FALSE(w.has(FaultId::obc_silent));
}

// The gate would stop everything at its first movement.
TEST(ZebroParameters, APanelThatTurnsTooFastIsRefused) {
  World w;
  w.run(0.2);
  EXPECT_EQ(w.set("panel.move_s", 1).phase, Phase::completed);  // 110 deg/s
  EXPECT_EQ(w.set("panel.deployed_deg", 350).verdict.reason, Reason::parameter_together);
  w.send(CommandKind::panel, {1});
  ASSERT_TRUE(w.run_until([&] { return w.last(Phase::completed) != nullptr; }, 10));
  EXPECT_EQ(w.state(), State::idle);
}

}  // namespace
}  // namespace lss::zebro
