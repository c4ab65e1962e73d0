#include <gtest/gtest.h>
#include <rapidcheck.h>

#include "daemon/vehicles/zebro_modes.h"

namespace lss::zebro {
namespace {

constexpr unsigned kEvents = lc::kVehicleEvents + 19;

using lc::ControllerState;

// Walks a random path of events; `check(before, event, result)` looks at every step.
template <class Check>
bool on_every_path(Check check) {
  return rc::check([&](const std::vector<std::uint8_t>& path, std::uint16_t masks) {
    ControllerState s{};
    for (const std::uint8_t step : path) {
      const auto event = static_cast<lc::Event>(step % kEvents);
      if (step > 240) {  // contact comes and goes
        s.silent = masks & 0x7F;
        s.unheard = masks >> 8 & 0x7F;
        continue;
      }
      if (step > 230) s.silent = s.unheard = 0;
      const lc::Result r = lc::step(kTable, s, event);
      check(s, event, r);
      s = r.next;
    }
  });
}

TEST(ZebroModes, AModeIsRunningExactlyInOperational) {
  EXPECT_TRUE(on_every_path([](const ControllerState&, lc::Event, const lc::Result& r) {
    RC_ASSERT((r.next.state == State::operational) == (r.next.mode != 0));
  }));
}

TEST(ZebroModes, OperationalIsEnteredOnlyFromIdleWithContactToAllAndThePanelIn) {
  EXPECT_TRUE(on_every_path([](const ControllerState& before, lc::Event, const lc::Result& r) {
    if (r.next.state != State::operational || before.state == State::operational) return;
    RC_ASSERT(before.state == State::idle);
    RC_ASSERT(before.silent == 0 && before.unheard == 0);
    RC_ASSERT((before.flags & (kPanelOut | kPanelMoving | kPortClosed)) == 0);
  }));
}

TEST(ZebroModes, ADeployedPanelForbidsOperation_Func_5) {
  EXPECT_TRUE(on_every_path([](const ControllerState&, lc::Event, const lc::Result& r) {
    RC_ASSERT(r.next.state != State::operational || (r.next.flags & kPanelOut) == 0);
  }));
}

TEST(ZebroModes, WalkingFollowsOnlyStanding) {
  EXPECT_TRUE(on_every_path([](const ControllerState& before, lc::Event, const lc::Result& r) {
    if (static_cast<Mode>(r.next.mode) != Mode::walking) return;
    const auto from = static_cast<Mode>(before.mode);
    RC_ASSERT(from == Mode::walking || from == Mode::standing || from == Mode::standing_up);
  }));
}

TEST(ZebroModes, LeavingOperationalSwitchesTheMotorsOff) {
  EXPECT_TRUE(on_every_path([](const ControllerState& before, lc::Event, const lc::Result& r) {
    if (before.state == State::operational && r.next.state != State::operational) {
      RC_ASSERT((r.actions & (lc::kMotorsOff | lc::kEmergencyStop)) != 0);
    }
  }));
}

TEST(ZebroModes, EveryMotionEndsInAModeAtRestOrInIdle) {
  for (unsigned goal = 0; goal < 8; ++goal) {
    for (const Mode m :
         {Mode::standing_up, Mode::finishing_step, Mode::lying_down, Mode::stowing}) {
      ControllerState s{.state = State::operational,
                        .mode = static_cast<std::uint8_t>(m),
                        .goal = static_cast<std::uint8_t>(goal),
                        .flags = kMotorsConfirmed};
      for (int i = 0; i < 4 && s.state == State::operational; ++i)
        s = lc::step(kTable, s, event::motion_done).next;
      const auto end = static_cast<Mode>(s.mode);
      // Combinations that no path makes stay where they are; those that are made must not be stuck.
      if (end == m) continue;
      EXPECT_TRUE(end == Mode::standing || end == Mode::walking || end == Mode::lying ||
                  end == Mode::stowed || end == Mode::none)
          << kModeNames[static_cast<int>(m)] << " goal " << goal;
    }
  }
}

TEST(ZebroModes, NoReachableMotionIsWithoutAnEnd) {
  EXPECT_TRUE(on_every_path([](const ControllerState&, lc::Event, const lc::Result& r) {
    const auto m = static_cast<Mode>(r.next.mode);
    if (m != Mode::standing_up && m != Mode::finishing_step && m != Mode::lying_down &&
        m != Mode::stowing)
      return;
    RC_ASSERT(lc::step(kTable, r.next, event::motion_done).row >= 0);
  }));
}

}  // namespace
}  // namespace lss::zebro
