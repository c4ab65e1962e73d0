// The whole vehicle by its frames: twelve nodes, their trains and the rover, driven by a scripted
// master faster than real time.

#include "tools/lss-sim/ardito/vehicle.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "tests/ardito/sim/master.h"
#include "tools/lss-sim/frame/runner.h"

namespace lss::sim::ardito {
namespace {

constexpr double kRpm_m_s = 0.15 * 2 * 3.14159265358979 / 60 / 50;  // of the motor, to the tread

class Vehicle : public testing::Test {
 protected:
  void bring_up() {
    ASSERT_TRUE(master_.bring_up_all());
    for (const unsigned node : {1u, 2u, 3u, 4u, 5u, 6u}) master_.wheel_rpm[node] = 0;
    for (const unsigned node : {0x11u, 0x12u, 0x15u, 0x16u}) master_.steering_counts[node] = 0;
    master_.outputs = 0x3F;
    ASSERT_TRUE(master_.enable_drives());
  }
  void drive(double speed_m_s) {
    for (auto& [node, rpm] : master_.wheel_rpm) {
      rpm = static_cast<std::int32_t>(std::lround(speed_m_s / kRpm_m_s));
    }
  }
  void bring_up_and_drive() {
    bring_up();
    drive(0.5);
    master_.cycle(10);
  }
  void inject(const char* fault_text, bool attach = true) {
    vehicle_.set_fault(*parse_fault(fault_text, kinds_), attach);
  }
  double encoder_rpm(unsigned wheel) {
    return static_cast<double>(i32_at(master_.last[0x180 + wheel], 2)) / 50;
  }
  double hall_rpm(unsigned wheel) {
    return static_cast<double>(i32_at(master_.last[0x280 + wheel], 0)) / 50;
  }
  double reduction_rpm(unsigned wheel) {
    return static_cast<double>(i32_at(master_.last[0x280 + wheel], 4)) / 100;
  }
  double per_mille(unsigned wheel) {
    return static_cast<double>(i16_at(master_.last[0x180 + wheel], 6));
  }
  double vtan_mm_s() { return static_cast<double>(i16_at(master_.last[0x1A1], 0)); }
  double sigma_rad() { return static_cast<double>(i16_at(master_.last[0x1A1], 2)) * 1e-4; }

  std::unique_ptr<VehicleKind> kind_ = make_ardito_kind();
  std::vector<FaultKind> kinds_ = fault_kinds_of(*kind_);
  Ardito vehicle_{RoverOptions{}};
  Master master_{[this](const CanFrame& frame) { vehicle_.receive(frame); },
                 [this] { return vehicle_.send(); }, [this] { vehicle_.step(); }};
};

TEST_F(Vehicle, AllNodesBootAreConfiguredAndEnabled) {
  bring_up();
  for (const unsigned node : {1u, 2u, 3u, 4u, 5u, 6u, 0x11u, 0x12u, 0x15u, 0x16u}) {
    EXPECT_EQ(master_.statusword(node) & 0x6F, 0x27u) << node;
  }
  EXPECT_EQ(text(master_.last[0x1A0]), "1A0 [1] 02");
}

TEST_F(Vehicle, DrivesStraightAtTheCommandedSpeed) {
  bring_up_and_drive();
  const double from_m = vehicle_.rover().body().position_m.x();
  master_.cycle(20);
  EXPECT_NEAR((vehicle_.rover().body().position_m.x() - from_m) / 2, 0.5, 0.025);
  EXPECT_NEAR(vtan_mm_s(), 500, 25);
  EXPECT_NEAR(sigma_rad(), 0, 0.03);
  for (unsigned wheel = 1; wheel <= 6; ++wheel) {
    EXPECT_NEAR(encoder_rpm(wheel), 31.83, 0.3) << wheel;
    EXPECT_NEAR(hall_rpm(wheel), 31.83, 1.0) << wheel;
    EXPECT_NEAR(reduction_rpm(wheel), 31.83, 0.5) << wheel;
    EXPECT_GT(per_mille(wheel), 130) << wheel;
  }
}

TEST_F(Vehicle, OpenClutchesLeaveItWhereItIs) {
  bring_up();
  master_.outputs = 0;
  drive(0.5);
  master_.cycle(10);
  EXPECT_LT(vehicle_.rover().body().position_m.norm() - 0.525, 0.02);
  EXPECT_NEAR(encoder_rpm(3), 31.83, 0.5);
  EXPECT_NEAR(reduction_rpm(3), 0, 0.1);
}

TEST_F(Vehicle, ItTurnsToTheSideThatTheImuSays) {
  bring_up();
  const double right_rad = 0.3;  // front wheels to the right, rear ones to the left
  for (const unsigned node : {0x11u, 0x12u}) master_.steering_counts[node] = -150'000;
  for (const unsigned node : {0x15u, 0x16u}) master_.steering_counts[node] = 150'000;
  master_.cycle(15);
  EXPECT_NEAR(vehicle_.rover().steering()[0].angle_rad, -right_rad, 0.01);
  drive(0.3);
  master_.cycle(20);
  EXPECT_GT(static_cast<double>(i16_at(master_.last[0x1A1], 4)), 80) << "clockwise";
  EXPECT_GT(sigma_rad(), 0.01) << "to the right";
  EXPECT_LT(vehicle_.rover().body().position_m.y(), -0.05);
}

TEST_F(Vehicle, EveryTractionFailureHasTheEffectOfItsName) {
  bring_up_and_drive();
  const auto expect = [&](const char* fault, double motor_rpm, double hall, double wheel_rpm) {
    inject(fault);
    master_.cycle(5);
    EXPECT_NEAR(encoder_rpm(2), motor_rpm, 0.5) << fault;
    EXPECT_NEAR(hall_rpm(2), hall, 1.2) << fault;
    EXPECT_NEAR(reduction_rpm(2), wheel_rpm, 1.2) << fault;
    inject(fault, false);
    master_.cycle(5);
    EXPECT_NEAR(encoder_rpm(2), 31.83, 0.5) << "after " << fault;
    EXPECT_NEAR(reduction_rpm(2), 31.83, 0.7) << "after " << fault;
  };
  expect("H-TM:2", 31.83, 0, 31.83);
  expect("E-TM:2", 0, 31.83, 31.83);
  expect("E-TRG:2", 31.83, 31.83, 0);
  expect("E-TM:2:900", 18, 31.83, 31.83);
  expect("TM:2", 0, 0, 0);                 // stuck: it skids
  expect("TRG:2", 0, 0, 0);                // jammed
  expect("TRG:2:1", 31.83, 31.83, 31.83);  // loose: it rolls along
  expect("TC:2", 31.83, 31.83, 31.83);     // the same: only the current shows it
}

TEST_F(Vehicle, AClutchThatFailedShowsInTheCurrentOnly) {
  bring_up_and_drive();
  const double loaded = per_mille(4);
  inject("TC:4");
  master_.cycle(5);
  const double idle = motor::no_load_A(1591.5 * 2 * 3.14159 / 60) / motor::kRated_A * 1000;
  EXPECT_NEAR(per_mille(4), idle, 20);
  EXPECT_GT(loaded, idle + 50);
}

TEST_F(Vehicle, ATractionMotorWithoutTorqueRollsAlongWithoutCurrent) {
  bring_up_and_drive();
  inject("TM:5:1");
  master_.cycle(5);
  EXPECT_GT(encoder_rpm(5), 20);
  EXPECT_NEAR(per_mille(5), 0, 20);
}

TEST_F(Vehicle, FailuresAddUp) {
  bring_up_and_drive();
  for (const char* each : {"H-TM:3:300", "E-TM:3:-600", "E-TRG:3:5"}) inject(each);
  master_.cycle(3);
  EXPECT_NEAR(hall_rpm(3), 6, 0.01);
  EXPECT_NEAR(encoder_rpm(3), -12, 0.01);
  EXPECT_NEAR(reduction_rpm(3), 5, 0.01);
  inject("TM:3");
  master_.cycle(3);
  EXPECT_NEAR(vehicle_.rover().wheels()[2].velocity_rad_s, 0, 0.05);
}

TEST_F(Vehicle, EverySteeringFailureHasTheEffectOfItsName) {
  bring_up();
  const auto turn = [&](std::int32_t counts) {
    for (auto& [node, target] : master_.steering_counts) target = counts;
    master_.cycle(12);
  };
  const auto motor_counts = [&](unsigned node) {
    return static_cast<double>(i32_at(master_.last[0x180 + node], 2));
  };
  const auto reduction_counts = [&](unsigned node) {
    return static_cast<double>(i32_at(master_.last[0x280 + node], 0));
  };
  inject("SM:1");
  inject("SRG:2");
  inject("E-SM:5");
  inject("E-SRG:6");
  turn(100'000);  // 0.2 rad of the wheel
  EXPECT_NEAR(vehicle_.rover().steering()[0].angle_rad, 0, 0.01);
  EXPECT_NEAR(motor_counts(0x11), 0, 2000);
  EXPECT_NEAR(vehicle_.rover().steering()[1].angle_rad, 0, 0.01);
  EXPECT_NEAR(motor_counts(0x12), 0, 2000);
  EXPECT_NEAR(vehicle_.rover().steering()[2].angle_rad, 0.2, 0.01);
  EXPECT_NEAR(motor_counts(0x15), 0, 200);
  EXPECT_NEAR(reduction_counts(0x15), 2000, 50);
  EXPECT_NEAR(vehicle_.rover().steering()[3].angle_rad, 0.2, 0.01);
  EXPECT_NEAR(motor_counts(0x16), 100'000, 1000);
  EXPECT_NEAR(reduction_counts(0x16), 0, 50);
}

TEST_F(Vehicle, TheButtonTakesTheMotorsPowerAndItRollsOut) {
  bring_up_and_drive();
  inject("e-stop-button");
  master_.cycle(8);
  EXPECT_EQ(text(master_.last[0x1A0]), "1A0 [1] 01");
  for (unsigned node = 1; node <= 6; ++node) EXPECT_EQ(master_.statusword(node) & 0x4F, 0x08u);
  EXPECT_LT(vehicle_.rover().body().velocity_m_s.norm(), 0.01);
  inject("e-stop-button", false);
  master_.cycle(2);
  EXPECT_EQ(text(master_.last[0x1A0]), "1A0 [1] 02");
  EXPECT_EQ(master_.statusword(1) & 0x4F, 0x08u) << "a fault is reset only by order";
  inject("power-bad");
  master_.cycle(2);
  EXPECT_EQ(text(master_.last[0x1A0]), "1A0 [1] 00");
}

TEST_F(Vehicle, ALostMasterStopsTheRover) {
  bring_up_and_drive();
  master_.heartbeat = false;
  master_.wheel_rpm.clear();
  master_.steering_counts.clear();
  master_.run(900);
  EXPECT_LT(vehicle_.rover().body().velocity_m_s.norm(), 0.01);
  EXPECT_TRUE(vehicle_.io().beacon());
  EXPECT_TRUE(vehicle_.train(0).coupled()) << "the gears hold it";
}

TEST_F(Vehicle, SuspensionAndImuFaultsAreSeen) {
  bring_up_and_drive();
  inject("rocker-encoder:2:0.8");
  inject("imu-jump:800");
  master_.cycle(2);
  EXPECT_EQ(i16_at(master_.last[0x2A0], 2), 8000);
  EXPECT_NEAR(vtan_mm_s(), 1300, 30);
  inject("imu-jump", false);
  inject("imu-stuck");
  const CanFrame before = master_.last[0x1A1];
  master_.cycle(3);
  EXPECT_EQ(text(master_.last[0x1A1]), text(before));
  inject("imu-stuck", false);
  inject("imu-silent");
  master_.last.erase(0x1A1);
  master_.cycle(3);
  EXPECT_FALSE(master_.last.contains(0x1A1));
}

TEST_F(Vehicle, ASilentDriveStopsByItselfAndARebootedOneStaysOutOfOperation) {
  bring_up_and_drive();
  inject("node-silent:0x03");
  inject("node-reboot:0x06");
  master_.cycle(10);
  EXPECT_EQ(vehicle_.wheel(2).state(), Nmt::pre_operational);
  EXPECT_LT(std::abs(vehicle_.train(2).motor_rad_s()), 10);
  EXPECT_EQ(vehicle_.wheel(5).state(), Nmt::pre_operational);
  EXPECT_THAT(master_.heard, testing::Contains("706 [1] 00"));
}

TEST_F(Vehicle, EveryKindOfFaultCanBeAttachedAndClearedWhileItDrives) {
  bring_up_and_drive();
  for (const FaultKind& kind : fault_kinds()) {
    Fault fault{.kind = &kind, .values = {}, .clear = false};
    for (const FaultArgument& argument : kind.arguments) {
      fault.values.push_back(argument.choices.empty() ? std::max(argument.min, 1.0)
                                                      : argument.choices.front());
    }
    vehicle_.set_fault(fault, true);
    EXPECT_TRUE(vehicle_.in_force(fault)) << kind.name;
    master_.cycle(1);
    if (!kind.momentary) vehicle_.set_fault(fault, false);
    master_.cycle(1);
  }
  EXPECT_TRUE(std::isfinite(vehicle_.rover().body().position_m.norm()));
}

TEST_F(Vehicle, TheTruthHasWhatATestNeeds) {
  bring_up_and_drive();
  const auto truth = vehicle_.truth();
  for (const auto& [key, size] : {std::pair{"position_m", 3u},
                                  {"attitude_wxyz", 4u},
                                  {"velocity_m_s", 3u},
                                  {"wheel_rad_s", 6u},
                                  {"wheel_slip_m_s", 6u},
                                  {"steering_rad", 4u},
                                  {"rho_rad", 2u},
                                  {"motor_rad_s", 6u},
                                  {"motor_current_A", 6u},
                                  {"coupled", 6u}}) {
    EXPECT_EQ(truth.at(key).size(), size) << key;
  }
  EXPECT_NEAR(truth.at("velocity_body_m_s")[0].get<double>(), 0.5, 0.025);
}

}  // namespace
}  // namespace lss::sim::ardito
