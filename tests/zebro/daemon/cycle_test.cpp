#include <gtest/gtest.h>

#include "tests/support/allocations.h"
#include "world.h"

namespace lss::zebro {
namespace {

TEST(Cycle, BootsSendingSafeCommands) {
  World w;
  w.step();
  EXPECT_EQ(w.state(), State::idle);
  for (const ModuleOrder& o : w.out_.command.module)
    EXPECT_EQ(o.kind, ModuleOrder::Kind::motion_off);
}

TEST(Cycle, StartsStandsWalksStopsAndLiesDown_Func_1_Func_2_Func_3) {
  World w;
  ASSERT_TRUE(w.stand());
  const double stood_at_m = w.out_.telemetry.distance_m;
  w.send(CommandKind::walk, {1, 0, 3});
  w.run(30);
  EXPECT_EQ(w.mode(), Mode::walking);
  EXPECT_NEAR(w.out_.telemetry.distance_m - stood_at_m, 0.0101 * 29.5, 0.045);
  w.send(lss::CommandKind::stop, {1});
  ASSERT_TRUE(w.run_until([&] { return w.state() == State::idle; }, 30));
  w.run(0.1);
  for (const IdealModule& m : w.modules) EXPECT_FALSE(m.flags & kFlagMotionControl);
  EXPECT_EQ(w.supervisor_.state().fault_count, 0u);
}

TEST(Cycle, LowMediumAndHighAreThreeIncreasingSpeeds_Func_4) {
  double before = 0;
  for (const double speed : {1.0, 2.0, 3.0}) {
    World w;
    ASSERT_TRUE(w.stand());
    w.send(CommandKind::walk, {1, 0, speed});
    w.run(60);
    EXPECT_GT(w.out_.telemetry.distance_m, before * 1.3);
    before = w.out_.telemetry.distance_m;
  }
}

TEST(Cycle, StartCanGoOnByItselfToWalk_Func_1) {
  World w;
  w.run(0.2);
  w.send(lss::CommandKind::start, {2, 0, 0.5, 1});
  ASSERT_TRUE(w.run_until(Mode::walking, 40));
  w.step();
  EXPECT_EQ(w.out_.telemetry.direction, -1);
  EXPECT_EQ(w.out_.telemetry.heading_rad, 0.5);
  EXPECT_EQ(w.out_.telemetry.speed, 1);
}

// [Miss-3]
TEST(Cycle, StowsTheLegsAndStandsUpAgain_Miss_2) {
  World w;
  ASSERT_TRUE(w.stand());
  w.send(CommandKind::stow);
  ASSERT_TRUE(w.run_until(Mode::stowed, 20));
  for (std::size_t i = 0; i < kLegs; ++i) EXPECT_NEAR(w.modules[i].position_deg, 257, 13);
  w.send(CommandKind::stand);
  EXPECT_TRUE(w.run_until(Mode::standing, 20));
}

// [Miss-3]
TEST(Cycle, BridgeMovesOneLegAndOnlyThat) {
  World w;
  ASSERT_TRUE(w.stand());
  w.send(lss::CommandKind::stop, {1});
  ASSERT_TRUE(w.run_until([&] { return w.state() == State::idle; }, 20));
  w.send(lss::CommandKind::start, {0});
  w.run(0.2);
  const std::array<IdealModule, kModules> before = w.modules;
  w.send(CommandKind::leg, {4, 3.14159265, 1, 1});
  w.step();
  EXPECT_EQ(w.acks.back().verdict.reason, Reason::too_fast);
  w.send(CommandKind::leg, {4, 3.14159265, 4, 1});
  ASSERT_TRUE(w.run_until([&] { return w.last(Phase::completed)->kind == 106; }, 5));
  for (std::size_t i = 0; i < kLegs; ++i) {
    EXPECT_NEAR(w.modules[i].position_deg, i == 3 ? 180 : before[i].position_deg, 0.1);
  }
}

TEST(Cycle, PanelMovesOnlyInIdleAndForbidsStartWhileItIsOut_Func_5) {
  World w;
  w.run(0.2);
  w.send(CommandKind::panel, {1});
  w.run(12);
  ASSERT_EQ(w.last(Phase::completed)->kind, 105);
  w.send(lss::CommandKind::start, {0});
  w.step();
  EXPECT_EQ(w.acks.back().verdict.reason, Reason::panel_deployed);
  w.send(CommandKind::panel, {0});
  w.run(12);
  w.send(lss::CommandKind::start, {0});
  w.run(0.2);
  EXPECT_EQ(w.state(), State::operational);
  w.send(CommandKind::panel, {1});
  w.step();
  EXPECT_EQ(w.acks.back().verdict.reason, Reason::not_in_state);
}

// A panel that was stopped on its way is neither in nor out, and the command says so.
TEST(Cycle, APanelThatBreaksOnItsWayHasNotArrived) {
  for (const std::uint16_t flag : {kFlagDriverFault, kFlagReset}) {
    World w;
    w.run(0.2);
    w.send(CommandKind::panel, {1});
    w.run(3);
    w.modules[6].flags = flag;
    w.modules[6].rate_deg_s = 0;
    EXPECT_TRUE(w.run_until([&] { return w.state() == State::fatal_error; }, 1));
    EXPECT_EQ(w.last(Phase::completed), nullptr);
    ASSERT_NE(w.last(Phase::failed), nullptr);
    EXPECT_EQ(w.last(Phase::failed)->verdict.reason, Reason::emergency);
  }
}

struct Emergency {
  const char* name;
  FaultId fault;
  std::uint16_t subject;
  double within_s;
  void (*cause)(World& w);
};

class Emergencies : public testing::TestWithParam<Emergency> {};

// [P-Int-2] [Oper-5] [Prod-4]
TEST_P(Emergencies, StopAllModulesInTheSameFrameAndEndInFatalError) {
  World w;
  ASSERT_TRUE(w.stand());
  w.send(CommandKind::walk, {1, 0, 3});
  w.run(4);
  GetParam().cause(w);
  ASSERT_TRUE(w.run_until([&] { return w.state() == State::fatal_error; }, GetParam().within_s));
  EXPECT_TRUE(w.all_stopped()) << "in the frame that saw it";
  EXPECT_TRUE(w.has(GetParam().fault, GetParam().subject));
  EXPECT_EQ(w.last(Phase::failed)->verdict.reason, Reason::emergency);
  w.run(1);
  for (const IdealModule& m : w.modules) EXPECT_FALSE(m.alive && (m.flags & kFlagMotionControl));
}

INSTANTIATE_TEST_SUITE_P(
    Cycle, Emergencies,
    testing::Values(Emergency{"module_silent", FaultId::module_silent, 4, 0.6,
                              [](World& w) { w.modules[3].alive = false; }},
                    Emergency{"over_current", FaultId::module_over_current, 2, 0.1,
                              [](World& w) {
                                w.modules[1].flags = static_cast<std::uint16_t>(
                                    (w.modules[1].flags & ~1u) | kFlagOverCurrent);
                              }},
                    Emergency{"driver_fault", FaultId::module_driver_fault, 6, 0.1,
                              [](World& w) { w.modules[5].flags |= kFlagDriverFault; }},
                    Emergency{"watchdog", FaultId::module_watchdog, 1, 0.1,
                              [](World& w) { w.modules[0].flags |= kFlagWatchdog; }},
                    Emergency{"module_reset", FaultId::module_reset, 5, 0.1,
                              [](World& w) { w.modules[4].flags = kFlagReset; }},
                    Emergency{"current_limit", FaultId::current_limit, 3, 0.4,
                              [](World& w) { w.modules[2].current_mA = 1400; }},
                    Emergency{"overrun", FaultId::frame_overrun, 0, 0.1,
                              [](World& w) { w.in_.overrun_limit = true; }},
                    Emergency{"port_lost", FaultId::port_lost, 0, 0.1,
                              [](World& w) { w.in_.bus.open = false; }},
                    Emergency{"disobeys", FaultId::module_disobeys, 2, 0.1,
                              [](World& w) { w.in_.bus.counters.module[1].disobeys = true; }},
                    Emergency{"stuck_leg", FaultId::motion_timeout, 0, 20,
                              [](World& w) { w.modules[0].stuck = true; }}),
    [](const auto& test) { return std::string(test.param.name); });

TEST(Cycle, StartIsRefusedAfterAnOverCurrentButNotAfterTheModulesMissedUs) {
  World w;
  w.run(0.2);
  w.modules[2].flags |= kFlagOverCurrent;
  w.run(0.1);
  w.send(lss::CommandKind::start);
  w.step();
  ASSERT_NE(w.last(Phase::rejected), nullptr);
  EXPECT_EQ(w.last(Phase::rejected)->verdict.reason, Reason::fault_latched);
  EXPECT_EQ(w.last(Phase::rejected)->verdict.subject, 3);
  // Their own watchdogs: no message for 8 s, the daemon was down for one.
  w.modules[2].flags = static_cast<std::uint16_t>(w.modules[2].flags & ~kFlagOverCurrent);
  for (IdealModule& m : w.modules) m.flags |= kFlagWatchdog;
  w.run(0.1);
  w.send(lss::CommandKind::start, {1});
  EXPECT_TRUE(w.run_until(Mode::standing, 40));
}

TEST(Cycle, ShutDownStopsAllModules) {
  World w;
  ASSERT_TRUE(w.stand());
  w.in_.shut_down = true;
  w.step();
  EXPECT_TRUE(w.all_stopped());
  EXPECT_EQ(w.state(), State::idle);
}

TEST(Cycle, WalksWithALegThatNeverCalibratesAndSaysSo_Miss_1) {
  World w;
  w.modules[3].position_deg = 90;
  w.modules[3].hall_broken = true;
  w.run(0.2);
  w.send(lss::CommandKind::start, {2, 1, 0, 3});
  ASSERT_TRUE(w.run_until(Mode::walking, 40));
  EXPECT_TRUE(w.has(FaultId::not_calibrated, 4));
}

// Of two statuses in one frame the first may be the one that reports the reset; it may also be
// lost.
TEST(Cycle, AResetIsNoticedWhateverStatusTellsOfIt) {
  for (const bool told : {true, false}) {
    World w;
    ASSERT_TRUE(w.stand());
    w.twice = true;
    const std::uint16_t module = told ? 7 : 2;  // the panel was not calibrated
    w.modules[module - 1u].flags = told ? kFlagReset : 0;
    w.step();
    EXPECT_EQ(w.state(), State::fatal_error);
    EXPECT_TRUE(w.has(FaultId::module_reset, module));
    EXPECT_TRUE(w.all_stopped());
  }
}

TEST(Cycle, AMotorThatGoesOffUnaskedIsAnEmergency) {
  World w;
  ASSERT_TRUE(w.stand());
  w.modules[4].flags &= static_cast<std::uint16_t>(~kFlagMotionControl);
  w.step();
  EXPECT_EQ(w.state(), State::fatal_error);
  EXPECT_TRUE(w.has(FaultId::module_disobeys, 5));
}

TEST(Cycle, ReportsAHotModuleAndGoesOn_Prod_5) {
  World w;
  ASSERT_TRUE(w.stand());
  w.modules[2].temperature_cdegC = 9900;
  w.run(0.1);
  EXPECT_TRUE(w.has(FaultId::temperature_warning, 3));
  EXPECT_EQ(w.state(), State::operational);
  w.modules[2].temperature_cdegC = 2000;
  w.run(0.1);
  EXPECT_FALSE(w.has(FaultId::temperature_warning, 3));
}

// [Prod-1]
TEST(Cycle, SameInputsGiveTheSameBits) {
  World a, b;
  for (World* w : {&a, &b}) {
    w->stand();
    w->send(CommandKind::walk, {1, 0.3, 2});
  }
  for (int i = 0; i < 2000; ++i) {
    a.step();
    b.step();
    ASSERT_EQ(a.out_.command, b.out_.command);
    ASSERT_EQ(a.out_.telemetry.distance_m, b.out_.telemetry.distance_m);
  }
}

TEST(Cycle, NeverAllocates) {
  World w;
  w.run(0.2);
  Request start{.source = source("test"), .sequence = 1, .kind = 1, .lease_ms = 60'000};
  start.parameter = {2, 1, 0, 3};
  w.in_.requests[0] = start;
  w.in_.request_count = 1;
  w.in_.sample_count = 0;
  std::uint64_t before = testing_support::allocations();
  cycle(w.vehicle_, w.supervisor_, w.in_, w.out_, [](Stage) {});
  EXPECT_EQ(testing_support::allocations(), before);
  ASSERT_TRUE(w.run_until(Mode::walking, 40));
  w.in_.request_count = 0;
  before = testing_support::allocations();
  for (int i = 0; i < 1000; ++i) {
    w.in_.time_ns += World::kPeriod;
    cycle(w.vehicle_, w.supervisor_, w.in_, w.out_, [](Stage) {});
  }
  EXPECT_EQ(testing_support::allocations(), before);
}

}  // namespace
}  // namespace lss::zebro
