// Accepted commands of each mode, and the rejections of all others.

#include <gtest/gtest.h>

#include "idl/talaris/codes.h"
#include "world.h"

namespace lss::talaris {
namespace {

TEST(TalarisModes, EverythingIsShutBeforeAnything) {
  World w;
  w.run(1);
  EXPECT_EQ(w.state(), State::idle);
  EXPECT_TRUE(w.shut());
  EXPECT_FALSE(w.orders().all_stop);
  EXPECT_EQ(w.orders().issued_ns, w.time_ns_);
  EXPECT_EQ(w.orders().release_ns, w.time_ns_ + 5 * kMillisecond);
  EXPECT_TRUE(w.orders().boot_allowed);
}

TEST(TalarisModes, StartIsManualWithEverythingShut) {
  World w;
  ASSERT_TRUE(w.start());
  EXPECT_TRUE(w.shut());
  ASSERT_NE(w.last(lss::Phase::completed), nullptr);
  EXPECT_EQ(w.last(lss::Phase::completed)->kind, 1);
}

// The three steps of the GNC come in their order only (TALARIS thesis 4.5.1).
TEST(TalarisModes, StandbyCalibrateExecuteInThisOrderOnly) {
  World w;
  ASSERT_TRUE(w.start());
  EXPECT_EQ(w.why(Kind::gnc, {1}), Reason::not_in_mode);
  EXPECT_EQ(w.why(Kind::gnc, {2}), Reason::not_in_mode);
  ASSERT_EQ(w.why(Kind::gnc, {0}), Reason::none);
  EXPECT_EQ(w.why(Kind::gnc, {2}), reasons::not_calibrated);
  ASSERT_EQ(w.why(Kind::gnc, {1}), Reason::none);
  EXPECT_EQ(w.mode(), Mode::calibrate);
  EXPECT_EQ(w.why(Kind::gnc, {2}), Reason::not_in_mode);
  ASSERT_TRUE(w.run_until(Mode::standby, 10));
  EXPECT_EQ(w.why(Kind::gnc, {2}), reasons::not_planned);
}

TEST(TalarisModes, ManualCommandsAreRefusedWhileTheGncIsOn) {
  World w;
  ASSERT_TRUE(w.start());
  ASSERT_TRUE(w.arm());
  ASSERT_EQ(w.why(Kind::gnc, {0}), Reason::none);
  const auto refused = [&] {
    EXPECT_EQ(w.why(Kind::valve, {1, 1, 1}), Reason::not_in_mode);
    EXPECT_EQ(w.why(Kind::pulse, {1, 0.1, 0, 1}), Reason::not_in_mode);
    EXPECT_EQ(w.why(Kind::edf_throttle, {15, 0.5}), Reason::not_in_mode);
    EXPECT_EQ(w.why(Kind::edf_rpm, {15, 5000, 4000}), Reason::not_in_mode);
    EXPECT_EQ(w.why(Kind::edf_arm, {0}), Reason::not_in_mode);
    EXPECT_EQ(w.why(Kind::script_run, {1}), Reason::not_in_mode);
    EXPECT_TRUE(w.shut());
  };
  refused();
  ASSERT_EQ(w.why(Kind::gnc, {1}), Reason::none);
  refused();
}

TEST(TalarisModes, ManualAndDutyCycleAndBack) {
  World w;
  ASSERT_TRUE(w.start());
  EXPECT_EQ(w.why(Kind::pulse, {1, 0.1, 0, 1}), Reason::not_in_mode);
  ASSERT_EQ(w.why(Kind::duty_cycle), Reason::none);
  EXPECT_EQ(w.mode(), Mode::duty_cycle);
  EXPECT_EQ(w.why(Kind::valve, {1, 1, 1}), Reason::not_in_mode);
  ASSERT_EQ(w.why(Kind::manual), Reason::none);
  EXPECT_EQ(w.mode(), Mode::manual);
}

TEST(TalarisModes, GoingManualForgetsTheCalibration) {
  World w;
  ASSERT_TRUE(w.start());
  ASSERT_TRUE(w.calibrate());
  ASSERT_EQ(w.why(Kind::manual), Reason::none);
  EXPECT_FALSE(w.out_.telemetry.calibrated);
  ASSERT_EQ(w.why(Kind::gnc, {0}), Reason::none);
  EXPECT_EQ(w.why(Kind::gnc, {2}), reasons::not_calibrated);
}

// In Execute, the fans on their way to their speed, on the ground.
bool spin_up(World& w) {
  if (!w.start() || !w.arm() || !w.calibrate()) return false;
  w.send(Kind::plan, {double(Program::hop), 2, 5, 0, 0});
  w.step();
  w.send(Kind::gnc, {2});
  return w.run_until(Phase::spin_up, 1) && w.mode() == Mode::execute;
}

TEST(TalarisModes, LeavingTheSpinUpDropsThePlanAndTheNextFlightNeedsAnotherPlan) {
  for (const Kind way : {Kind::manual, Kind::duty_cycle}) {
    World w;
    ASSERT_TRUE(spin_up(w));
    ASSERT_EQ(w.why(way), Reason::none);
    EXPECT_TRUE(w.shut());
    EXPECT_FALSE(w.out_.telemetry.planned);
    ASSERT_TRUE(w.calibrate());
    EXPECT_EQ(w.why(Kind::gnc, {2}), reasons::not_planned);
    ASSERT_EQ(w.why(Kind::plan, {double(Program::hop), 2, 5, 0, 0}), Reason::none);
    ASSERT_EQ(w.why(Kind::gnc, {2}), Reason::none);
    EXPECT_TRUE(w.run_until([&] { return w.airborne(); }, 30));
    EXPECT_EQ(w.supervisor_.state().fault_count, 0u);
  }
}

// A flight abandoned without the controller does not count.
TEST(TalarisModes, ExecuteWithoutAPlanFailsAndIsBackInStandby) {
  World w;
  ASSERT_TRUE(w.start());
  ASSERT_TRUE(w.arm());
  ASSERT_TRUE(w.calibrate());
  ASSERT_EQ(w.why(Kind::plan, {double(Program::hop), 2, 5, 0, 0}), Reason::none);
  w.vehicle_.act(kExecute, nullptr);
  w.vehicle_.act(kShut, nullptr);
  ASSERT_EQ(w.why(Kind::gnc, {2}), Reason::none);
  ASSERT_TRUE(w.run_until(Mode::standby, 1));
  EXPECT_EQ(w.state(), State::operational);
  ASSERT_NE(w.last(lss::Phase::failed), nullptr);
  EXPECT_EQ(w.last(lss::Phase::failed)->verdict.reason, reasons::not_planned);
  EXPECT_FALSE(w.out_.telemetry.planned);
}

TEST(TalarisModes, AFlightThatStopsEverythingLatchesAFault) {
  World w;
  ASSERT_TRUE(spin_up(w));
  w.vehicle_.act(kShut, nullptr);
  ASSERT_TRUE(w.run_until(State::fatal_error, 1));
  EXPECT_TRUE(w.has(FaultId::stop_not_followed));
}

// Stops one after the other are pending in frame after frame, and each was followed: the vehicle
// stands still.
TEST(TalarisModes, SolveRightAfterManyStopsIsSolved) {
  World w;
  ASSERT_TRUE(w.start());
  ASSERT_EQ(w.why(lss::CommandKind::emergency_stop), Reason::none);
  ASSERT_EQ(w.state(), State::fatal_error);
  w.in_.bus.edges.all_stop_pending = true;
  for (int i = 0; i < 10; ++i) w.step();
  ASSERT_EQ(w.why(lss::CommandKind::solve), Reason::none);
  EXPECT_EQ(w.state(), State::solve_errors);
  EXPECT_FALSE(w.has(FaultId::stop_not_followed));
  w.in_.bus.edges.all_stop_pending = false;
  EXPECT_TRUE(w.run_until(State::idle, 10));
}

TEST(TalarisModes, AScriptIsAbortedByAnyone) {
  World w;
  ASSERT_TRUE(w.start());
  ASSERT_EQ(w.why(Kind::script_begin, {7, 1}), Reason::none);
  ASSERT_EQ(w.why(Kind::script_step, {7, 0, 0, 0, 1, 0.5}), Reason::none);
  ASSERT_EQ(w.why(Kind::script_run, {7}), Reason::none);
  EXPECT_EQ(w.ask(Kind::pulse, {1, 0.1, 0, 1}, "another").reason, Reason::not_authorised);
  EXPECT_EQ(w.ask(Kind::script_abort, {}, "another").reason, Reason::none);
  EXPECT_EQ(w.state(), State::fatal_error);
  EXPECT_TRUE(w.shut());
}

TEST(TalarisModes, LandOnTheGroundIsRefused) {
  World w;
  ASSERT_TRUE(w.start());
  EXPECT_EQ(w.why(Kind::land), Reason::not_in_flight);
}

TEST(TalarisModes, ValvesThatAreDisabledDoNotFire) {
  World w;
  ASSERT_TRUE(w.start());
  ASSERT_EQ(w.why(Kind::enable, {0b11111101}), Reason::none);
  const Verdict v = w.ask(Kind::valve, {0b11, 1, 1});
  EXPECT_EQ(v.reason, reasons::valve_disabled);
  EXPECT_EQ(v.measured, 2) << "valve 2";
  EXPECT_EQ(w.why(Kind::valve, {0b1, 1, 1}), Reason::none);
  EXPECT_EQ(w.orders().enabled, 0b11111101);
}

TEST(TalarisModes, APulseLongerThanTheFrameIsRefusedWithBothNumbers) {
  World w;
  ASSERT_TRUE(w.start());
  ASSERT_EQ(w.why(Kind::duty_cycle), Reason::none);
  const Verdict v = w.ask(Kind::pulse, {1, 0.16, 0.06, 5});
  EXPECT_EQ(v.reason, reasons::pulse_too_long);
  EXPECT_NEAR(v.measured, 0.22, 1e-12);
  EXPECT_NEAR(v.limit, 0.2, 1e-12);
  EXPECT_TRUE(w.shut());
}

TEST(TalarisModes, FansNeedTheirStartUpFirst) {
  World w;
  ASSERT_TRUE(w.start());
  EXPECT_EQ(w.why(Kind::edf_throttle, {15, 0.1}), reasons::fans_not_armed);
  EXPECT_EQ(w.why(Kind::edf_rpm, {15, 3000, 4000}), reasons::fans_not_armed);
  ASSERT_TRUE(w.arm());
  EXPECT_EQ(w.why(Kind::edf_throttle, {15, 0.1}), Reason::none);
}

TEST(TalarisModes, FansThatWereStartedBeforeCountAsArmedAndNothingIsSent) {
  World w;
  ASSERT_TRUE(w.start());
  ASSERT_EQ(w.why(Kind::edf_arm, {1}), Reason::none);
  EXPECT_TRUE(w.shut());
  EXPECT_TRUE(w.out_.telemetry.fans[3].armed);
}

TEST(TalarisModes, ASetOfGainsThatIsNotThereIsRefused) {
  Parameters p = quick();
  p.flight.gain_sets = 2;
  World w(p);
  w.run(1);
  const Verdict v = w.ask(Kind::gains, {3});
  EXPECT_EQ(v.reason, reasons::no_such_gains);
  EXPECT_EQ(v.limit, 2);
  EXPECT_EQ(w.why(Kind::gains, {2}), Reason::none);
  EXPECT_EQ(w.out_.telemetry.gains, 2);
}

TEST(TalarisModes, WhatCannotBeResetIsSaid) {
  World w;
  EXPECT_EQ(w.why(lss::CommandKind::reset, {2}), Reason::not_a_choice);
  EXPECT_EQ(w.why(lss::CommandKind::reset, {1}), Reason::none);
}

}  // namespace
}  // namespace lss::talaris
