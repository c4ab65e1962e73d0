// Bad inputs and failures: each has its reaction, on the ground and in the air.

#include <gtest/gtest.h>

#include "idl/talaris/codes.h"
#include "world.h"

namespace lss::talaris {
namespace {

template <class T>
void remove(std::vector<TalarisSample>& samples) {
  std::erase_if(samples, [](const auto& s) { return std::holds_alternative<T>(s.reading); });
}

TEST(TalarisFaults, ASilentImuIsReportedAndCalibrationRefused) {
  World w;
  ASSERT_TRUE(w.start());
  ASSERT_EQ(w.why(Kind::gnc, {0}), Reason::none);
  w.imu_alive = false;
  w.run(1);
  EXPECT_TRUE(w.has(faults::imu_silent, kImuModule));
  EXPECT_EQ(w.state(), State::operational) << "a warning on the ground";
  const Verdict v = w.ask(Kind::gnc, {1});
  EXPECT_EQ(v.reason, Reason::imu_lost);
  EXPECT_EQ(v.subject, kImuModule);
  w.imu_alive = true;
  w.run(1);
  EXPECT_FALSE(w.has(faults::imu_silent, kImuModule));
  EXPECT_EQ(w.why(Kind::gnc, {1}), Reason::none);
}

TEST(TalarisFaults, AnImuThatFallsSilentWhileCalibratingFailsIt) {
  World w;
  ASSERT_TRUE(w.start());
  ASSERT_EQ(w.why(Kind::gnc, {0}), Reason::none);
  ASSERT_EQ(w.why(Kind::gnc, {1}), Reason::none);
  w.imu_alive = false;
  ASSERT_TRUE(w.run_until(Mode::standby, 2));
  EXPECT_EQ(w.last(lss::Phase::failed)->verdict.reason, Reason::imu_lost);
}

TEST(TalarisFaults, AnImuThatWasCalibratedAndFellSilentHasToBeCalibratedAgain) {
  World w;
  ASSERT_TRUE(w.start());
  ASSERT_TRUE(w.calibrate());
  w.imu_alive = false;
  w.run(1);
  w.imu_alive = true;
  w.run(1);
  EXPECT_EQ(w.why(Kind::gnc, {2}), reasons::not_calibrated);
}

TEST(TalarisFaults, AStuckImuIsNotBelieved) {
  World w;
  ASSERT_TRUE(w.start());
  ASSERT_TRUE(w.calibrate());
  w.distort = [](std::vector<TalarisSample>& samples) {
    for (TalarisSample& s : samples) {
      if (auto* imu = std::get_if<ImuPacket>(&s.reading)) {
        imu->rate_rad_s = {0.1, 0, 0};
        imu->force_m_s2 = {9.8, 0, 0};
      }
    }
  };
  w.run(2);
  EXPECT_TRUE(w.has(faults::imu_stuck, kImuModule));
  EXPECT_FALSE(w.out_.telemetry.modules[0].online);
  EXPECT_EQ(w.why(Kind::gnc, {1}), Reason::imu_lost);
  EXPECT_NEAR(w.out_.telemetry.attitude_wxyz[1], 0, 0.005) << "0.1 rad/s was not taken in";
}

TEST(TalarisFaults, LostPacketsAreCountedAndManyAreAFault) {
  World w;
  ASSERT_TRUE(w.start());
  w.imu_count += 3;
  w.step();
  ASSERT_NE(w.heard(events::imu_packets_lost), nullptr);
  EXPECT_EQ(w.heard(events::imu_packets_lost)->argument[0], 3);
  EXPECT_EQ(w.out_.telemetry.modules[0].lost, 3u);
  EXPECT_FALSE(w.has(faults::imu_lossy, kImuModule));
  for (int i = 0; i < 5; ++i) {
    w.imu_count += 10;
    w.step();
  }
  EXPECT_TRUE(w.has(faults::imu_lossy, kImuModule));
  w.run(10);
  EXPECT_FALSE(w.has(faults::imu_lossy, kImuModule)) << "it goes when it is over";
}

TEST(TalarisFaults, SamplesThatFoundNoRoomCountAsDropped) {
  World w;
  ASSERT_TRUE(w.start());
  const std::uint64_t before = w.out_.telemetry.bus_frames_dropped;
  w.in_.bus.can.port.overflows += 2;
  w.in_.bus.altimeter.status.counters.overflows += 3;
  w.step();
  EXPECT_EQ(w.out_.telemetry.bus_frames_dropped, before + 5);
}

TEST(TalarisFaults, ACounterThatGoesBackIsNoLoss) {
  World w;
  ASSERT_TRUE(w.start());
  w.imu_count = 5;
  w.run(1);
  EXPECT_EQ(w.out_.telemetry.modules[0].lost, 0u);
}

TEST(TalarisFaults, AScaleThatChangesIsReported) {
  World w;
  ASSERT_TRUE(w.start());
  std::uint8_t scale = 1;
  w.distort = [&](std::vector<TalarisSample>& samples) {
    samples.push_back({.time_ns = samples.back().time_ns,
                       .reading = ImuStatus{.kind = ImuStatus::Kind::scale, .value = scale}});
  };
  w.run(1);
  EXPECT_EQ(w.heard(events::imu_scale_changed), nullptr) << "the first says what it is";
  scale = 2;
  w.run(1);
  ASSERT_NE(w.heard(events::imu_scale_changed), nullptr);
  EXPECT_EQ(w.heard(events::imu_scale_changed)->argument[0], 1);
  EXPECT_EQ(w.heard(events::imu_scale_changed)->argument[1], 2);
}

TEST(TalarisFaults, AnImuThatSaysThatItsSelfTestFailedBeginsNoFlight) {
  World w;
  ASSERT_TRUE(w.start() && w.arm() && w.calibrate());
  ASSERT_EQ(w.why(Kind::plan, {double(Program::hop), 2, 5, 0, 0}), Reason::none);
  std::uint8_t flags = 0x04;
  w.distort = [&](std::vector<TalarisSample>& samples) {
    samples.push_back({.time_ns = samples.back().time_ns,
                       .reading = ImuStatus{.kind = ImuStatus::Kind::test_flags, .value = flags}});
  };
  w.step();
  EXPECT_TRUE(w.has(faults::imu_test_failed, kImuModule));
  const Verdict v = w.ask(Kind::gnc, {2});
  EXPECT_EQ(v.reason, reasons::imu_test_failed);
  EXPECT_EQ(v.subject, kImuModule);
  EXPECT_EQ(w.mode(), Mode::standby);
  flags = 0;
  w.step();
  EXPECT_FALSE(w.has(faults::imu_test_failed, kImuModule));
  EXPECT_EQ(w.why(Kind::gnc, {2}), Reason::none);
}

// In the air it is only said: the other way down is by no IMU at all.
TEST(TalarisFaults, ASelfTestThatFailsInTheAirDoesNotEndTheFlight) {
  World w;
  ASSERT_TRUE(w.fly(Program::hop));
  w.distort = [](std::vector<TalarisSample>& samples) {
    samples.push_back({.time_ns = samples.back().time_ns,
                       .reading = ImuStatus{.kind = ImuStatus::Kind::test_flags, .value = 1}});
  };
  w.run(1);
  EXPECT_TRUE(w.has(faults::imu_test_failed, kImuModule));
  EXPECT_TRUE(w.airborne());
  EXPECT_EQ(w.vehicle_.flight().faults, 0u);
}

TEST(TalarisFaults, AltimeterErrorsAreReportedAndMakeItLostWhenNothingElseComes) {
  World w;
  ASSERT_TRUE(w.start());
  w.distort = [](std::vector<TalarisSample>& samples) {
    for (TalarisSample& s : samples) {
      if (auto* range = std::get_if<Range>(&s.reading)) *range = {.range_m = 0, .error = 15};
    }
  };
  w.step();
  ASSERT_NE(w.heard(events::altimeter_error), nullptr);
  EXPECT_EQ(w.heard(events::altimeter_error)->argument[0], 15);
  EXPECT_FALSE(w.has(faults::altimeter_lost, kAltimeterModule));
  w.run(1.4);
  EXPECT_TRUE(w.has(faults::altimeter_lost, kAltimeterModule));
  w.distort = nullptr;
  w.run(1);
  EXPECT_FALSE(w.has(faults::altimeter_lost, kAltimeterModule));
}

TEST(TalarisFaults, EveryFrameOfTheFastestCameraIsTaken) {
  Sensors sensors{Parameters{}};
  sensors.begin(2 * kSecond, true);
  for (int i = 0; i < 20; ++i)  // each 10 ms
    sensors.take({.time_ns = kSecond + i, .reading = Flow{.usable = true}});
  EXPECT_EQ(sensors.batch().flows.size(), 20u);
}

// The camera of a world speaks so often a frame of 200 ms.
void let_speak(World& w, const int& times) {
  w.distort = [&times](std::vector<TalarisSample>& samples) {
    const TimeNs end = samples.back().time_ns;
    for (int i = times; i-- > 0;)
      samples.push_back({end - i * 200 * kMillisecond / times, Flow{.usable = true}});
  };
}

TEST(TalarisSensors, TheAxesOfTheCameraMayBeTurned) {
  Parameters p;
  p.camera_axes = {{{1, -1}, {0, 1}}};
  Sensors sensors{p};
  sensors.begin(2 * kSecond, true);
  sensors.take({.time_ns = kSecond, .reading = Flow{.angle_rad = {0.1, 0.2}, .usable = true}});
  EXPECT_EQ(sensors.batch().flows[0].y_rad, -0.2);
  EXPECT_EQ(sensors.batch().flows[0].z_rad, 0.1);
}

// Silent, or in another rhythm than configured, in which navigation uses no frame.
TEST(TalarisFaults, ACameraThatIsSilentOrOutOfItsRhythmIsReported) {
  Parameters p = quick();
  p.navigation.camera = p.buses.has_camera = true;
  for (const int fewer : {0, 2}) {
    SCOPED_TRACE(fewer);
    World w(p);
    int times = 4;
    let_speak(w, times);
    ASSERT_TRUE(w.start());
    EXPECT_FALSE(w.has(faults::camera_lost, 0));
    times = fewer;
    w.run(0.8);
    EXPECT_FALSE(w.has(faults::camera_lost, 0));
    w.run(0.6);
    EXPECT_TRUE(w.has(faults::camera_lost, 0));
    times = 4;
    w.run(0.4);
    EXPECT_FALSE(w.has(faults::camera_lost, 0));
  }

  World never(p);
  ASSERT_TRUE(never.start());
  never.run(4.5);
  EXPECT_TRUE(never.has(faults::camera_lost, 0)) << "one that was never heard";
  World none;
  ASSERT_TRUE(none.start());
  none.run(8);
  EXPECT_FALSE(none.has(faults::camera_lost, 0)) << "there is none";
}

TEST(TalarisFaults, RangesThatCannotBeDoNotMoveNavigation) {
  World w;
  ASSERT_TRUE(w.start());
  ASSERT_TRUE(w.calibrate());
  int n = 0;
  w.distort = [&](std::vector<TalarisSample>& samples) {
    for (TalarisSample& s : samples) {
      if (auto* range = std::get_if<Range>(&s.reading)) range->range_m = 3 + (++n % 7);
    }
  };
  w.run(3);
  EXPECT_NEAR(w.out_.telemetry.position_m[0], 0.5, 0.1);
  EXPECT_GT(w.out_.telemetry.ranges_gated, 10u);
}

// The flight continues to the ground as far as possible; then it is an emergency.
struct InTheAir {
  const char* name;
  FaultId fault;
  std::uint16_t subject;
  Phase phase;  // its reaction
  double landing_m_s;
  void (*cause)(World&);
};

class TalarisAirFaults : public testing::TestWithParam<InTheAir> {};

TEST_P(TalarisAirFaults, InTheAirItComesDownFirst) {
  World w;
  ASSERT_TRUE(w.fly(Program::hop, 2, 20));
  ASSERT_TRUE(w.run_until(Phase::traverse, 10));
  w.events.clear();
  GetParam().cause(w);
  ASSERT_TRUE(w.run_until(GetParam().phase, 3));
  w.step();
  EXPECT_EQ(w.state(), State::operational);
  EXPECT_TRUE(w.airborne());
  EXPECT_TRUE(w.has(GetParam().fault, GetParam().subject)) << "reported and latched at once";
  EXPECT_NE(w.heard(EventId::contingency), nullptr);
  ASSERT_TRUE(w.run_until(State::fatal_error, 60));
  EXPECT_EQ(w.height_m, 0) << "not before it is down";
  EXPECT_LT(w.landing_m_s, GetParam().landing_m_s);
  EXPECT_TRUE(w.shut());
  EXPECT_TRUE(w.has(GetParam().fault, GetParam().subject));
  EXPECT_EQ(w.last(lss::Phase::failed)->kind, 310);
}
INSTANTIATE_TEST_SUITE_P(
    Each, TalarisAirFaults,
    testing::Values(
        InTheAir{"imu_silent", faults::navigation_lost, kImuModule, Phase::parachute, 2.5,
                 [](World& w) { w.imu_alive = false; }},
        InTheAir{"imu_stuck", faults::navigation_lost, kImuModule, Phase::parachute, 2.5,
                 [](World& w) {
                   w.distort = [](std::vector<TalarisSample>& samples) {
                     for (TalarisSample& s : samples) {
                       if (auto* imu = std::get_if<ImuPacket>(&s.reading)) {
                         imu->rate_rad_s = {};
                         imu->force_m_s2 = {9.8, 0, 0};
                       }
                     }
                   };
                 }},
        InTheAir{"altimeter_silent", faults::altitude_lost, kAltimeterModule, Phase::escape, 1.2,
                 [](World& w) { w.altimeter_alive = false; }},
        InTheAir{"altimeter_errors", faults::altitude_lost, kAltimeterModule, Phase::escape, 1.2,
                 [](World& w) {
                   w.distort = [](std::vector<TalarisSample>& samples) {
                     for (TalarisSample& s : samples) {
                       if (auto* range = std::get_if<Range>(&s.reading)) *range = {0, 15};
                     }
                   };
                 }},
        InTheAir{"valves_silent", FaultId::module_silent, kValveModule, Phase::parachute, 1.5,
                 [](World& w) {
                   w.valves_alive = false;
                   w.node(kValveNode).state = canopen::NodeState::lost;
                 }},
        InTheAir{"pressure_gone", faults::pressure_lost, kValveModule, Phase::parachute, 1.5,
                 [](World& w) {
                   w.regulated_kPa = 0;
                   w.gas_works = false;
                 }},
        InTheAir{"gas_low", faults::gas_low, kValveModule, Phase::escape, 1.0,
                 [](World& w) { w.tank_kPa = 5500; }},
        InTheAir{"overruns", FaultId::frame_overrun, 0, Phase::escape, 1.0,
                 [](World& w) { w.in_.overrun_limit = true; }}),
    [](const auto& test) { return std::string(test.param.name); });

TEST(TalarisAirFault, AShortSilenceOfTheImuIsBridgedAndTheHopGoesOn) {
  World w;
  ASSERT_TRUE(w.fly(Program::hop, 2, 10));
  w.imu_alive = false;
  w.step();
  w.imu_alive = true;
  ASSERT_TRUE(w.run_until(Mode::standby, 60));
  EXPECT_EQ(w.state(), State::operational);
  EXPECT_NEAR(w.along_m, 10, 1.5);
}

// Nothing is left that could carry it.
TEST(TalarisAirFault, WithTheBusGoneEverythingIsStopped) {
  World w;
  ASSERT_TRUE(w.fly(Program::hop));
  w.valves_alive = w.fans_alive = false;
  w.in_.bus.can.open = false;
  ASSERT_TRUE(w.run_until(State::fatal_error, 2));
  EXPECT_TRUE(w.shut());
  EXPECT_TRUE(w.has(FaultId::module_silent, kValveModule));
}

// A command that cannot be right: in the air the fans go on as they were, on the ground all stops.
TEST(TalarisAirFault, AtTheGateValvesAreShutAndTheFansGoOn) {
  World w;
  ASSERT_TRUE(w.fly(Program::hop));
  const TalarisOrders before = w.orders();
  TalarisOrders bad = before;
  bad.pulse[2] = {0, 20 * kMillisecond};
  bad.fan_us.fill(1000);
  const TalarisOrders out = w.vehicle_.gate(bad, w.supervisor_, w.time_ns_);
  EXPECT_EQ(out.fan_us, before.fan_us);
  for (const ValvePulse& pulse : out.pulse) EXPECT_EQ(pulse, ValvePulse{});
  EXPECT_FALSE(out.all_stop);
  EXPECT_TRUE(w.has(FaultId::gate_closed));
  EXPECT_EQ(w.state(), State::operational);
  EXPECT_EQ(w.supervisor_.state().safe_commands, 1u);
  ASSERT_TRUE(w.run_until(State::fatal_error, 60));
  EXPECT_EQ(w.height_m, 0) << "after it has landed";
  EXPECT_LT(w.landing_m_s, 0.6);
}

// What it would fly on with is not known.
TEST(TalarisAirFault, DamagedMemoryBeginsALanding) {
  for (const bool of_the_command : {false, true}) {
    World w;
    ASSERT_TRUE(w.fly(Program::hop, 2, 30));
    if (of_the_command)  // no command has this number
      const_cast<SupervisorState&>(w.supervisor_.state()).active.kind = 0x4000;
    w.in_.memory = MemoryCheck::lost;
    w.step();
    w.in_.memory = MemoryCheck::good;
    EXPECT_TRUE(w.has(FaultId::memory_lost));
    EXPECT_TRUE(w.airborne());
    if (!of_the_command) {
      ASSERT_NE(w.last(lss::Phase::failed), nullptr);
      EXPECT_EQ(w.last(lss::Phase::failed)->verdict.reason, Reason::emergency);
    }
    ASSERT_TRUE(w.run_until(State::fatal_error, 60));
    EXPECT_EQ(w.height_m, 0);
    EXPECT_LT(w.along_m, 25) << "not the rest of the hop";
    EXPECT_LT(w.landing_m_s, 0.6);
  }
}

TEST(TalarisAirFault, WhyTheLastHopWasCutShortIsForgottenWhenTheNextBegins) {
  World w;
  ASSERT_TRUE(w.start() && w.arm() && w.calibrate());
  w.supervisor_.latch(faults::corridor_left);
  w.supervisor_.latch(faults::hop_shortened, kValveModule);
  ASSERT_EQ(w.why(Kind::plan, {double(Program::hop), 2, 5, 0, 0}), Reason::none);
  w.run(1);
  EXPECT_TRUE(w.has(faults::corridor_left));
  EXPECT_TRUE(w.has(faults::hop_shortened, kValveModule));
  ASSERT_EQ(w.why(Kind::gnc, {2}), Reason::none);
  EXPECT_EQ(w.mode(), Mode::execute);
  EXPECT_FALSE(w.has(faults::corridor_left));
  EXPECT_FALSE(w.has(faults::hop_shortened, kValveModule));
}

TEST(TalarisFaults, AnotherMasterOnTheBusIsAWarningUntilItHasBeenSilentFor10Seconds) {
  World w;
  w.run(1);
  ++w.in_.bus.can.status.counters.master.other_masters;
  w.run(0.4);
  EXPECT_TRUE(w.has(FaultId::other_master));
  EXPECT_EQ(w.state(), State::idle);
  EXPECT_EQ(w.out_.telemetry.bus_frames_dropped, 1u);
  w.run(11);
  EXPECT_FALSE(w.has(FaultId::other_master));
}

// ---- solving

TEST(TalarisSolve, ANodeThatStaysAwayIsResetAndComesBack) {
  World w;
  ASSERT_TRUE(w.start());
  w.node(kValveNode).state = canopen::NodeState::lost;
  ASSERT_TRUE(w.run_until(State::fatal_error, 1));
  const std::uint32_t serial = w.orders().node_reset_serial;
  w.send(lss::CommandKind::solve);
  ASSERT_TRUE(w.run_until([&] { return w.orders().node_reset_serial != serial; }, 20));
  EXPECT_EQ(w.orders().reset_nodes, 1u << kValveNode);
  w.node(kValveNode).state = canopen::NodeState::operational;
  ASSERT_TRUE(w.run_until(State::idle, 5));
  EXPECT_EQ(w.supervisor_.state().fault_count, 0u);
}

TEST(TalarisSolve, AfterALostImuNavigationBeginsAgain) {
  World w;
  ASSERT_TRUE(w.fly(Program::hop));
  w.imu_alive = false;
  ASSERT_TRUE(w.run_until(State::fatal_error, 60));
  w.imu_alive = true;
  w.events.clear();
  w.send(lss::CommandKind::solve);
  ASSERT_TRUE(w.run_until(State::idle, 30));
  ASSERT_NE(w.heard(EventId::strategy_begun), nullptr);
  EXPECT_EQ(w.supervisor_.state().fault_count, 0u);
  EXPECT_EQ(w.out_.telemetry.calibrated_share, 0);
}

TEST(TalarisSolve, ResetOfAModuleReachesItsNode) {
  World w;
  w.run(1);
  const std::uint32_t serial = w.orders().node_reset_serial;
  ASSERT_EQ(w.why(lss::CommandKind::reset, {kFanModule}), Reason::none);
  EXPECT_EQ(w.orders().node_reset_serial, serial + 1);
  EXPECT_EQ(w.orders().reset_nodes, 1u << kFanNode);
  ASSERT_EQ(w.why(lss::CommandKind::reset, {0}), Reason::none);
  EXPECT_EQ(w.orders().reset_nodes, 0b111);
}

TEST(TalarisSolve, AFanNodeThatIsResetHasToStartItsFansAgain) {
  World w;
  ASSERT_TRUE(w.start());
  ASSERT_TRUE(w.arm());
  w.send(lss::CommandKind::stop);
  ASSERT_TRUE(w.run_until(State::idle, 1));
  EXPECT_TRUE(w.out_.telemetry.fans[0].armed);
  ASSERT_EQ(w.why(lss::CommandKind::reset, {kValveModule}), Reason::none);
  EXPECT_TRUE(w.out_.telemetry.fans[0].armed);
  ASSERT_EQ(w.why(lss::CommandKind::reset, {kFanModule}), Reason::none);
  EXPECT_FALSE(w.out_.telemetry.fans[0].armed);
  ++w.node(kValveNode).boots;
  ++w.node(kFanNode).boots;
  ASSERT_TRUE(w.start());
  EXPECT_EQ(w.why(Kind::edf_throttle, {15, 0.1}), reasons::fans_not_armed);
}

// The frame wakes a little after its T_k and knows of heartbeats since.
TEST(TalarisTelemetry, WhatWasHeardAfterTheBoundaryIsNew) {
  World w;
  ASSERT_TRUE(w.start());
  w.distort = [&](std::vector<TalarisSample>&) {
    w.node(kLoadCellNode).state = canopen::NodeState::lost;  // its time stays as it is set here
    w.node(kLoadCellNode).heartbeat_ns = w.time_ns_ + 2 * kMillisecond;
  };
  w.step();
  EXPECT_EQ(w.out_.telemetry.modules[kLoadCellModule - 1].age_ms, 0u);
  EXPECT_EQ(w.supervisor_.state().age_ms[kLoadCellModule - 1], 0);
}

}  // namespace
}  // namespace lss::talaris
