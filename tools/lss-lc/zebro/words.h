#pragma once

// The vocabulary of Lunar Zebro's properties and contracts. Included by those only.

#include <array>
#include <span>

#include "daemon/vehicles/zebro/modes.h"
#include "gnc/zebro/locomotion.h"
#include "tools/lss-lc/common.h"

namespace lss::zebro {

std::span<const lc::Contract> contracts();

namespace words {

using namespace lc::common;

inline constexpr std::uint16_t kAllModules = (1u << kModules) - 1;
inline constexpr std::uint16_t kLegMask = (1u << kLegs) - 1;

inline bool others_can_walk(unsigned isolated) {
  static const auto enough = [] {
    std::array<bool, 1u << kLegs> walks{};
    for (std::size_t i = 0; i < walks.size(); ++i)
      walks[i] = gnc::zebro::can_walk_without(static_cast<gnc::zebro::LegSet>(i));
    return walks;
  }();
  return isolated < enough.size() && enough[isolated];
}

inline Mode mode(S s) { return static_cast<Mode>(s.mode); }
inline Goal goal(S s) { return static_cast<Goal>(s.goal); }
inline bool may_start(S s) { return can_start(s) && !has(s, kPanelOut | kPanelMoving); }
inline bool panel_ready(S s) {
  return idle(s) && contact(s) && !has(s, kPanelMoving) && in_service(s, kModules);
}
// The panel stops where it is, and nothing else changes.
inline bool panel_stopped(T t) {
  ControllerState stopped = t.before;
  stopped.flags = static_cast<std::uint8_t>(stopped.flags & ~kPanelMoving);
  return t.result.next == stopped && starts_nothing_but(t, lc::ActionSet{kPanelStop});
}
inline bool lost_module(S s, unsigned module) {
  return ((s.silent | s.unheard) >> (module - 1) & 1u) != 0;
}
// A motion that ends by itself.
inline bool in_motion(S s) {
  return in_mode(s, {Mode::standing_up, Mode::finishing_step, Mode::lying_down, Mode::stowing});
}
inline bool holds_still(S s) {
  return in_mode(s, {Mode::holding, Mode::standing, Mode::lying, Mode::stowed, Mode::bridge});
}
inline bool confirmed(S s) { return has(s, kMotorsConfirmed); }
// Comes to standstill with the motors off, at once or by motions that end by themselves.
inline bool stops(S s) {
  return idle(s) || (in_motion(s) && (goal(s) == Goal::idle || goal(s) == Goal::lie_idle));
}

// Where it comes to rest when nothing else happens.
enum class End : std::uint8_t {
  off,
  lying_off,
  holding,
  standing,
  walking,
  lying,
  stowed,
  bridging
};
inline End end_of(Goal g, End otherwise) {
  switch (g) {
    case Goal::stand: return End::standing;
    case Goal::walk: return End::walking;
    case Goal::lie: return End::lying;
    case Goal::stow: return End::stowed;
    case Goal::idle: return End::off;
    case Goal::lie_idle: return End::lying_off;
    case Goal::none:
    case Goal::leg: break;
  }
  return otherwise;
}
inline End end_of(S s) {
  if (!operational(s)) return End::off;
  switch (static_cast<Mode>(s.mode)) {
    case Mode::holding: return end_of(goal(s), End::holding);
    case Mode::lying_down: return goal(s) == Goal::idle ? End::lying_off : End::lying;
    case Mode::lying: return End::lying;
    case Mode::stowing: return goal(s) == Goal::idle ? End::lying_off : End::stowed;
    case Mode::stowed: return End::stowed;
    case Mode::walking: return End::walking;
    case Mode::bridge: return End::bridging;
    default: return end_of(goal(s), End::standing);
  }
}
// The one that a command names.
inline End end_of(Event e) {
  if (one_of(e, {event::start_walk, event::walk})) return End::walking;
  if (one_of(e, {event::start_stand, event::stand, event::walk_zero})) return End::standing;
  if (e == event::lay_down) return End::lying;
  if (e == event::stow) return End::stowed;
  if (e == event::leg) return End::bridging;
  return e == event::start ? End::holding : End::off;
}
// Its belly carries it: it needs not lie down.
inline bool lies(S s) {
  return in_mode(s, {Mode::holding, Mode::lying_down, Mode::lying, Mode::stowing, Mode::stowed});
}

inline constexpr lc::ActionSet kLegMotion =
    lc::ActionSet{kMotorsOn} | kStandUp | kWalk | kFinishStep | kLayDown | kStow | kMoveLeg;
inline constexpr lc::ActionSet kPanelMotion = lc::ActionSet{kPanelDeploy} | kPanelRetract;

}  // namespace words
}  // namespace lss::zebro
