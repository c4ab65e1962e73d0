// The daemon's bus master against the simulated vehicle over a paced bus, in virtual time: two
// programs written from one page, docs/icd-ardito.md, understand one another.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>

#include "drivers/ardito/rover_bus.h"
#include "tools/lss-sim/ardito/vehicle.h"
#include "tools/lss-sim/frame/runner.h"

namespace lss::sim::ardito {
namespace {

using canopen::DriveState;
using canopen::NodeState;
using lss::ardito::RoverBus;
using lss::ardito::RoverOrders;

class DriverAndVehicle : public testing::Test {
 protected:
  DriverAndVehicle() {
    orders_.clutches = 0x3F;
    master_.restart(now_);
  }

  // A frame of the daemon a hundred milliseconds: new orders, then all due work.
  void run(double seconds) {
    const TimeNs end = now_ + static_cast<TimeNs>(seconds * kSecond);
    for (; now_ < end; now_ += kMillisecond) {
      if (now_ % (100 * kMillisecond) == 0) {
        orders_.issued_ns = now_;
        orders_.next_frame_ns = now_ + 100 * kMillisecond;
        ++orders_.serial;
        if (!daemon_stopped_) master_.release(orders_, now_);
      }
      vehicle_.step();
      exchange(now_, now_ + kMillisecond);
    }
  }
  void exchange(TimeNs from, TimeNs to) {
    for (TimeNs t = from; t < to; t += 100 * kMicrosecond) {
      CanFrame frame;
      while (master_.transmit(t, frame)) bus_.from_master(frame, t);
      bus_.advance(t);
      for (CanFrame heard : bus_.take(t)) {
        heard.time_ns = t;
        master_.receive({&heard, 1});
      }
      std::array<lss::ardito::RoverSample, 64> samples;
      for (std::size_t n = master_.take(samples); n-- > 0;) take(samples[n].reading);
    }
  }
  void take(const lss::ardito::Reading& reading) {
    if (const auto* imu = std::get_if<lss::ardito::Imu>(&reading)) imu_ = *imu;
    if (const auto* motion = std::get_if<lss::ardito::WheelMotion>(&reading)) {
      rpm_.at(motion->wheel) = motion->motor_rpm;
    }
    if (const auto* angle = std::get_if<lss::ardito::SteeringAngle>(&reading)) {
      angle_.at(angle->wheel) = angle->reduction_rad;
    }
    if (const auto* inputs = std::get_if<lss::ardito::Inputs>(&reading)) inputs_ = *inputs;
  }
  void inject(const char* fault, bool attach = true) {
    const auto kinds = fault_kinds_of(*make_ardito_kind());
    vehicle_.set_fault(*parse_fault(fault, kinds), attach);
  }
  NodeState state(std::size_t node) { return master_.status().link[node].node.state; }
  DriveState drive(std::size_t node) { return master_.status().link[node].drive; }

  void boot() {
    orders_.standing = true;
    run(3);
    for (std::size_t node = 0; node < lss::ardito::kNodes; ++node) {
      ASSERT_EQ(state(node), NodeState::operational) << node;
    }
  }
  void enable() {
    boot();
    for (auto& wheel : orders_.wheel) wheel = {.enabled = true, .motor_rpm = 0};
    for (auto& steering : orders_.steering) steering = {.enabled = true, .position_rad = 0};
    run(1);
    for (std::size_t node = 0; node < lss::ardito::kIo; ++node) {
      ASSERT_EQ(drive(node), DriveState::operation_enabled) << node;
    }
  }

  TimeNs now_ = 10 * kSecond;
  Ardito vehicle_{RoverOptions{}};
  CanBus bus_{{.paced = true}, vehicle_};
  RoverBus master_{lss::ardito::RoverBusParameters{}};
  RoverOrders orders_;
  bool daemon_stopped_ = false;
  lss::ardito::Imu imu_;
  lss::ardito::Inputs inputs_;
  std::array<double, kWheels> rpm_{}, angle_{};
};

TEST_F(DriverAndVehicle, AllNodesBootAndEveryDriveIsEnabled) {
  enable();
  EXPECT_TRUE(inputs_.power_good);
  EXPECT_FALSE(inputs_.emergency_button);
  EXPECT_EQ(master_.status().counters.master.unknown_frames, 0u);
}

TEST_F(DriverAndVehicle, ItDrivesAndSteersAsOrdered) {
  enable();
  for (auto& wheel : orders_.wheel) wheel.motor_rpm = 1591.5;
  orders_.steering[0].position_rad = orders_.steering[1].position_rad = 0.1;
  orders_.steering[2].position_rad = orders_.steering[3].position_rad = -0.1;
  run(3);
  EXPECT_NEAR(imu_.Vtan_mm_s, 500, 30);
  EXPECT_LT(imu_.yaw_rate_rad_s, -0.03) << "to the left";
  for (std::size_t wheel = 0; wheel < kWheels; ++wheel) EXPECT_NEAR(rpm_[wheel], 1591.5, 20);
  EXPECT_NEAR(angle_[0], 0.1, 0.005);
  EXPECT_NEAR(angle_[5], -0.1, 0.005);
  EXPECT_EQ(master_.status().link[lss::ardito::kFirstSteering].set_points_refused, 0u);
}

TEST_F(DriverAndVehicle, WithoutTheDaemonTheRoverStops) {
  enable();
  for (auto& wheel : orders_.wheel) wheel.motor_rpm = 1591.5;
  run(2);
  ASSERT_GT(imu_.Vtan_mm_s, 450);
  daemon_stopped_ = true;  // its bus thread goes on with orders that grow old
  run(1);
  EXPECT_LT(vehicle_.rover().body().velocity_m_s.norm(), 0.01);
  EXPECT_EQ(drive(0), DriveState::quick_stop_active);
}

TEST_F(DriverAndVehicle, ANodeThatRebootsWhileItDrivesComesBackWhenItStands) {
  enable();
  orders_.standing = false;
  inject("node-reboot:0x12");
  run(2);
  EXPECT_NE(state(lss::ardito::kFirstSteering + 1), NodeState::operational);
  orders_.standing = true;
  run(2);
  EXPECT_EQ(state(lss::ardito::kFirstSteering + 1), NodeState::operational);
  EXPECT_EQ(drive(lss::ardito::kFirstSteering + 1), DriveState::operation_enabled);
}

TEST_F(DriverAndVehicle, ASilentNodeAndAnotherDeviceAreKnown) {
  inject("wrong-device-type:0x03");
  orders_.standing = true;
  run(3);
  EXPECT_NE(state(2), NodeState::operational);
  EXPECT_EQ(state(3), NodeState::operational);
  inject("node-silent:0x04");
  run(0.5);
  EXPECT_NE(state(3), NodeState::operational);
}

TEST_F(DriverAndVehicle, TheButtonFaultsTheDrivesAndAResetBringsThemBack) {
  enable();
  inject("e-stop-button");
  run(1);
  EXPECT_TRUE(inputs_.emergency_button);
  EXPECT_EQ(drive(0), DriveState::fault);
  inject("e-stop-button", false);
  run(0.5);
  EXPECT_EQ(drive(0), DriveState::fault);
  ++orders_.fault_reset_serial;
  run(1.5);
  EXPECT_EQ(drive(0), DriveState::operation_enabled);
}

}  // namespace
}  // namespace lss::sim::ardito
