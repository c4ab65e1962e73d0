// The base of vehicles on velocity drives: how long a braking lasts.

#include "daemon/kit/drive_vehicle.h"

#include <gtest/gtest.h>

namespace lss::kit {
namespace {

class Rover final : public DriveVehicle {
 public:
  Rover() : DriveVehicle(drives({1, 2}), 2) {}
  using DriveVehicle::motors_on;

  // In this frame and from then on.
  void rolls(double motor_rpm) {
    Inputs<Rover> in;
    for (std::uint8_t drive = 0; drive < 2; ++drive)
      in.samples[in.sample_count++] = {.time_ns = kSecond, .drive = drive, .motor_rpm = motor_rpm};
    read(in);
  }

 private:
  void watch_own(Supervisor&) noexcept override {}
};

// Nothing but the friction of the gears would hold it.
TEST(DriveVehicle, AnotherResetDoesNotEndTheBrakingOfWhatStillRolls) {
  for (const double motor_rpm : {500.0, -500.0}) {
    Rover rover;
    rover.motors_on();
    rover.rolls(motor_rpm);
    rover.act(lc::kEmergencyStop, nullptr);  // a reset of the controller in Operational
    ASSERT_TRUE(rover.wanted().quick_stop);
    rover.act(lc::kMotorsOff, nullptr);  // another one, in Idle
    EXPECT_TRUE(rover.wanted().quick_stop);
    rover.rolls(0);
    rover.act(lc::kMotorsOff, nullptr);
    EXPECT_FALSE(rover.wanted().quick_stop) << "it stands";
  }
}

TEST(DriveVehicle, ErrorSolvingAndAStartEndTheBraking) {
  Rover rover;
  rover.rolls(500);
  rover.act(lc::kEmergencyStop, nullptr);
  rover.act(lc::kNextStrategy | lc::kMotorsOff, nullptr);
  EXPECT_FALSE(rover.wanted().quick_stop);
  rover.act(lc::kEmergencyStop, nullptr);
  ASSERT_TRUE(rover.wanted().quick_stop);
  rover.motors_on();
  EXPECT_FALSE(rover.wanted().quick_stop);
}

}  // namespace
}  // namespace lss::kit
