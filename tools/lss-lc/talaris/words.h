#pragma once

// The vocabulary of TALARIS' properties and contracts. Included by the files of this library only.

#include <initializer_list>
#include <span>

#include "daemon/vehicles/talaris/modes.h"
#include "tools/lss-lc/common.h"

namespace lss::talaris {

std::span<const lc::Contract> contracts();

namespace words {

using namespace lc::common;
inline Goal goal(S s) { return static_cast<Goal>(s.goal); }
inline bool by_hand(S s) { return in_mode(s, {Mode::manual, Mode::duty_cycle}); }
inline bool gnc(S s) { return in_mode(s, {Mode::standby, Mode::calibrate, Mode::execute}); }
inline bool in_air(S s) { return goal(s) != Goal::none; }
// All of these.
inline bool does(T t, lc::ActionSet all) { return (t.result.actions & all) == all; }
// Done for the requesting source, which has authority from now on.
inline bool takes(T t, lc::ActionSet all) {
  return does(t, all | lc::kTakeAuthority) && held_after(t);
}
inline bool enters(T t, Mode m) { return to(t, m) && !in_mode(t.before, m); }
// Equal except for these flags, which are now on and off.
inline bool only_flags(T t, unsigned on, unsigned off) {
  ControllerState wanted = t.before;
  wanted.flags = static_cast<std::uint8_t>((wanted.flags & ~off) | on);
  return t.result.next == wanted;
}
inline bool takes_none(const lc::Table& table, S s, std::initializer_list<Event> events) {
  for (const Event e : events) {
    if (lc::step(table, s, e).row >= 0) return false;
  }
  return true;
}
// It continues the flight, to this end.
inline bool aims(T t, Goal wanted) {
  return same_mode(t) && goal(t.result.next) == wanted && does(t, kLand) &&
         t.result.next.flags == t.before.flags;
}
// In the air it lands first; on the ground it ends at once.
inline bool comes_to_rest(T t) {
  return in_air(t.before) ? aims(t, Goal::idle) : idle(t.result.next) && does(t, lc::kMotorsOff);
}

}  // namespace words
}  // namespace lss::talaris
