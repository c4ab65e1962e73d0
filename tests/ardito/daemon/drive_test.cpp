// What D.I.A.N.A. Ardito does when it may not drive, shall drive by itself, slips, or has drives
// that drop out; in an ideal world.

#include <gtest/gtest.h>

#include <cmath>

#include "idl/angles.h"
#include "idl/ardito/codes.h"
#include "world.h"

namespace lss::ardito {
namespace {

template <class M>
void alter_all(std::vector<Reading>& readings, const std::function<void(M&)>& change) {
  for (Reading& r : readings) {
    if (auto* m = std::get_if<M>(&r)) change(*m);
  }
}

// ---- the limit of the heading

TEST(ArditoHeading, BeyondTheLimitIsRefusedWithBothNumbersAndTheRoverDrivesOnAsBefore) {
  Parameters p;
  p.mobility.max_sigma_rad = 3 * kDegree;
  World w(p);
  ASSERT_TRUE(w.start());
  for (const double sign : {-1.0, 1.0}) {
    const Verdict v = w.ask(CommandKind::drive, {0.3, sign * 3.01 * kDegree, 1, 0});
    EXPECT_EQ(v.reason, reasons::over_heading);
    EXPECT_DOUBLE_EQ(v.measured, 3.01 * kDegree);
    EXPECT_DOUBLE_EQ(v.limit, 3 * kDegree);
    EXPECT_EQ(w.mode(), Mode::stopped);
    EXPECT_EQ(w.ask(CommandKind::drive, {0.3, sign * 3 * kDegree, 1, 0}).reason, Reason::none);
    ASSERT_TRUE(w.run_until(Mode::running, 20));
    EXPECT_DOUBLE_EQ(w.out_.telemetry.heading_rad, sign * 3 * kDegree);
    EXPECT_EQ(w.ask(CommandKind::drive, {0.3, sign * 4 * kDegree, 1, 0}).reason,
              reasons::over_heading);
    w.run(1);
    EXPECT_DOUBLE_EQ(w.out_.telemetry.heading_rad, sign * 3 * kDegree);
    w.send(CommandKind::halt);
    ASSERT_TRUE(w.run_until(Mode::stopped, 20));
  }
}

TEST(ArditoHeading, TheLargestOfTheCommandIsWithinTheLimitAsDelivered) {
  World w;
  ASSERT_TRUE(w.start());
  EXPECT_TRUE(w.drive_at(0.3, kMaxHeading_rad));
}

// ---- the cap of the configuration

TEST(ArditoCap, FasterThanTheCapIsRefusedAtTheStartAndUnderWayWithBothNumbers) {
  World w;
  w.run(0.5);
  const auto refused = [&](auto kind, std::initializer_list<double> parameters, double measured) {
    const Verdict v = w.ask(kind, parameters);
    EXPECT_EQ(v.reason, reasons::over_cap);
    EXPECT_DOUBLE_EQ(v.measured, measured);
    EXPECT_DOUBLE_EQ(v.limit, 0.5);
  };
  refused(lss::CommandKind::start, {1, 0.6}, 0.6);  // as `lss-cli drive 0.6` from Idle
  refused(lss::CommandKind::start, {1}, 1.0);
  EXPECT_EQ(w.state(), State::idle);
  w.acks.clear();
  ASSERT_TRUE(w.start(0));
  refused(CommandKind::drive, {0.6, 0, 1, 0}, 0.6);
  refused(CommandKind::drive, {-0.51, 0, 1, 0}, 0.51);
  refused(CommandKind::park, {0.6}, 0.6);
  EXPECT_TRUE(w.drive_at(0.5));
  EXPECT_DOUBLE_EQ(w.out_.telemetry.cap_m_s, 0.5);
}

TEST(ArditoCap, ALimitAboveTheCapIsCutToIt) {
  Parameters p;
  p.mobility.top_speed_m_s = 0.8;
  World w(p);
  w.run(0.5);
  EXPECT_EQ(w.why(lss::CommandKind::start, {1, 0.7}), Reason::none);
  w.run(10);
  EXPECT_DOUBLE_EQ(w.out_.telemetry.limit_m_s, 0.8);
  EXPECT_TRUE(w.drive_at(0.7));
}

// ---- autonomous driving: the lamp flashes for 5 s at its activation (part III)

TEST(ArditoAutonomy, TheLampFlashesForFiveSecondsBeforeItDrivesByItself) {
  World w;
  ASSERT_TRUE(w.start());
  w.run(20);  // long after the start
  w.send(CommandKind::drive, {0.3, 0, 1, 1});
  w.step();
  EXPECT_EQ(w.last(Phase::rejected), nullptr);
  EXPECT_NEAR(w.out_.telemetry.autonomy_wait_s, 5, 0.2);
  const TimeNs from = w.time_ns_;
  int changes = 0;
  for (bool lamp = w.out_.command.beacon; w.time_ns_ - from < 5 * kSecond - w.kPeriod;) {
    w.step();
    changes += w.out_.command.beacon != lamp ? 1 : 0;
    lamp = w.out_.command.beacon;
    for (std::size_t i = 0; i < kWheels; ++i) ASSERT_EQ(w.wheel_rpm(i), 0);
    ASSERT_EQ(w.mode(), Mode::stopped);
  }
  EXPECT_GE(changes, 8);
  ASSERT_TRUE(w.run_until([&] { return w.wheel_rpm(0) != 0; }, 2));
  w.run(1);
  EXPECT_TRUE(w.out_.command.beacon) << "steady again";
  // under way another order of the autonomy is executed at once
  w.send(CommandKind::drive, {0.2, 0, 1, 1});
  for (int n = 0; n < 20; ++n) {
    w.step();
    EXPECT_NE(w.wheel_rpm(0), 0);
  }
}

TEST(ArditoAutonomy, OfARoverThatIsDrivenByHandItStopsFlashesAndGoesOn) {
  World w;
  ASSERT_TRUE(w.start_and_drive(0.4));
  w.run(2);
  w.send(CommandKind::drive, {0.3, 0, 1, 1});
  ASSERT_TRUE(w.run_until([&] { return w.wheel_rpm(0) == 0; }, 3));
  const TimeNs stood = w.time_ns_;
  ASSERT_TRUE(w.run_until(Mode::running, 10));
  EXPECT_GE(w.time_ns_ - stood, 3 * kSecond);
  // by hand and by itself again: it waits again
  ASSERT_TRUE(w.drive_at(0.3));
  w.run(1);
  w.send(CommandKind::drive, {0.3, 0, 1, 1});
  w.run(3);
  EXPECT_EQ(w.wheel_rpm(0), 0);
}

// ---- slip

// The motors push, and the IMU reports something else.
void push(World& w, void (*imu)(Imu&)) {
  w.distort = [imu](std::vector<Reading>& readings) {
    alter_all<Imu>(readings, imu);
    alter_all<WheelMotion>(readings, [](WheelMotion& m) {
      m.current_permille = std::copysign(m.motor_rpm == 0 ? 0 : 600, m.motor_rpm);
    });
  };
}
void block(World& w) {
  push(w, [](Imu& m) { m.Vtan_mm_s = 1; });
}
// Half of the wheels' speed is lost.
void slip(World& w) {
  push(w, [](Imu& m) { m.Vtan_mm_s = m.Vtan_mm_s / 2; });
}

TEST(ArditoSlip, ABlockedRoverStopsWithinThreeSecondsSaysWhyAndStopsCounting) {
  World w;
  ASSERT_TRUE(w.start_and_drive(0.3));
  w.run(4);
  const double before_m = w.out_.telemetry.distance_m;
  block(w);
  const TimeNs from = w.time_ns_;
  ASSERT_TRUE(w.run_until(Mode::stopped, 3));
  EXPECT_LE(w.time_ns_ - from, 3 * kSecond);
  EXPECT_EQ(w.state(), State::operational) << "a safe stop, no emergency";
  EXPECT_TRUE(w.has(faults::rover_stuck));
  EXPECT_FALSE(w.has(faults::imu_lost, kImuNode));
  ASSERT_NE(w.heard(events::stopped_stuck), nullptr);
  EXPECT_NEAR(w.heard(events::stopped_stuck)->argument[0], 0.3, 0.02);
  EXPECT_NEAR(w.heard(events::stopped_stuck)->argument[1], 0, 0.01);
  ASSERT_NE(w.heard(events::slip_begun), nullptr);
  EXPECT_EQ(w.last(Phase::failed)->verdict.reason, reasons::stuck);
  EXPECT_NEAR(w.out_.telemetry.distance_m, before_m, 0.1);
  w.run(2);
  EXPECT_NE(w.heard(events::slip_ended), nullptr);
  EXPECT_TRUE(w.has(faults::rover_stuck)) << "until it is moved again";
  w.distort = nullptr;
  ASSERT_TRUE(w.drive_at(-0.3));
  EXPECT_FALSE(w.has(faults::rover_stuck));
}

TEST(ArditoSlip, AnImuThatIsWrongIsNotTakenForSlip) {
  World w;
  ASSERT_TRUE(w.start_and_drive(0.3));
  w.run(2);
  w.distort = [](std::vector<Reading>& readings) {
    alter_all<Imu>(readings, [](Imu& m) { m.Vtan_mm_s = 1; });
  };
  ASSERT_TRUE(w.run_until([&] { return w.has(faults::imu_lost, kImuNode); }, 4));
  EXPECT_FALSE(w.has(faults::rover_stuck));
  EXPECT_EQ(w.mode(), Mode::running);
}

TEST(ArditoSlip, AWheelThatDigsItselfInStopsTheRoverAndTheWayBackIsFree) {
  World w;
  ASSERT_TRUE(w.start_and_drive(0.3));
  w.run(3);
  w.distort = [](std::vector<Reading>& readings) {
    alter_all<Rocker>(readings, [](Rocker& m) { m.rho2_rad -= 0.18; });
    alter_all<Imu>(readings, [](Imu& m) { m.Vtan_mm_s = 0.85 * m.Vtan_mm_s; });
    alter_all<WheelMotion>(readings, [](WheelMotion& m) {
      if (m.wheel == 3) m.current_permille += m.motor_rpm > 0 ? 700 : -700;
    });
  };
  ASSERT_TRUE(w.run_until([&] { return w.has(faults::wheel_embedded, 4); }, 3));
  ASSERT_TRUE(w.run_until(Mode::stopped, 3));
  EXPECT_EQ(w.state(), State::operational) << "a safe stop, no emergency";
  ASSERT_NE(w.heard(events::stopped_embedded), nullptr);
  const EventRecord& told = *w.heard(events::stopped_embedded);
  EXPECT_GT(told.argument[0], 0.06);
  EXPECT_EQ(told.argument[1], 0.06);
  EXPECT_GT(told.argument[2], told.argument[3]);
  EXPECT_GT(told.argument[3], 1.25);
  EXPECT_LT(told.argument[3], 1.8);
  EXPECT_EQ(w.last(Phase::failed)->verdict.reason, reasons::wheel_embedded);
  w.run(2);
  EXPECT_TRUE(w.has(faults::wheel_embedded, 4)) << "until it is moved again";
  for (std::size_t i = 0; i < kWheels; ++i)
    EXPECT_EQ(w.out_.telemetry.sunk_m[i] > 0.06, i == 3) << i;
  ASSERT_TRUE(w.drive_at(-0.3));
  w.run(3);
  EXPECT_EQ(w.mode(), Mode::running);
  EXPECT_FALSE(w.has(faults::wheel_embedded, 4));
}

TEST(ArditoSlip, MoreThanAllowedSlowsTheRoverAndSaysWhatWasMeasuredAndAllowed) {
  World w;
  ASSERT_TRUE(w.start_and_drive(0.4));
  w.run(4);
  EXPECT_EQ(w.out_.telemetry.speed_share, 1);
  EXPECT_NEAR(w.out_.telemetry.slip_share, 0, 0.03);
  slip(w);
  w.run(4);
  EXPECT_NEAR(w.out_.telemetry.speed_share, 0.5, 1e-9);
  EXPECT_NEAR(w.out_.telemetry.slip_share, 0.5, 0.03);
  EXPECT_NEAR(w.out_.telemetry.speed_m_s, 0.4, 1e-9) << "as commanded";
  EXPECT_NEAR(w.out_.telemetry.measured_m_s, 0.2, 0.02);
  ASSERT_NE(w.heard(events::slip_slows), nullptr);
  EXPECT_NEAR(w.heard(events::slip_slows)->argument[0], 0.45, 0.06);
  EXPECT_EQ(w.heard(events::slip_slows)->argument[1], 0.4);
  EXPECT_EQ(w.mode(), Mode::running);
  EXPECT_FALSE(w.has(faults::rover_stuck));
  EXPECT_FALSE(w.has(faults::imu_lost, kImuNode));
  w.distort = nullptr;
  w.run(4);
  EXPECT_EQ(w.out_.telemetry.speed_share, 1);
  EXPECT_NEAR(w.out_.telemetry.measured_m_s, 0.4, 0.02);
  ASSERT_NE(w.heard(events::slip_slows_ended), nullptr);
  EXPECT_NEAR(w.heard(events::slip_slows_ended)->argument[1], 0.5, 0.03);
}

TEST(ArditoSlip, ASlowedRoverStopsWithItsLastHeartbeatAsSoonAsAnother) {
  TimeNs took_ns[2] = {};
  for (const bool slowed : {false, true}) {
    World w;
    ASSERT_TRUE(w.start_and_drive(0.4));
    if (slowed) slip(w);
    w.run(4);
    ASSERT_EQ(w.out_.telemetry.speed_share < 1, slowed);
    const TimeNs from = w.time_ns_;
    w.heartbeat_ = false;
    ASSERT_TRUE(w.run_until(State::idle, 10));
    took_ns[slowed ? 1 : 0] = w.time_ns_ - from;
  }
  EXPECT_LE(took_ns[1], took_ns[0]);
}

// ---- drives that drop out

TEST(ArditoDropouts, EachIsAnEventAndFourInTenSecondsAreAFault) {
  World w;
  ASSERT_TRUE(w.start_and_drive(0.3));
  const auto drop = [&] { ++w.in_.bus.status.link[7].dropouts; };
  for (int n = 1; n <= 3; ++n) {
    w.events.clear();
    drop();
    w.run(1);
    ASSERT_NE(w.heard(EventId::drive_dropped_out), nullptr);
    EXPECT_EQ(w.heard(EventId::drive_dropped_out)->subject, 8);
    EXPECT_EQ(w.heard(EventId::drive_dropped_out)->argument[0], n);
  }
  EXPECT_EQ(w.state(), State::operational);
  drop();
  w.run(0.2);
  EXPECT_EQ(w.state(), State::fatal_error);
  EXPECT_TRUE(w.has(FaultId::drive_drops_out, 8));
  w.send(lss::CommandKind::solve);
  EXPECT_TRUE(w.run_until(State::idle, 30));
}

TEST(ArditoDropouts, RareOnesAreNoFault) {
  World w;
  ASSERT_TRUE(w.start_and_drive(0.3));
  for (int n = 0; n < 8; ++n) {
    ++w.in_.bus.status.link[0].dropouts;
    w.run(3.5);
  }
  EXPECT_EQ(w.state(), State::operational);
}

// ---- motors

TEST(ArditoWheels, SeizedMotorsAreNotForgottenByErrorSolving) {
  World w;
  ASSERT_TRUE(w.start_and_drive(0.3));
  w.run(2);
  const auto seize = [&](bool on) {
    w.distort = [on](std::vector<Reading>& readings) {
      if (!on) return;
      alter_all<WheelMotion>(readings, [](WheelMotion& m) {
        if (m.wheel < 3) m.motor_rpm = 0;
      });
      alter_all<WheelSpeeds>(readings, [](WheelSpeeds& m) {
        if (m.wheel < 3) m.hall_rpm = m.reduction_rpm = 0;
      });
    };
  };
  seize(true);
  ASSERT_TRUE(w.run_until([&] { return w.state() == State::fatal_error; }, 6));
  w.send(lss::CommandKind::solve);
  ASSERT_TRUE(w.run_until(State::idle, 60));
  w.run(5);
  for (std::uint16_t wheel = 1; wheel <= 3; ++wheel) {
    EXPECT_TRUE(w.has(faults::wheel_unproven, wheel)) << wheel;
    EXPECT_TRUE(w.out_.telemetry.wheels[wheel - 1u].unproven);
  }
  EXPECT_FALSE(w.has(faults::wheel_unproven, 4));
  // one was checked; the others prove themselves under way
  w.in_.bus.status.link[0].node.boots = 0;
  EXPECT_EQ(w.why(lss::CommandKind::reset, {1}), Reason::none);
  ++w.node(0).boots;
  w.run(2);
  EXPECT_FALSE(w.has(faults::wheel_unproven, 1));
  EXPECT_TRUE(w.has(faults::wheel_unproven, 2));
  seize(false);
  w.acks.clear();
  ASSERT_TRUE(w.start());
  EXPECT_TRUE(w.has(faults::wheel_unproven, 2)) << "standing proves nothing";
  ASSERT_TRUE(w.drive_at(0.3));
  w.run(5);
  EXPECT_FALSE(w.has(faults::wheel_unproven, 2));
  EXPECT_FALSE(w.has(faults::wheel_unproven, 3));
}

TEST(ArditoWheels, AWarmMotorIsReportedAndAHotOneTakenOut) {
  World w;
  ASSERT_TRUE(w.start_and_drive(0.3));
  double degC = 95;
  w.distort = [&](std::vector<Reading>& readings) {
    alter_all<WheelHealth>(readings, [&](WheelHealth& m) {
      if (m.wheel == 1) m.temperature_degC = degC;
    });
  };
  w.run(3);
  EXPECT_TRUE(w.has(FaultId::temperature_warning, 2));
  EXPECT_TRUE(w.out_.telemetry.wheels[1].hot);
  EXPECT_TRUE(w.out_.command.wheel[1].enabled);
  degC = 80;
  w.run(1);
  EXPECT_FALSE(w.has(FaultId::temperature_warning, 2));
  degC = 107;
  ASSERT_TRUE(w.run_until([&] { return w.has(faults::wheel_motor, 2); }, 2));
  EXPECT_FALSE(w.out_.command.wheel[1].enabled);
  EXPECT_EQ(w.out_.command.clutches >> 1 & 1, 0);
}

TEST(ArditoWheels, NothingIsShownBeforeItWasMeasured) {
  World w;
  w.distort = [](std::vector<Reading>& readings) { readings.clear(); };
  w.step();
  const lss_ArditoTelemetry& t = w.out_.telemetry;
  for (const double value :
       {t.wheels[0].temperature_degC, t.wheels[5].voltage_V, t.wheels[2].motor_rad_s,
        t.wheels[2].current_A, t.steering[3].reduction_rad, t.beta_rad, t.rho_rad[1], t.sunk_m[3],
        t.imu_speed_m_s})
    EXPECT_TRUE(std::isnan(value));
  w.distort = nullptr;
  w.run(0.2);
  EXPECT_EQ(t.wheels[0].temperature_degC, 25);
  for (const double sunk_m : t.sunk_m) EXPECT_NEAR(sunk_m, 0, 0.002);
}

// Nothing but the friction of the gears would hold a rover that still rolls.
TEST(Drive, NeitherAnotherResetNorAStartEndsTheBraking) {
  for (const bool starts : {false, true}) {
    World w;
    ASSERT_TRUE(w.start_and_drive(0.3));
    w.acks.clear();
    const double rolls_rpm = w.wheel_rpm(0);
    w.send(lss::CommandKind::reset, {-1});
    w.step();
    ASSERT_EQ(w.state(), State::idle);
    w.rpm.fill(rolls_rpm);
    starts ? w.send(lss::CommandKind::start, {0}) : w.send(lss::CommandKind::reset, {-1});
    for (int i = 0; i < 5; ++i) {
      w.step();
      EXPECT_EQ(w.state(), starts ? State::operational : State::idle);
      EXPECT_TRUE(w.all_stopped());
      w.rpm.fill(rolls_rpm);
    }
    w.rpm.fill(0);
    if (starts) {
      ASSERT_TRUE(w.run_until([&] { return w.mode() == Mode::stopped; }, 10));
    } else {
      w.run(2);
      EXPECT_FALSE(w.out_.command.quick_stop);
      ASSERT_TRUE(w.start());
    }
    EXPECT_FALSE(w.out_.command.quick_stop);
    w.run(0.5);
    EXPECT_TRUE(w.drive_at(0.3));
  }
}

// [Oper-2] The wheels are braked with power; once they are at rest motors are off.
TEST(Drive, AResetOfTheControllerUnderWayEndsWithMotorsOff) {
  World w;
  ASSERT_TRUE(w.start_and_drive(0.3));
  const double rolls_rpm = w.wheel_rpm(0);
  ASSERT_GT(rolls_rpm, 0);
  w.send(lss::CommandKind::reset, {-1});
  w.step();
  ASSERT_EQ(w.state(), State::idle);
  for (int i = 0; i < 5; ++i) {
    w.rpm.fill(rolls_rpm);  // it brakes
    w.step();
    EXPECT_TRUE(w.all_stopped());
  }
  w.rpm.fill(0);
  w.run(0.8);
  EXPECT_TRUE(w.all_stopped());
  w.run(0.5);
  EXPECT_EQ(w.state(), State::idle);
  EXPECT_FALSE(w.out_.command.quick_stop);
  for (std::size_t i = 0; i < kWheels + kSteered; ++i)
    EXPECT_EQ(w.drive(i), canopen::DriveState::switch_on_disabled) << i;
  w.acks.clear();
  EXPECT_TRUE(w.start_and_drive(0.3));
}

}  // namespace
}  // namespace lss::ardito
