#include "daemon/vehicles/zebro/gate.h"

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include "daemon/vehicles/zebro/modes.h"

namespace lss::zebro {
namespace {

using Kind = ModuleOrder::Kind;

class Gate : public testing::Test {
 protected:
  Gate() {
    orders_.issued_ns = kNow;
    measured_.fill(0);
  }
  GateCheck check(State state = State::operational, std::uint8_t flags = 0) {
    return zebro::check(orders_, before_, measured_, {.state = state, .flags = flags}, {130}, kNow);
  }
  void move(std::size_t i, Kind kind, std::uint16_t cdeg, TimeNs in) {
    orders_.module[i] = {.kind = kind, .position_cdeg = cdeg, .arrive_ns = kNow + in, .serial = 7};
  }
  static constexpr TimeNs kNow = 50 * kSecond;
  BusOrders orders_, before_;
  std::array<std::int32_t, kBusModules> measured_{};
};

TEST_F(Gate, LetsALegalMovePass) {
  move(0, Kind::rotate_forward, 32000, 3 * kSecond);
  EXPECT_EQ(check(), GateCheck::passed);
}

// [Env-2]
TEST_F(Gate, StopsWhatIsTooFast) {
  move(0, Kind::rotate_forward, 32000, 2 * kSecond);
  EXPECT_EQ(check(), GateCheck::slew);
  move(0, Kind::rotate_backward, 32000, 2 * kSecond);
  EXPECT_EQ(check(), GateCheck::passed) << "40 degrees the other way";
}

TEST_F(Gate, TakesALegThatIsALittleTooFarForOneThatGoesBack) {
  measured_[0] = 1200;
  move(0, Kind::rotate_forward, 1000, kSecond);
  EXPECT_EQ(check(), GateCheck::passed);
}

TEST_F(Gate, OutsideOperationalNothingMovesButThePanelDuringItsOwnMovement) {
  for (const State s : {State::idle, State::fatal_error, State::solve_errors}) {
    move(0, Kind::rotate_forward, 100, kSecond);
    EXPECT_EQ(check(s), GateCheck::state);
    orders_.module[0] = {.kind = Kind::motion_on, .serial = 8};
    EXPECT_EQ(check(s), GateCheck::state);
    orders_.module[0] = {};
    move(6, Kind::rotate_forward, 100, kSecond);
    EXPECT_EQ(check(s), GateCheck::state);
    EXPECT_EQ(check(s, kPanelMoving), s == State::idle ? GateCheck::passed : GateCheck::state);
    orders_.module[6] = {};
  }
}

TEST_F(Gate, TheSafeCommandPassesInEveryState) {
  EXPECT_TRUE(rc::check([](std::uint8_t state, std::uint8_t flags, std::uint32_t serial) {
    BusOrders safe;
    safe.module[3].serial = serial;
    make_safe(safe, kNow);
    for (const ModuleOrder& o : safe.module) RC_ASSERT(o.kind == Kind::emergency_stop);
    RC_ASSERT(safe.module[3].serial == serial + 1);
    RC_ASSERT(zebro::check(safe, {}, {}, {.state = static_cast<State>(state % 4), .flags = flags},
                           {130}, kNow) == GateCheck::passed);
  }));
}

}  // namespace
}  // namespace lss::zebro
