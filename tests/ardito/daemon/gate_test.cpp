#include "daemon/vehicles/ardito/gate.h"

#include <gtest/gtest.h>

#include "daemon/vehicles/ardito/modes.h"

namespace lss::ardito {
namespace {

class ArditoGate : public testing::Test {
 protected:
  ArditoGate() { orders_.issued_ns = kNow; }
  GateCheck check(State state = State::operational, Mode mode = Mode::running,
                  std::uint16_t isolated = 0) {
    lc::ControllerState s;
    s.state = state;
    s.mode = static_cast<std::uint8_t>(mode);
    s.isolated = isolated;
    return ardito::check(orders_, before_, s, {2000, 500, 1.1}, kNow);
  }
  static constexpr TimeNs kNow = 50 * kSecond;
  RoverOrders orders_, before_;
};

TEST_F(ArditoGate, LetsLegalOrdersPass) {
  orders_.wheel[0] = {.enabled = true, .motor_rpm = 400};
  orders_.steering[0] = {.enabled = true, .position_rad = 1.0};
  EXPECT_EQ(check(), GateCheck::passed);
}

TEST_F(ArditoGate, StopsWhatIsTooFastOrTooFar) {
  orders_.wheel[2] = before_.wheel[2] = {.enabled = true, .motor_rpm = -2001};
  EXPECT_EQ(check(), GateCheck::range);
  orders_.wheel[2] = {};
  orders_.steering[1].position_rad = -1.2;
  EXPECT_EQ(check(), GateCheck::range);
}

TEST_F(ArditoGate, StopsASpeedThatGrowsTooFastButNeverSlowingDown) {
  before_.wheel[1].motor_rpm = 1000;
  orders_.wheel[1] = {.enabled = true, .motor_rpm = 1501};
  EXPECT_EQ(check(), GateCheck::slew);
  orders_.wheel[1].motor_rpm = 0;
  EXPECT_EQ(check(), GateCheck::passed);
  orders_.wheel[1].motor_rpm = -501;
  EXPECT_EQ(check(), GateCheck::slew) << "through zero, and too far beyond";
}

TEST_F(ArditoGate, StopsDrivesThatMayNotBeOn) {
  orders_.steering[2].enabled = true;
  EXPECT_EQ(check(State::idle, Mode::none), GateCheck::state);
  EXPECT_EQ(check(State::operational, Mode::warning), GateCheck::state);
  EXPECT_EQ(check(State::solve_errors, Mode::none), GateCheck::state);
  EXPECT_EQ(check(), GateCheck::passed);
  orders_.quick_stop = true;
  EXPECT_EQ(check(), GateCheck::state);
}

TEST_F(ArditoGate, StopsAWheelThatIsOutOfService) {
  orders_.wheel[3].enabled = true;
  EXPECT_EQ(check(State::operational, Mode::running, 1u << 3), GateCheck::state);
  EXPECT_EQ(check(State::operational, Mode::running, 1u << 2), GateCheck::passed);
}

TEST_F(ArditoGate, TheSafeCommandStopsAllDrivesAndHoldsTheClutches) {
  orders_.wheel[0] = {.enabled = true, .motor_rpm = 100};
  orders_.clutches = 0x3F;
  const RoverOrders before = orders_;
  make_safe(orders_, kNow + 5);
  EXPECT_TRUE(orders_.quick_stop);
  EXPECT_FALSE(orders_.wheel[0].enabled);
  EXPECT_EQ(orders_.clutches, 0x3F);
  EXPECT_EQ(orders_.emergency_serial, before.emergency_serial + 1);
  EXPECT_EQ(orders_.serial, before.serial + 1);
  EXPECT_EQ(orders_.issued_ns, kNow + 5);
}

}  // namespace
}  // namespace lss::ardito
