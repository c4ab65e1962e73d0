// Calibrate, plan, execute and land, in the daemon.

#include <gtest/gtest.h>

#include "idl/talaris/codes.h"
#include "world.h"

namespace lss::talaris {
namespace {

TEST(TalarisGnc, CalibratesStandingStill) {
  World w;
  ASSERT_TRUE(w.start());
  ASSERT_TRUE(w.calibrate());
  EXPECT_NE(w.heard(events::calibrated), nullptr);
  EXPECT_EQ(w.last(lss::Phase::completed)->kind, 310);
  EXPECT_NEAR(w.out_.telemetry.position_m[0], 0.5, 0.01) << "height of the centre of mass";
  EXPECT_NEAR(w.out_.telemetry.attitude_wxyz[0], 1, 1e-6);
}

TEST(TalarisGnc, MovementWhileCalibratingFailsItWithTheReason) {
  World w;
  ASSERT_TRUE(w.start());
  w.send(Kind::gnc, {0});
  w.step();
  w.send(Kind::gnc, {1});
  w.step();
  w.shake = 1;
  ASSERT_TRUE(w.run_until(Mode::standby, 30));
  EXPECT_FALSE(w.out_.telemetry.calibrated);
  ASSERT_NE(w.heard(EventId::calibration_refused), nullptr);
  ASSERT_NE(w.last(lss::Phase::failed), nullptr);
  EXPECT_EQ(w.last(lss::Phase::failed)->verdict.reason, reasons::moved);
  EXPECT_EQ(w.why(Kind::gnc, {2}), reasons::not_calibrated);
  w.shake = 0;
  ASSERT_EQ(w.why(Kind::gnc, {1}), Reason::none);
  ASSERT_TRUE(w.run_until(Mode::standby, 10));
  EXPECT_TRUE(w.out_.telemetry.calibrated);
}

TEST(TalarisGnc, AnInfeasibleHopIsRefusedWithItsNumbers) {
  Parameters p = quick();
  p.flight.thrusters.force_N = 40;
  World w(p);
  ASSERT_TRUE(w.start());
  const Verdict v = w.ask(Kind::plan, {0, 2, 30, 0, 0});
  EXPECT_EQ(v.reason, reasons::gas_short);
  EXPECT_GT(v.measured, v.limit);
  EXPECT_LE(v.limit, 44);
  EXPECT_FALSE(w.out_.telemetry.planned);
  EXPECT_EQ(w.why(Kind::plan, {0, 9.9, 99, 0, 0.5}) == Reason::none, false);
}

TEST(TalarisGnc, APlanIsReportedWithTimeAndGas) {
  World w;
  ASSERT_TRUE(w.start());
  ASSERT_EQ(w.why(Kind::plan, {0, 2, 30, 0, 0}), Reason::none);
  EXPECT_TRUE(w.out_.telemetry.planned);
  ASSERT_NE(w.heard(EventId::planned), nullptr);
  EXPECT_GT(w.heard(EventId::planned)->argument[1], 10);
  EXPECT_GT(w.heard(EventId::planned)->argument[2], 20);
  EXPECT_LT(w.heard(EventId::planned)->argument[2], 44);
}

TEST(TalarisGnc, ExecuteNeedsStartedFansEnabledValvesAndPressure) {
  World w;
  ASSERT_TRUE(w.start());
  ASSERT_TRUE(w.calibrate());
  ASSERT_EQ(w.why(Kind::plan, {0, 2, 5, 0, 0}), Reason::none);
  EXPECT_EQ(w.why(Kind::gnc, {2}), reasons::fans_not_armed);
  ASSERT_EQ(w.why(Kind::manual), Reason::none);
  ASSERT_TRUE(w.arm());
  ASSERT_TRUE(w.calibrate());
  ASSERT_EQ(w.why(Kind::enable, {0x7F}), Reason::none);
  EXPECT_EQ(w.ask(Kind::gnc, {2}).measured, 8) << "valve 8";
  ASSERT_EQ(w.why(Kind::enable, {0xFF}), Reason::none);
  w.regulated_kPa = 100;
  w.run(10);
  EXPECT_EQ(w.why(Kind::gnc, {2}), reasons::pressure_low);
  w.regulated_kPa = 2000;
  w.run(10);
  w.altimeter_alive = false;
  w.run(3);
  const Verdict v = w.ask(Kind::gnc, {2});
  EXPECT_EQ(v.reason, reasons::altimeter_lost);
  EXPECT_EQ(v.subject, kAltimeterModule);
  w.altimeter_alive = true;
  w.run(1);
  EXPECT_EQ(w.why(Kind::gnc, {2}), Reason::none);
  EXPECT_EQ(w.mode(), Mode::execute);
}

TEST(TalarisGnc, GasThatIsGoneSinceItWasPlannedIsFoundAtExecute) {
  World w;
  ASSERT_TRUE(w.start());
  ASSERT_TRUE(w.arm());
  ASSERT_EQ(w.why(Kind::plan, {0, 2, 30, 0, 0}), Reason::none);
  ASSERT_EQ(w.why(Kind::valve, {0xFF, 1, 2.5}), Reason::none);
  w.run(4);
  ASSERT_TRUE(w.calibrate());
  const Verdict v = w.ask(Kind::gnc, {2});
  EXPECT_EQ(v.reason, reasons::gas_short);
  EXPECT_GT(v.measured, v.limit);
}

TEST(TalarisGnc, HopsUpAlongAndDownAndEndsInStandby) {
  World w;
  ASSERT_TRUE(w.fly(Program::hop));
  EXPECT_EQ(w.mode(), Mode::execute);
  EXPECT_TRUE(w.out_.telemetry.airborne);
  EXPECT_NE(w.heard(events::lifted_off), nullptr);
  double highest_m = 0;
  ASSERT_TRUE(w.run_until(
      [&] {
        highest_m = std::max(highest_m, w.height_m);
        return w.mode() == Mode::standby;
      },
      60));
  EXPECT_NEAR(highest_m, 2, 0.4);
  EXPECT_NEAR(w.along_m, 5, 0.5);
  EXPECT_LT(w.landing_m_s, 0.5);
  EXPECT_TRUE(w.shut());
  EXPECT_EQ(w.height_m, 0);
  const EventRecord* landed = w.heard(events::landed);
  ASSERT_NE(landed, nullptr);
  EXPECT_GT(landed->argument[0], 0) << "down is positive";
  EXPECT_GT(landed->argument[0], w.landing_m_s - 0.05);
  EXPECT_LT(landed->argument[0], w.landing_m_s + 0.25) << "of the fastest foot, not of the body";
  EXPECT_EQ(w.last(lss::Phase::completed)->kind, 310);
  EXPECT_EQ(w.supervisor_.state().fault_count, 0u);
  EXPECT_EQ(w.supervisor_.state().safe_commands, 0u);
  EXPECT_NEAR(w.out_.telemetry.gas_thruster_s, w.gas_s, 1.5);
  EXPECT_FALSE(w.out_.telemetry.calibrated) << "each run is calibrated and planned";
  EXPECT_EQ(w.why(Kind::gnc, {2}), reasons::not_calibrated);
}

TEST(TalarisGnc, InTheAirItCanBeLandedAndStoppedButNotTakenByHand) {
  World w;
  ASSERT_TRUE(w.fly(Program::hop, 2, 30));
  EXPECT_EQ(w.why(Kind::manual), reasons::in_flight);
  EXPECT_EQ(w.why(Kind::gnc, {0}), reasons::in_flight);
  EXPECT_EQ(w.why(Kind::plan, {0, 2, 5, 0, 0}), Reason::not_in_mode);
  EXPECT_EQ(w.why(lss::CommandKind::reset, {-1}), reasons::in_flight);
  ASSERT_EQ(w.why(Kind::land), Reason::none);
  EXPECT_TRUE(w.airborne());
  ASSERT_TRUE(w.run_until(Mode::standby, 30));
  EXPECT_LT(w.along_m, 25) << "not as far as planned";
  EXPECT_LT(w.landing_m_s, 0.6);
  EXPECT_EQ(w.state(), State::operational);
}

TEST(TalarisGnc, AnyoneMayLandItAndNobodyElseMayStopIt) {
  World w;
  ASSERT_TRUE(w.fly(Program::hop, 2, 30));
  EXPECT_EQ(w.ask(Kind::gains, {1}, "another").reason, Reason::not_authorised);
  ASSERT_EQ(w.ask(Kind::land, {}, "another").reason, Reason::none);
  EXPECT_TRUE(w.airborne());
  ASSERT_NE(w.last(lss::Phase::superseded), nullptr) << "the holder hears it";
  ASSERT_TRUE(w.run_until(Mode::standby, 30));
  EXPECT_LT(w.landing_m_s, 0.6);
  EXPECT_STREQ(w.supervisor_.state().authority.data(), "test") << "it is still the holder's";
}

TEST(TalarisGnc, TelemetryReportsTargetPositionAndVelocity) {
  World w;
  ASSERT_TRUE(w.fly(Program::hop, 2, 5));
  EXPECT_NEAR(w.out_.telemetry.target_position_m[0], 0.5 + 2, 0.1) << "it stands 0.5 m high";
  EXPECT_EQ(w.out_.telemetry.target_velocity_m_s[0], 0) << "to rest at the top";
  ASSERT_TRUE(w.run_until(Phase::descend, 40));
  EXPECT_EQ(w.out_.telemetry.target_velocity_m_s[0],
            -w.parameters_.flight.profile.touchdown_speed_m_s);
}

TEST(TalarisGnc, StopInTheAirLandsAndThenSwitchesOff) {
  World w;
  ASSERT_TRUE(w.fly(Program::hop, 2, 30));
  ASSERT_EQ(w.why(lss::CommandKind::stop), Reason::none);
  EXPECT_EQ(w.state(), State::operational);
  EXPECT_FALSE(w.shut());
  ASSERT_TRUE(w.run_until(State::idle, 30));
  EXPECT_EQ(w.height_m, 0);
  EXPECT_LT(w.landing_m_s, 0.6);
  EXPECT_TRUE(w.shut());
  w.step();
  EXPECT_EQ(w.last(lss::Phase::completed)->kind, 2);
}

TEST(TalarisGnc, ALeaseThatExpiresInTheAirLandsAndThenSwitchesOff) {
  World w;
  ASSERT_TRUE(w.fly(Program::hop, 2, 30));
  w.heartbeat_ = false;
  ASSERT_TRUE(w.run_until([&] { return w.heard(EventId::lease_expired) != nullptr; }, 3));
  EXPECT_TRUE(w.airborne());
  EXPECT_FALSE(w.shut());
  ASSERT_TRUE(w.run_until(State::idle, 30));
  EXPECT_EQ(w.height_m, 0);
  EXPECT_LT(w.landing_m_s, 0.6);
}

TEST(TalarisGnc, AnObcThatIsSilentInTheAirLandsIt) {
  World w(quick(), {.obc_timeout_ns = 600 * kMillisecond});
  ASSERT_TRUE(w.fly(Program::hop, 2, 30));
  w.heartbeat_ = false;
  w.run(1);
  EXPECT_EQ(w.state(), State::operational);
  EXPECT_TRUE(w.airborne());
  ASSERT_TRUE(w.run_until(State::idle, 30));
  EXPECT_EQ(w.height_m, 0);
  EXPECT_LT(w.landing_m_s, 0.6);
}

TEST(TalarisGnc, ADaemonThatIsStoppedInTheAirLandsFirst) {
  World w;
  ASSERT_TRUE(w.fly(Program::hop, 2, 30));
  w.in_.shut_down = true;
  w.step();
  EXPECT_TRUE(w.airborne());
  EXPECT_FALSE(w.shut());
  ASSERT_TRUE(w.run_until(State::idle, 25));
  EXPECT_EQ(w.height_m, 0);
  EXPECT_LT(w.landing_m_s, 0.6);
  EXPECT_TRUE(w.shut());
}

TEST(TalarisGnc, AnEmergencyStopInTheAirStopsEverythingAtOnce) {
  World w;
  ASSERT_TRUE(w.fly(Program::hop));
  w.send(lss::CommandKind::emergency_stop, {}, "anyone");
  w.step();
  ASSERT_NE(w.last(lss::Phase::completed), nullptr);
  EXPECT_EQ(w.last(lss::Phase::completed)->verdict.reason, Reason::fell);
  EXPECT_EQ(w.state(), State::fatal_error);
  EXPECT_TRUE(w.shut());
  EXPECT_TRUE(w.orders().all_stop);
  w.send(lss::CommandKind::emergency_stop);
  w.step();
  EXPECT_EQ(w.last(lss::Phase::completed)->verdict.reason, Reason::none) << "it fell once";
}

TEST(TalarisGnc, StandbyOnTheGroundBreaksOff) {
  World w;
  ASSERT_TRUE(w.start());
  ASSERT_TRUE(w.arm());
  ASSERT_TRUE(w.calibrate());
  ASSERT_EQ(w.why(Kind::plan, {0, 2, 5, 0, 0}), Reason::none);
  ASSERT_EQ(w.why(Kind::gnc, {2}), Reason::none);
  ASSERT_TRUE(w.run_until(Phase::spin_up, 2));
  ASSERT_EQ(w.why(Kind::gnc, {0}), Reason::none);
  EXPECT_EQ(w.mode(), Mode::standby);
  EXPECT_TRUE(w.shut());
  w.run(2);
  EXPECT_TRUE(w.shut());
  EXPECT_EQ(w.state(), State::operational);
}

TEST(TalarisGnc, FullTanksAtStartRestoreTheGasBudget) {
  World w;
  ASSERT_TRUE(w.start());
  ASSERT_EQ(w.why(Kind::valve, {0xFF, 1, 2}), Reason::none);
  w.run(3);
  EXPECT_LT(w.out_.telemetry.gas_left_thruster_s, 30);
  w.send(lss::CommandKind::stop);
  ASSERT_TRUE(w.run_until(State::idle, 2));
  w.tank_kPa = 20000;
  w.run(10);
  w.send(lss::CommandKind::start);
  w.run(1);
  EXPECT_LT(w.out_.telemetry.gas_left_thruster_s, 30) << "not refilled";
  w.send(lss::CommandKind::stop);
  w.run(1);
  w.tank_kPa = 31026;
  w.run(10);
  w.send(lss::CommandKind::start);
  w.run(1);
  EXPECT_NEAR(w.out_.telemetry.gas_left_thruster_s, 44, 0.5);
}

}  // namespace
}  // namespace lss::talaris
