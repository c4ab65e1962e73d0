// The cycle of D.I.A.N.A. Ardito from commands to orders, in an ideal world.

#include <gtest/gtest.h>

#include <numbers>

#include "idl/angles.h"
#include "idl/ardito/codes.h"
#include "world.h"

namespace lss::ardito {
namespace {

TEST(ArditoCycle, SafeOrdersBeforeAnything) {
  World w;
  w.run(1);
  EXPECT_EQ(w.state(), State::idle);
  for (const WheelOrder& wheel : w.out_.command.wheel) EXPECT_FALSE(wheel.enabled);
  for (const SteeringOrder& steering : w.out_.command.steering) EXPECT_FALSE(steering.enabled);
  EXPECT_FALSE(w.out_.command.beacon);
  EXPECT_TRUE(w.out_.command.standing);
  EXPECT_EQ(w.out_.command.next_frame_ns, w.time_ns_ + World::kPeriod);
}

// Ardito thesis part III: the lamp runs for 5 s before any operation.
TEST(ArditoCycle, TheBeaconRunsFiveSecondsBeforeTheMotorsGoOn) {
  World w;
  w.run(0.5);
  w.send(lss::CommandKind::start, {0});
  w.step();
  EXPECT_EQ(w.mode(), Mode::warning);
  EXPECT_TRUE(w.out_.command.beacon);
  const TimeNs from = w.time_ns_;
  ASSERT_TRUE(w.run_until([&] { return w.out_.command.wheel[0].enabled; }, 10));
  EXPECT_GE(w.time_ns_ - from, 5 * kSecond);
  EXPECT_LE(w.time_ns_ - from, 5 * kSecond + 2 * World::kPeriod);
  ASSERT_TRUE(w.run_until([&] { return w.last(Phase::completed) != nullptr; }, 2));
  EXPECT_EQ(w.mode(), Mode::stopped);
}

TEST(ArditoCycle, DrivesStraightAtTheSpeedAskedFor) {
  World w;
  ASSERT_TRUE(w.start_and_drive(0.3));
  w.run(3);
  EXPECT_NEAR(w.out_.telemetry.measured_m_s, 0.3, 0.01);
  const double distance = w.out_.telemetry.distance_m;
  w.run(10);
  EXPECT_NEAR(w.out_.telemetry.distance_m - distance, 3.0, 0.1);
  EXPECT_NEAR(w.out_.telemetry.y_m, 0, 0.05);
  w.send(lss::CommandKind::stop);
  ASSERT_TRUE(w.run_until([&] { return w.state() == State::idle; }, 10));
  w.run(0.5);
  EXPECT_EQ(w.last(Phase::completed)->kind, 2);
  EXPECT_FALSE(w.out_.command.beacon);
  EXPECT_FALSE(w.out_.command.wheel[3].enabled);
}

TEST(ArditoCycle, SteersStandingBeforeItDrivesAnArc) {
  World w;
  ASSERT_TRUE(w.start());
  w.send(CommandKind::drive, {0.3, 5 * kDegree, 1, 0});
  ASSERT_TRUE(w.run_until(Mode::steering, 3));
  for (std::size_t i = 0; i < kWheels; ++i) EXPECT_EQ(w.wheel_rpm(i), 0);
  ASSERT_TRUE(w.run_until(Mode::running, 20));
  w.run(3);
  // To the right: front wheels turn right (negative), rear ones left; outer wheels are faster.
  EXPECT_LT(w.out_.command.steering[0].position_rad, 0);
  EXPECT_GT(w.out_.command.steering[2].position_rad, 0);
  EXPECT_GT(w.wheel_rpm(0), w.wheel_rpm(1));
  EXPECT_GT(w.out_.telemetry.yaw_rad, 0);
}

TEST(ArditoCycle, ParkingTurnsOnTheSpot) {
  World w;
  ASSERT_TRUE(w.start());
  w.send(CommandKind::park, {0.5});
  ASSERT_TRUE(w.run_until(Mode::parking, 20));
  w.run(3);
  // (-57.43, +57.43, +56.33, -56.33) deg, as far as 2 deg count as steered.
  EXPECT_NEAR(w.out_.command.steering[0].position_rad / kDegree, -57.43, 2);
  EXPECT_NEAR(w.out_.command.steering[1].position_rad / kDegree, 57.43, 2);
  EXPECT_GT(w.wheel_rpm(0), 0);
  EXPECT_LT(w.wheel_rpm(1), 0);
  EXPECT_NEAR(w.out_.telemetry.distance_m, 0, 1e-9);
  w.send(CommandKind::halt);
  ASSERT_TRUE(w.run_until(Mode::stopped, 20));
  EXPECT_EQ(w.state(), State::operational);
}

TEST(ArditoCycle, FasterThanTheLimitIsRefusedWithBothNumbers) {
  Parameters p;
  p.mobility.top_speed_m_s = 1;
  World w(p);
  ASSERT_TRUE(w.start(0));
  w.send(CommandKind::drive, {0.6, 0, 1, 0});
  w.step();
  ASSERT_NE(w.last(Phase::rejected), nullptr);
  EXPECT_EQ(w.last(Phase::rejected)->verdict.reason, reasons::over_limit);
  EXPECT_DOUBLE_EQ(w.last(Phase::rejected)->verdict.measured, 0.6);
  EXPECT_DOUBLE_EQ(w.last(Phase::rejected)->verdict.limit, 0.5);

  Parameters urc;
  urc.mobility.top_speed_m_s = 1;
  World fast(urc);
  ASSERT_TRUE(fast.start(1));
  EXPECT_TRUE(fast.drive_at(0.9));
}

TEST(ArditoCycle, NoWheelEverTurnsFasterThanTheLimitAllows) {
  World w;
  ASSERT_TRUE(w.start(0));
  const double fastest_rpm = 0.5 / 0.15 / (2 * std::numbers::pi) * 60 * 50;
  for (const double heading : {0.0, 3 * kDegree, -5 * kDegree, 5 * kDegree}) {
    w.send(CommandKind::drive, {0.5, heading, 1, 0});
    for (int i = 0; i < 150; ++i) {
      w.step();
      for (std::size_t wheel = 0; wheel < kWheels; ++wheel)
        EXPECT_LE(std::abs(w.wheel_rpm(wheel)), fastest_rpm * 1.2);
    }
  }
  EXPECT_EQ(w.supervisor_.state().safe_commands, 0u);
}

TEST(ArditoCycle, TheButtonCutsEverythingUntilItIsReleasedAndSolved) {
  World w;
  ASSERT_TRUE(w.start_and_drive(0.3));
  w.inputs.emergency_button = true;
  w.run(1);
  EXPECT_EQ(w.state(), State::fatal_error);
  w.send(lss::CommandKind::solve);
  w.run(40);
  EXPECT_EQ(w.state(), State::fatal_error) << "still pressed";
  w.inputs.emergency_button = false;
  w.run(1);
  EXPECT_EQ(w.state(), State::fatal_error) << "not by itself";
  w.send(lss::CommandKind::solve);
  ASSERT_TRUE(w.run_until([&] { return w.state() == State::idle; }, 30));
  EXPECT_EQ(w.supervisor_.state().fault_count, 0u);
  w.acks.clear();
  EXPECT_TRUE(w.start());
}

// Between two frames it is pressed and released.
TEST(ArditoCycle, AButtonPressedForLessThanAFrameCutsEverything) {
  World w;
  ASSERT_TRUE(w.start_and_drive(0.3));
  w.distort = [](std::vector<Reading>& readings) {
    readings.insert(readings.begin(), Inputs{.emergency_button = true, .power_good = true});
  };
  w.step();
  w.distort = nullptr;
  EXPECT_EQ(w.state(), State::fatal_error);
  EXPECT_TRUE(w.has(faults::emergency_button, kIoNode));
  EXPECT_TRUE(w.all_stopped());
  w.run(1);
  w.send(lss::CommandKind::solve);
  EXPECT_TRUE(w.run_until(State::idle, 30)) << "it is released";
}

TEST(ArditoCycle, TheButtonPressedInIdleIsNoFaultAnyMoreWhenItIsReleased) {
  World w;
  w.run(0.5);
  w.inputs.emergency_button = true;
  w.inputs.power_good = false;
  w.run(0.5);
  EXPECT_EQ(w.state(), State::idle);
  EXPECT_TRUE(w.has(faults::emergency_button, kIoNode));
  EXPECT_TRUE(w.has(faults::power_lost, kIoNode));
  EXPECT_EQ(w.why(lss::CommandKind::start, {0}), reasons::button_pressed);
  w.inputs.emergency_button = false;
  w.run(0.5);
  EXPECT_FALSE(w.has(faults::emergency_button, kIoNode));
  EXPECT_TRUE(w.has(faults::power_lost, kIoNode));
  w.inputs.power_good = true;
  w.run(0.5);
  EXPECT_FALSE(w.has(faults::power_lost, kIoNode));
  w.acks.clear();
  EXPECT_TRUE(w.start());
}

bool starts_with_wheel_5(World& w) {
  w.acks.clear();
  return w.start() && w.out_.command.wheel[4].enabled;
}

// By error solving: its drive is in fault and stays so.
void isolate_wheel_5(World& w) {
  ASSERT_TRUE(w.start());
  w.alter = [](World& x) { x.drive(4) = canopen::DriveState::fault; };
  ASSERT_TRUE(w.run_until(State::fatal_error, 1));
  EXPECT_TRUE(w.has(FaultId::drive_fault, 5));
  w.send(lss::CommandKind::solve);
  ASSERT_TRUE(w.run_until(State::idle, 60));
  ASSERT_EQ(w.supervisor_.controller().isolated, 1u << 4);
}

TEST(ArditoCycle, AWheelWhoseNodeStaysAwayIsIsolatedAndTheOtherFiveDrive) {
  World w;
  ASSERT_TRUE(w.start());
  w.node(4).state = canopen::NodeState::missing;
  w.run(0.5);
  w.send(lss::CommandKind::solve);
  ASSERT_TRUE(w.run_until([&] { return w.state() == State::idle; }, 60));
  EXPECT_EQ(w.supervisor_.controller().isolated, 1u << 4);
  w.acks.clear();
  ASSERT_TRUE(w.start_and_drive(0.3));
  w.run(2);
  EXPECT_FALSE(w.out_.command.wheel[4].enabled);
  EXPECT_EQ(w.out_.command.clutches >> 4 & 1, 0);
  EXPECT_TRUE(w.out_.command.wheel[0].enabled);
  w.send(lss::CommandKind::stop);
  ASSERT_TRUE(w.run_until([&] { return w.state() == State::idle; }, 10));
  w.node(4).state = canopen::NodeState::operational;
  w.send(lss::CommandKind::restore);
  w.run(1);
  EXPECT_EQ(w.supervisor_.controller().isolated, 0u);
  EXPECT_TRUE(starts_with_wheel_5(w));
}

TEST(ArditoCycle, AWheelWhoseDriveIsStillInFaultSaysSoWhenItIsRestored) {
  World w;
  ASSERT_NO_FATAL_FAILURE(isolate_wheel_5(w));
  ASSERT_FALSE(w.has(FaultId::drive_fault, 5));
  w.send(lss::CommandKind::restore);
  w.run(1);
  EXPECT_TRUE(w.has(FaultId::drive_fault, 5));
  EXPECT_EQ(w.state(), State::fatal_error);
}

TEST(ArditoCycle, AWheelWhoseDriveWasRepairedDrivesAgainWhenItIsRestored) {
  World w;
  ASSERT_NO_FATAL_FAILURE(isolate_wheel_5(w));
  w.alter = nullptr;
  w.run(1);
  ASSERT_EQ(w.drive(4), canopen::DriveState::fault) << "until it is reset";
  w.send(lss::CommandKind::restore);
  w.run(1);
  EXPECT_EQ(w.supervisor_.controller().isolated, 0u);
  EXPECT_FALSE(w.has(FaultId::drive_fault, 5));
  EXPECT_TRUE(starts_with_wheel_5(w));
}

TEST(ArditoCycle, ALostImuEndsAutonomousDrivingAndLeavesDrivingByHand) {
  World w;
  ASSERT_TRUE(w.start());
  w.run(1);
  w.send(CommandKind::drive, {0.3, 0, 1, 1});
  ASSERT_TRUE(w.run_until(Mode::running, 15));
  w.imu_alive = false;
  ASSERT_TRUE(w.run_until(Mode::stopped, 10));
  EXPECT_TRUE(w.heard(events::autonomy_ended));
  EXPECT_TRUE(w.has(faults::imu_lost, kImuNode));
  EXPECT_EQ(w.last(Phase::failed)->verdict.reason, Reason::imu_lost);
  EXPECT_EQ(w.state(), State::operational);
  w.send(CommandKind::drive, {0.3, 0, 1, 1});
  w.step();
  EXPECT_EQ(w.last(Phase::rejected)->verdict.reason, Reason::imu_lost);
  EXPECT_TRUE(w.drive_at(0.3));
}

TEST(ArditoCycle, AnImuThatNeverComesIsReportedAndOneThatBootsIsNot) {
  World w;
  w.node(kImu).state = canopen::NodeState::booting;
  w.imu_alive = false;
  w.run(1);
  EXPECT_FALSE(w.has(faults::imu_lost, kImuNode)) << "it is still booting";
  w.run(6);
  EXPECT_TRUE(w.has(faults::imu_lost, kImuNode));
  w.node(kImu).state = canopen::NodeState::operational;
  w.imu_alive = true;
  w.run(1);
  EXPECT_FALSE(w.has(faults::imu_lost, kImuNode));
}

TEST(ArditoCycle, AMotorEncoderThatFailsIsSubstitutedWhileItDrives) {
  World w;
  ASSERT_TRUE(w.start_and_drive(0.3));
  w.run(2);
  w.distort = [](std::vector<Reading>& readings) {
    for (Reading& r : readings) {
      if (auto* m = std::get_if<WheelMotion>(&r); m && m->wheel == 1) m->motor_rpm = 0;
    }
  };
  ASSERT_TRUE(w.run_until([&] { return w.has(faults::wheel_sensor, 2); }, 2));
  w.run(5);
  EXPECT_EQ(w.mode(), Mode::running);
  EXPECT_EQ(w.out_.telemetry.wheels[1].state, 1);
}

TEST(ArditoCycle, TheThreeInstancesAgreeWhileNothingUpsetsOne) {
  World w;
  ASSERT_TRUE(w.start());
  EXPECT_FALSE(w.has(faults::instance_disagreed));
  EXPECT_EQ(w.out_.telemetry.disagreements, 0u);
}

}  // namespace
}  // namespace lss::ardito
