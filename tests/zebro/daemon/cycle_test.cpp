#include <gtest/gtest.h>

#include <cmath>

#include "idl/angles.h"
#include "idl/zebro/codes.h"
#include "limits.h"
#include "world.h"

namespace lss::zebro {
namespace {

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
  for (std::size_t i = 0; i < kLegs; ++i) EXPECT_NEAR(w.modules[i].position_deg, 254.3, 3);
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
  EXPECT_EQ(w.acks.back().verdict.reason, reasons::too_fast);
  w.send(CommandKind::leg, {4, 3.14159265, 4, 1});
  ASSERT_TRUE(w.run_until([&] { return w.last(Phase::completed)->kind == 106; }, 5));
  for (std::size_t i = 0; i < kLegs; ++i) {
    EXPECT_NEAR(w.modules[i].position_deg, i == 3 ? 180 : before[i].position_deg, 0.1);
  }
}

// The module goes back to a position that it has just passed, instead of once round.
TEST(Cycle, ALegThatHasJustPassedItsPositionIsNotOrderedTooFast) {
  World w;
  w.run(0.2);
  w.send(lss::CommandKind::start, {0});
  w.run(0.2);
  const double passed_deg = std::fmod(w.modules[3].position_deg - 0.5 + 360, 360);
  EXPECT_EQ(w.why(CommandKind::leg, {4, passed_deg * kDegree, 1, 1}), Reason::none);
  ASSERT_TRUE(w.run_until([&] { return w.last(Phase::completed) != nullptr; }, 5));
  EXPECT_NEAR(w.modules[3].position_deg, passed_deg, 0.1);
  const double same_rad = w.modules[3].position_deg * kDegree;
  EXPECT_EQ(w.why(CommandKind::leg, {4, same_rad, 1, 0}), Reason::none) << "where it is";
}

TEST(Cycle, PanelMovesOnlyInIdleAndForbidsStartWhileItIsOut_Func_5) {
  World w;
  w.run(0.2);
  w.send(CommandKind::panel, {1});
  w.run(12);
  ASSERT_EQ(w.last(Phase::completed)->kind, 105);
  w.send(lss::CommandKind::start, {0});
  w.step();
  EXPECT_EQ(w.acks.back().verdict.reason, reasons::panel_deployed);
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

TEST(Cycle, StartIsRefusedAfterAnOverCurrentButNotAfterTheModulesMissedUs) {
  World w;
  w.run(0.2);
  w.modules[2].flags |= kFlagOverCurrent;
  w.run(0.1);
  w.send(lss::CommandKind::start);
  w.step();
  ASSERT_NE(w.last(Phase::rejected), nullptr);
  EXPECT_EQ(w.last(Phase::rejected)->verdict.reason, reasons::fault_latched);
  EXPECT_EQ(w.last(Phase::rejected)->verdict.subject, 3);
  // Their own watchdogs: no message for 8 s, the daemon was down for one.
  w.modules[2].flags = static_cast<std::uint16_t>(w.modules[2].flags & ~kFlagOverCurrent);
  for (IdealModule& m : w.modules) m.flags |= kFlagWatchdog;
  w.run(0.1);
  w.send(lss::CommandKind::start, {1});
  EXPECT_TRUE(w.run_until(Mode::standing, 40));
}

TEST(Cycle, WalksWithALegThatNeverCalibratesAndSaysSo_Miss_1) {
  World w;
  w.modules[3].position_deg = 90;
  w.modules[3].hall_broken = true;
  w.run(0.2);
  w.send(lss::CommandKind::start, {2, 1, 0, 3});
  ASSERT_TRUE(w.run_until(Mode::walking, 40));
  EXPECT_TRUE(w.has(faults::not_calibrated, 4));
}

int legs_in_flight(const World& w) {
  return static_cast<int>(std::ranges::count_if(w.out_.telemetry.modules,
                                                [](const lss_ZebroModule& m) { return m.swing; }));
}

bool rows(World& w, double seconds) {
  return w.run_until([&] { return legs_in_flight(w) == kLegs; }, seconds);
}

// Of walking, from the command.
void strides(World& w, unsigned count) {
  w.send(CommandKind::walk, {1, 0, 3});
  const std::uint32_t before = w.out_.telemetry.steps;
  ASSERT_TRUE(w.run_until([&] { return w.out_.telemetry.steps == before + count; }, 8.0 * count));
}

void stand(World& w) {
  w.send(CommandKind::stand);
  ASSERT_TRUE(w.run_until(Mode::standing, 20));
}

TEST(Cycle, WhereTheBellyLiesInTheSoilItRowsUntilTheWalkEnds) {
  World w;
  ASSERT_TRUE(w.stand());
  w.alter = [](World& x) { draw_in_soil(x, 0.3); };
  w.send(CommandKind::walk, {1, 0, 3});
  ASSERT_TRUE(w.run_until([&] { return w.has(faults::belly_in_soil); }, 14));
  EXPECT_EQ(w.out_.telemetry.steps, 2U);
  EXPECT_EQ(w.state(), State::operational);
  EXPECT_TRUE(rows(w, 10));
  w.alter = nullptr;
  w.send(CommandKind::walk, {1, 0.2, 3});  // goes on
  w.run(5);
  EXPECT_TRUE(rows(w, 10));
  EXPECT_TRUE(w.has(faults::belly_in_soil));
  stand(w);
  w.send(CommandKind::walk, {1, 0, 3});
  EXPECT_FALSE(rows(w, 20));
}

// Where it stopped it still lies in the soil.
TEST(Cycle, ThatTheBellyLiesInTheSoilIsReportedUntilAStrideShowsOtherwise) {
  World w;
  ASSERT_TRUE(w.stand());
  w.alter = [](World& x) { draw_in_soil(x, 0.3); };
  w.send(CommandKind::walk, {1, 0, 3});
  ASSERT_TRUE(w.run_until([&] { return w.has(faults::belly_in_soil); }, 14));
  ASSERT_TRUE(rows(w, 10));
  w.send(lss::CommandKind::stop, {1});
  ASSERT_TRUE(w.run_until(State::idle, 40));
  EXPECT_TRUE(w.has(faults::belly_in_soil));
  w.alter = nullptr;
  ASSERT_TRUE(w.stand());
  EXPECT_TRUE(w.has(faults::belly_in_soil));
  strides(w, 1);
  w.run(0.1);
  EXPECT_FALSE(w.has(faults::belly_in_soil));
  EXPECT_FALSE(rows(w, 20));
}

TEST(Cycle, AfterABellyInTheSoilOneMoreStrideInItIsEnough) {
  World w;
  ASSERT_TRUE(w.stand());
  w.alter = [](World& x) { draw_in_soil(x, 0.3); };
  strides(w, 2);
  stand(w);
  ASSERT_TRUE(w.has(faults::belly_in_soil));
  strides(w, 1);
  EXPECT_TRUE(rows(w, 10));
  EXPECT_TRUE(w.has(faults::belly_in_soil));
}

TEST(Cycle, StridesInSoilCountOverShortWalks) {
  World w;
  ASSERT_TRUE(w.stand());
  w.alter = [](World& x) { draw_in_soil(x, 0.3); };
  strides(w, 1);
  stand(w);
  EXPECT_FALSE(w.has(faults::belly_in_soil));
  strides(w, 1);
  w.run(0.1);
  EXPECT_TRUE(w.has(faults::belly_in_soil));
  EXPECT_TRUE(rows(w, 10));
}

TEST(Cycle, WithoutALegSoilIsNotFelt) {
  for (const unsigned legs : {kAllLegs, kLeftLegs, kRightLegs}) {
    World w;
    ASSERT_TRUE(w.stand());
    w.alter = [=](World& x) { draw_in_soil(x, 0.4, legs); };
    strides(w, legs == kAllLegs ? 2 : 3);
    w.send(lss::CommandKind::stop, {1});
    ASSERT_TRUE(w.run_until(State::idle, 40));
    ASSERT_EQ(w.supervisor_.state().fault_count, 1U);
    w.send(CommandKind::isolate, {2});
    ASSERT_TRUE(w.stand());
    w.send(CommandKind::walk, {1, 0, 3});
    w.run(0.1);
    EXPECT_FALSE(w.run_until([&] { return w.supervisor_.state().fault_count != 0; }, 60));
  }
}

TEST(Cycle, ABellyInTheSoilForOneStrideIsNone) {
  World w;
  ASSERT_TRUE(w.stand());
  w.alter = [](World& x) { draw_in_soil(x, x.out_.telemetry.steps % 2 == 0 ? 0.3 : 0.1); };
  w.send(CommandKind::walk, {1, 0, 3});
  EXPECT_FALSE(w.run_until([&] { return w.has(faults::belly_in_soil); }, 60));
}

TEST(Cycle, WhereASideLiesInTheSoilItRowsAndSaysWhichSide) {
  for (const bool left : {true, false}) {
    const FaultId fault = left ? faults::left_in_soil : faults::right_in_soil;
    World w;
    ASSERT_TRUE(w.stand());
    w.alter = [=](World& x) { draw_in_soil(x, 0.4, left ? kLeftLegs : kRightLegs); };
    w.send(CommandKind::walk, {1, 0, 3});
    ASSERT_TRUE(w.run_until([&] { return w.has(fault); }, 25));
    EXPECT_EQ(w.out_.telemetry.steps, 3U);
    EXPECT_EQ(w.supervisor_.state().fault_count, 1U);
    EXPECT_EQ(w.state(), State::operational);
    EXPECT_TRUE(rows(w, 10));
    stand(w);
    EXPECT_TRUE(w.has(fault));
    strides(w, 1);  // one more is enough
    EXPECT_TRUE(rows(w, 10));
    EXPECT_TRUE(w.has(fault));
    stand(w);
    w.alter = nullptr;
    strides(w, 1);
    w.run(0.1);
    EXPECT_EQ(w.supervisor_.state().fault_count, 0U);
    EXPECT_FALSE(rows(w, 20));
  }
}

TEST(Cycle, TelemetrySaysHowMuchOfASideLiesInTheSoilAndThatItRows) {
  for (const bool left : {true, false}) {
    World w;
    const lss_ZebroTelemetry& t = w.out_.telemetry;
    const double& soft = t.soil_share[left ? 0 : 1];
    const double& firm = t.soil_share[left ? 1 : 0];
    w.run(0.2);
    EXPECT_TRUE(std::isnan(soft) && std::isnan(firm));
    ASSERT_TRUE(w.stand());
    w.alter = [=](World& x) { draw_in_soil(x, 0.4, left ? kLeftLegs : kRightLegs); };
    strides(w, 1);
    w.run(0.1);
    EXPECT_NEAR(soft, 0.4, 0.02);
    EXPECT_EQ(firm, 0);
    EXPECT_FALSE(t.rows);
    ASSERT_TRUE(rows(w, 30));
    EXPECT_TRUE(t.rows);
    stand(w);
    w.run(0.1);
    EXPECT_FALSE(t.rows);
    EXPECT_NEAR(soft, 0.4, 0.02) << "of the last stride";
    w.alter = nullptr;
    strides(w, 1);
    w.run(0.1);
    EXPECT_EQ(soft, 0);
    w.send(lss::CommandKind::stop, {1});
    ASSERT_TRUE(w.run_until(State::idle, 40));
    w.send(CommandKind::isolate, {2});
    w.run(0.1);
    EXPECT_TRUE(std::isnan(soft) && std::isnan(firm)) << "all legs are needed";
  }
}

// Nor where it touches the soil, as when it turns on the spot in sand.
TEST(Cycle, ASideInTheSoilForTwoStridesIsNone) {
  for (const bool touches : {false, true}) {
    World w;
    ASSERT_TRUE(w.stand());
    w.alter = [=](World& x) {
      draw_in_soil(x, touches ? 0.3 : x.out_.telemetry.steps % 3 < 2 ? 0.4 : 0, kLeftLegs);
    };
    w.send(CommandKind::walk, {1, 0, 3});
    EXPECT_FALSE(w.run_until([&] { return w.supervisor_.state().fault_count != 0; }, 80));
  }
}

// Of the belly in the soil only one warning is reported, whichever side comes first.
TEST(Cycle, TheOtherSideInTheSoilAsWellIsTheBelly) {
  World w;
  ASSERT_TRUE(w.stand());
  w.alter = [](World& x) {
    draw_in_soil(x, 0.4, x.out_.telemetry.steps < 1 ? kLeftLegs : kAllLegs);
  };
  w.send(CommandKind::walk, {1, 0, 3});
  ASSERT_TRUE(w.run_until([&] { return w.supervisor_.state().fault_count != 0; }, 30));
  EXPECT_TRUE(w.has(faults::belly_in_soil));
  stand(w);
  w.alter = [](World& x) { draw_in_soil(x, 0.4, kRightLegs); };
  strides(w, 1);
  w.run(0.1);
  EXPECT_TRUE(w.has(faults::right_in_soil));
  EXPECT_EQ(w.supervisor_.state().fault_count, 1U);
}

// Of two statuses in one frame the first may be the one that reports the reset; it may also be
// lost.
TEST(Cycle, AResetIsNoticedFromEitherStatusOfAFrame) {
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

// The status after the first one is lost, and the next one comes when it is operational.
TEST(Cycle, TheFirstStatusAfterBootIsNoResetLater) {
  World w;
  w.step();
  w.modules[1].says_status = false;
  w.step();
  w.send(lss::CommandKind::start, {1});
  w.step();
  w.modules[1].says_status = true;
  EXPECT_TRUE(w.run_until(Mode::standing, 40));
}

// Noise of which the check fits, docs/icd-zebro.md section 3: one flag is wrong in one status.
TEST(Cycle, AFlagThatOneStatusAloneHasStopsNothing_Env_2) {
  for (const std::uint16_t wrong : {kFlagMotionControl, kFlagCalibrated, kFlagOverCurrent,
                                    kFlagDriverFault, kFlagWatchdog, kFlagReset}) {
    for (const int statuses : {1, 2}) {
      World w;
      ASSERT_TRUE(w.stand());
      const std::uint16_t right = w.modules[2].flags;
      for (int n = 0; n < statuses; ++n) {
        w.modules[2].flags = right ^ wrong;
        w.step();
      }
      w.modules[2].flags = right;
      w.run(0.1);
      const bool believed = statuses == 2 && wrong != kFlagReset;  // nobody else has a word of it
      EXPECT_EQ(w.state(), believed ? State::fatal_error : State::operational)
          << "flag " << wrong << " in " << statuses;
    }
  }
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

TEST(Cycle, SolvingLeavesWarningsWhoseCauseIsThere_Prod_5) {
  World w;
  ASSERT_TRUE(w.stand());
  w.modules[2].temperature_cdegC = 9900;
  w.run(0.1);
  w.send(lss::CommandKind::emergency_stop);
  ASSERT_TRUE(w.run_until(State::fatal_error, 0.1));
  w.send(lss::CommandKind::solve);
  ASSERT_TRUE(w.run_until(State::idle, 60));
  EXPECT_TRUE(w.has(FaultId::temperature_warning, 3));
  EXPECT_EQ(w.supervisor_.state().fault_count, 1u) << "the emergency is solved";
}

}  // namespace
}  // namespace lss::zebro
