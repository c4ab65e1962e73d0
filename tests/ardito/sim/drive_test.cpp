// Drives by their frames, on a bench whose shafts follow exactly: CiA 402's states, profile
// velocity and position, quick stop, motor power (ICD section 9); and what motor, gear and clutch
// do.

#include "tools/lss-sim/ardito/drive.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/ardito/sim/master.h"

namespace lss::sim::ardito {
namespace {

constexpr double kRpm = 2 * std::numbers::pi / 60;

// A wheel and a steering shaft, each with its train. The shafts turn as they are driven, against a
// load that a driven wheel feels.
class Bench : public testing::Test {
 protected:
  Bench() {
    wheel_.power_on();
    steering_.power_on();
    train_.clutch_ordered = true;
  }

  void step() {
    wheel_.set_link_V(link_V_);
    steering_.set_link_V(link_V_);
    wheel_.step();
    steering_.step();
    const ShaftDrive drive = train_.step(wheel_.order(), shaft_, link_V_);
    const bool held = load_Nm_ > drive.torque_limit_Nm;
    shaft_.velocity_rad_s = held ? 0 : drive.velocity_rad_s;
    shaft_.torque_Nm =
        std::copysign(std::min(load_Nm_, drive.torque_limit_Nm), wheel_.order().velocity_rad_s);
    const ShaftDrive turn = steering_train_.step(steering_.order(), angle_, link_V_);
    angle_.velocity_rad_s = turn.velocity_rad_s;
    angle_.angle_rad += turn.velocity_rad_s * kStep_s;
    wheel_.feel(train_, shaft_);
    steering_.feel(steering_train_, angle_);
  }
  std::optional<CanFrame> hear() {
    if (auto said = wheel_.send()) return said;
    return steering_.send();
  }
  void enable() {
    ASSERT_TRUE(master_.bring_up(0x01));
    ASSERT_TRUE(master_.bring_up(0x15));
    master_.wheel_rpm[1] = 0;
    master_.steering_counts[0x15] = 0;
    ASSERT_TRUE(master_.enable_drives());
  }
  double rpm() const { return train_.motor_rad_s() / kRpm; }
  // TPDO values of the wheel.
  double said_rpm() { return static_cast<double>(i32_at(master_.last[0x181], 2)); }
  double said_per_mille() { return static_cast<double>(i16_at(master_.last[0x181], 6)); }
  double said_hall() { return static_cast<double>(i32_at(master_.last[0x281], 0)); }
  double said_wheel_rpm() { return static_cast<double>(i32_at(master_.last[0x281], 4)) / 100; }

  WheelDrive wheel_{0x01, 1};
  SteeringDrive steering_{0x15, 2};
  WheelTrain train_;
  SteeringTrain steering_train_;
  ShaftState shaft_, angle_;
  double link_V_ = 24, load_Nm_ = 0.7;
  Master master_{[this](const CanFrame& frame) {
                   wheel_.receive(frame);
                   steering_.receive(frame);
                 },
                 [this] { return hear(); }, [this] { step(); }};
};

TEST_F(Bench, EachControlwordLeadsOneStepOn) {
  ASSERT_TRUE(master_.bring_up(0x01));
  const auto status_after = [&](const char* rpdo) {
    master_.tell("77F [1] 05");
    master_.tell(rpdo);
    master_.tell("080 [0]");
    master_.run(1);
    return master_.statusword(1) & 0x6F;
  };
  EXPECT_EQ(status_after("201 [6] 0F 00 00 00 00 00") & 0x4F, 0x40u);  // not at once
  EXPECT_EQ(status_after("201 [6] 06 00 00 00 00 00"), 0x21u);
  EXPECT_EQ(status_after("201 [6] 07 00 00 00 00 00"), 0x23u);
  EXPECT_EQ(status_after("201 [6] 0F 00 00 00 00 00"), 0x27u);
  EXPECT_EQ(status_after("201 [6] 02 00 00 00 00 00"), 0x07u);
  EXPECT_EQ(status_after("201 [6] 0F 00 00 00 00 00"), 0x07u);
  EXPECT_EQ(status_after("201 [6] 00 00 00 00 00 00") & 0x4F, 0x40u);
  EXPECT_EQ(status_after("201 [6] 06 00 00 00 00 00"), 0x21u);
  EXPECT_EQ(status_after("201 [6] 00 00 00 00 00 00") & 0x4F, 0x40u);
}

TEST_F(Bench, AWheelFollowsItsTargetWithItsAccelerationAndSaysSo) {
  enable();
  master_.wheel_rpm[1] = 1600;
  master_.cycle();
  // 8000 rpm/s reaches 800 rpm in the 100 ms of a cycle.
  EXPECT_NEAR(rpm(), 800, 50);
  master_.cycle(5);
  EXPECT_NEAR(rpm(), 1600, 1);
  EXPECT_NEAR(said_rpm(), 1600, 15);
  EXPECT_NEAR(said_hall(), 1600, 40);
  EXPECT_NEAR(said_wheel_rpm(), 32, 0.5);
  EXPECT_EQ(master_.statusword(1), 0x0637u);  // enabled, voltage, remote, target reached
  master_.wheel_rpm[1] = -1600;
  master_.cycle(6);
  EXPECT_NEAR(said_rpm(), -1600, 15);
  EXPECT_LT(said_per_mille(), -100);
}

TEST_F(Bench, ALostMasterStopsTheWheelByItsRampAndHoldsIt) {
  enable();
  master_.wheel_rpm[1] = 1600;
  master_.cycle(6);
  master_.heartbeat = false;
  master_.run(300);
  EXPECT_EQ(wheel_.power(), Power::quick_stop);
  EXPECT_GT(rpm(), 500);
  master_.run(250);
  EXPECT_EQ(rpm(), 0);
  EXPECT_TRUE(wheel_.order().on) << "it holds";
  EXPECT_EQ(wheel_.state(), Nmt::pre_operational);
}

TEST_F(Bench, CurrentIsLargerWithLoadThanWithout) {
  enable();
  master_.wheel_rpm[1] = 1600;
  master_.cycle(8);
  const double loaded = said_per_mille();
  train_.clutch_fault = ClutchFault::open;
  master_.cycle(3);
  const double alone = said_per_mille();
  EXPECT_NEAR(said_rpm(), 1600, 20) << "the motor goes on";
  EXPECT_NEAR(said_wheel_rpm(), 0, 0.1) << "the wheel does not";
  EXPECT_NEAR(alone, motor::no_load_A(1600 * kRpm) / motor::kRated_A * 1000, 20);
  EXPECT_GT(loaded, 2 * alone);
}

TEST_F(Bench, CurrentGrowsWithTheLoadUpToItsLimit) {
  enable();
  master_.wheel_rpm[1] = 1000;
  double before = 0;
  for (const double load_Nm : {0.5, 2.0, 5.0, 10.0}) {
    load_Nm_ = load_Nm;
    master_.cycle(6);
    EXPECT_GT(said_per_mille(), before + 50) << load_Nm;
    before = said_per_mille();
  }
  load_Nm_ = 60;
  master_.cycle(3);
  EXPECT_NEAR(said_per_mille(), 2500, 30);
  EXPECT_NE(master_.statusword(1) & 1u << 11, 0u) << "internal limit";
  EXPECT_EQ(rpm(), 0);
}

TEST_F(Bench, FailuresOfTheTrainHaveTheirEffect) {
  enable();
  master_.wheel_rpm[1] = 1600;
  const auto expect = [&](const char* what, double motor_rpm, double wheel_rpm, double per_mille) {
    master_.cycle(4);
    EXPECT_NEAR(said_rpm(), motor_rpm, 30) << what;
    EXPECT_NEAR(said_wheel_rpm(), wheel_rpm, 0.5) << what;
    EXPECT_NEAR(said_per_mille(), per_mille, 40) << what;
  };
  const double idle = motor::no_load_A(1600 * kRpm) / motor::kRated_A * 1000;
  train_.motor_fault = MotorFault::blocked;
  expect("stuck motor", 0, 0, 0);
  train_.clutch_ordered = false;
  expect("stuck motor, clutch open", 0, 0, 0);
  train_.motor_fault = MotorFault::none;
  expect("clutch open", 1600, 0, idle);
  train_.clutch_fault = ClutchFault::closed;
  master_.cycle(4);
  EXPECT_NEAR(said_wheel_rpm(), 32, 0.5) << "a clutch that does not open";
  train_.clutch_fault = ClutchFault::none;
  train_.clutch_ordered = true;
  train_.gear_fault = GearFault::jammed;
  expect("jammed gear", 0, 0, 2500);
  train_.gear_fault = GearFault::loose;
  expect("loose gear", 1600, 0, idle);
}

TEST_F(Bench, AMotorBlockedForLongGoesToFaultUntilItIsReset) {
  enable();
  train_.gear_fault = GearFault::jammed;
  master_.wheel_rpm[1] = 1600;
  master_.cycle(25);
  EXPECT_EQ(wheel_.power(), Power::enabled);
  master_.cycle(10);
  EXPECT_EQ(master_.statusword(1) & 0x4F, 0x08u);
  EXPECT_THAT(master_.heard, testing::Contains("081 [8] 21 71 21 00 00 00 00 00"));
  train_.gear_fault = GearFault::none;
  master_.cycle(3);
  EXPECT_EQ(wheel_.power(), Power::fault) << "not by itself";
  master_.tell("201 [6] 80 00 00 00 00 00");
  EXPECT_EQ(wheel_.power(), Power::switch_on_disabled);
  EXPECT_TRUE(master_.enable_drives());
}

TEST_F(Bench, WithoutMotorPowerADriveGoesToFaultAndComesBackOnlyAbove18V) {
  enable();
  link_V_ = 9;
  master_.cycle(2);
  EXPECT_EQ(master_.statusword(1) & 0x4F, 0x08u);
  EXPECT_EQ(master_.statusword(1) & 1u << 4, 0u) << "voltage enabled";
  EXPECT_THAT(master_.heard, testing::Contains("081 [8] 20 32 05 00 00 00 00 00"));
  EXPECT_THAT(master_.heard, testing::Contains("095 [8] 20 32 05 00 00 00 00 00"));
  const auto reset = [&] {
    master_.tell("201 [6] 00 00 00 00 00 00");
    master_.tell("201 [6] 80 00 00 00 00 00");
    return wheel_.power();
  };
  link_V_ = 15;
  master_.cycle();
  EXPECT_EQ(reset(), Power::fault);
  link_V_ = 20;
  master_.cycle();
  EXPECT_EQ(reset(), Power::switch_on_disabled);
}

TEST_F(Bench, AHotMotorIsWarnedOfAndThenSwitchedOff) {
  enable();
  train_.heat_to(95);
  master_.cycle();
  EXPECT_NE(master_.statusword(1) & 1u << 7, 0u);
  train_.heat_to(115);
  master_.cycle();
  EXPECT_EQ(wheel_.power(), Power::fault);
  EXPECT_THAT(master_.heard, testing::Contains("081 [8] 10 43 09 00 00 00 00 00"));
}

TEST_F(Bench, SteeringTakesASetPointWithTheEdgeAndReachesIt) {
  enable();
  master_.tell("215 [6] 2F 00 90 D0 03 00");
  master_.run(100);
  EXPECT_EQ(angle_.angle_rad, 0) << "a target is no set-point";
  master_.tell("215 [6] 3F 00 90 D0 03 00");
  master_.tell("080 [0]");
  master_.run(5);
  EXPECT_NE(master_.statusword(0x15) & 1u << 12, 0u) << "acknowledged";
  EXPECT_EQ(master_.statusword(0x15) & 1u << 10, 0u) << "not there yet";
  master_.steering_counts[0x15] = 250'000;
  master_.cycle(14);
  EXPECT_NEAR(angle_.angle_rad, 0.5, 0.002);
  EXPECT_NEAR(static_cast<double>(i32_at(master_.last[0x195], 2)), 250'000, 500);
  EXPECT_NEAR(static_cast<double>(i32_at(master_.last[0x295], 0)), 5000, 30);
  EXPECT_NE(master_.statusword(0x15) & 1u << 10, 0u) << "reached";
}

TEST_F(Bench, SteeringKeepsItsProfileVelocity) {
  enable();
  master_.steering_counts[0x15] = 500'000;  // 1 rad of the wheel at 0.5 rad/s
  master_.cycle(10);
  const double before_rad = angle_.angle_rad;
  master_.cycle(5);
  EXPECT_NEAR((angle_.angle_rad - before_rad) / 0.5, 0.5, 0.01);
}

TEST_F(Bench, ANewSetPointReplacesTheOneUnderWay) {
  enable();
  master_.steering_counts[0x15] = 500'000;
  master_.cycle(5);
  master_.steering_counts[0x15] = -100'000;
  master_.cycle(20);
  EXPECT_NEAR(angle_.angle_rad, -0.2, 0.002);
}

TEST_F(Bench, QuickStopHoldsSteeringWhereItStops) {
  enable();
  master_.steering_counts[0x15] = 500'000;
  master_.cycle(8);
  master_.tell("215 [6] 02 00 20 A1 07 00");
  master_.run(400);
  const double stopped_rad = angle_.angle_rad;
  master_.run(200);
  EXPECT_EQ(steering_.power(), Power::quick_stop);
  EXPECT_NEAR(angle_.angle_rad, stopped_rad, 1e-4);
  EXPECT_GT(stopped_rad, 0.1);
  EXPECT_LT(stopped_rad, 0.9);
}

TEST_F(Bench, AFailedSteeringMotorStaysBehindAndIsSeenInTheStatusword) {
  enable();
  steering_train_.motor_fault = MotorFault::blocked;
  master_.steering_counts[0x15] = 500'000;
  master_.cycle(15);
  EXPECT_NEAR(angle_.angle_rad, 0, 1e-3);
  EXPECT_NEAR(static_cast<double>(i32_at(master_.last[0x195], 2)), 0, 500);
  EXPECT_NE(master_.statusword(0x15) & 1u << 13, 0u) << "following error";
  EXPECT_THAT(master_.heard, testing::Contains("095 [8] 11 86 21 00 00 00 00 00"));
}

TEST_F(Bench, FailedSensorsReportWrongValuesOfAGoodShaft) {
  enable();
  master_.wheel_rpm[1] = 1600;
  wheel_.signal(1)->hold(0);
  master_.cycle(6);
  EXPECT_EQ(said_rpm(), 0);
  EXPECT_NEAR(rpm(), 1600, 1);
  wheel_.signal(1)->hold(std::nullopt);
  wheel_.signal(2)->stick(true);
  const double stuck = said_hall();
  master_.wheel_rpm[1] = 800;
  master_.cycle(4);
  EXPECT_EQ(said_hall(), stuck);
  EXPECT_NEAR(said_rpm(), 800, 10);
  wheel_.signal(3)->drift(100);  // 1 rpm of the wheel a second
  master_.cycle(20);
  EXPECT_NEAR(said_wheel_rpm(), 18, 0.5);
  steering_.signal(1)->jump(20'000);
  master_.cycle();
  EXPECT_NEAR(static_cast<double>(i32_at(master_.last[0x195], 2)), 20'000, 500);
  EXPECT_NEAR(angle_.angle_rad, 0, 1e-3);
}

TEST_F(Bench, AfterAResetTheMotorCountsFromTheAbsoluteAngle) {
  enable();
  master_.steering_counts[0x15] = 250'000;
  master_.cycle(16);
  master_.last.clear();
  master_.tell("000 [2] 81 15");
  ASSERT_TRUE(master_.bring_up(0x15));
  master_.cycle(6);
  EXPECT_NEAR(static_cast<double>(i32_at(master_.last[0x195], 2)), 250'000, 1500);
  EXPECT_NEAR(angle_.angle_rad, 0.5, 0.003);
}

}  // namespace
}  // namespace lss::sim::ardito
