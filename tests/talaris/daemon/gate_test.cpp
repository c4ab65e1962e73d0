#include "daemon/vehicles/talaris/gate.h"

#include <gtest/gtest.h>

#include "daemon/vehicles/talaris/modes.h"

namespace lss::talaris {
namespace {

class TalarisGate : public testing::Test {
 protected:
  TalarisGate() {
    orders_.issued_ns = orders_.boundary_ns = kNow;
    orders_.release_ns = kNow + kOffset;
    orders_.enabled = 0xFF;
  }
  GateCheck check(State state = State::operational, Mode mode = Mode::execute) {
    lc::ControllerState s;
    s.state = state;
    s.mode = static_cast<std::uint8_t>(mode);
    return talaris::check(orders_, before_, s, limits_, kNow);
  }
  void pulse(std::size_t valve, int delay_ms, int on_ms) {
    orders_.pulse[valve] = {delay_ms * kMillisecond, on_ms * kMillisecond};
  }
  GateCheck check_pulse(std::size_t valve, int delay_ms, int on_ms) {
    pulse(valve, delay_ms, on_ms);
    return check();
  }
  static constexpr TimeNs kNow = 50 * kSecond, kOffset = 5 * kMillisecond;
  TalarisOrders orders_, before_;
  GateLimits limits_{.offset_ns = kOffset, .enabled = 0xFF, .fan_step_us = 300, .arming = false};
};

TEST_F(TalarisGate, LetsLegalOrdersPass) {
  pulse(0, 0, 200);
  pulse(1, 160, 40);
  pulse(2, 80, 40);
  orders_.fan_us = {1300, 1000, 1000, 1000};
  EXPECT_EQ(check(), GateCheck::passed);
}

TEST_F(TalarisGate, StopsPulsesOfAWrongLength) {
  EXPECT_EQ(check_pulse(3, 0, 39), GateCheck::pulse);
  EXPECT_EQ(check_pulse(3, 100, 101), GateCheck::pulse);
  EXPECT_EQ(check_pulse(3, 0, 201), GateCheck::pulse);
  EXPECT_EQ(check_pulse(3, -1, 100), GateCheck::pulse);
  EXPECT_EQ(check_pulse(3, 0, -100), GateCheck::pulse);
  EXPECT_EQ(check_pulse(3, 190, 10), GateCheck::passed) << "it goes on in the next frame";
  orders_.pulse[3] = {INT64_MAX, 100 * kMillisecond};
  EXPECT_EQ(check(), GateCheck::pulse);
}

// Between frames, too: just below and just above the shortest pause.
TEST_F(TalarisGate, StopsAPulseTooSoonAfterThatOfTheFrameBefore) {
  before_.boundary_ns = kNow - kFrame;
  before_.release_ns = before_.boundary_ns + kOffset;
  before_.pulse[4] = {20 * kMillisecond, 160 * kMillisecond};  // shut for 20 ms of its frame
  EXPECT_EQ(check_pulse(4, 20, 100), GateCheck::passed);
  EXPECT_EQ(check_pulse(4, 19, 100), GateCheck::pause);
  pulse(5, 19, 100);
  EXPECT_EQ(check_pulse(4, 0, 0), GateCheck::passed) << "another valve";

  before_.pulse[4] = {0, 200 * kMillisecond};
  EXPECT_EQ(check_pulse(4, 0, 100), GateCheck::passed) << "it stays open";
  EXPECT_EQ(check_pulse(4, 1, 100), GateCheck::pause);
  EXPECT_EQ(check_pulse(4, 39, 100), GateCheck::pause);
  EXPECT_EQ(check_pulse(4, 40, 100), GateCheck::passed);

  pulse(4, 1, 100);
  before_.boundary_ns -= kFrame;  // the frame between was missed
  EXPECT_EQ(check(), GateCheck::passed);
}

TEST_F(TalarisGate, StopsValvesThatAreDisabled) {
  pulse(5, 0, 100);
  limits_.enabled = 0xDF;
  EXPECT_EQ(check(), GateCheck::disabled);
  limits_.enabled = 0xFF;
  orders_.enabled = 0xDF;
  EXPECT_EQ(check(), GateCheck::disabled);
}

TEST_F(TalarisGate, StopsHoldsThatAreTooLongOrNotByHand) {
  orders_.hold[1] = {true, orders_.release_ns + 30 * kSecond};
  EXPECT_EQ(check(State::operational, Mode::manual), GateCheck::passed);
  EXPECT_EQ(check(State::operational, Mode::script), GateCheck::passed);
  EXPECT_EQ(check(State::operational, Mode::execute), GateCheck::hold);
  orders_.hold[1].until_ns += 1;
  EXPECT_EQ(check(State::operational, Mode::manual), GateCheck::hold);
  orders_.hold[1].until_ns = orders_.release_ns;
  EXPECT_EQ(check(State::operational, Mode::manual), GateCheck::hold);
}

TEST_F(TalarisGate, StopsFansOutOfRangeOrTooFast) {
  orders_.fan_us[2] = 999;
  EXPECT_EQ(check(), GateCheck::range);
  orders_.fan_us[2] = 2001;
  EXPECT_EQ(check(), GateCheck::range);
  orders_.fan_us[2] = 1301;
  EXPECT_EQ(check(), GateCheck::slew);
  limits_.arming = true;
  EXPECT_EQ(check(State::operational, Mode::manual), GateCheck::passed);
  limits_.arming = false;
  before_.fan_us[2] = 2000;
  orders_.fan_us[2] = 1000;
  EXPECT_EQ(check(), GateCheck::passed) << "slower at once";
}

TEST_F(TalarisGate, NothingButTheSafeCommandPassesOutsideOperational) {
  for (const State state : {State::idle, State::fatal_error, State::solve_errors}) {
    EXPECT_EQ(check(state, Mode::none), GateCheck::passed);
    pulse(0, 0, 40);
    EXPECT_EQ(check(state, Mode::none), GateCheck::state);
    orders_.pulse[0] = {};
    orders_.hold[0] = {true, orders_.release_ns + kSecond};
    EXPECT_EQ(check(state, Mode::none), GateCheck::state);
    orders_.hold[0] = {};
    orders_.fan_us[3] = 1001;
    EXPECT_EQ(check(state, Mode::none), GateCheck::state);
    EXPECT_EQ(check(State::operational, Mode::standby), GateCheck::state);
    EXPECT_EQ(check(State::operational, Mode::calibrate), GateCheck::state);
    orders_.fan_us[3] = 1000;
  }
  pulse(0, 0, 40);
  orders_.all_stop = true;
  EXPECT_EQ(check(), GateCheck::state);
}

TEST_F(TalarisGate, TheSafeCommandIsEverythingShutAndOff) {
  pulse(0, 0, 40);
  orders_.hold[7] = {true, kNow + kSecond};
  orders_.fan_us.fill(1500);
  orders_.node_reset_serial = 9;
  EXPECT_TRUE(active(orders_));
  make_safe(orders_);
  EXPECT_FALSE(active(orders_));
  EXPECT_EQ(orders_.node_reset_serial, 9u);
  EXPECT_FALSE(active(TalarisOrders{}));
}

}  // namespace
}  // namespace lss::talaris
