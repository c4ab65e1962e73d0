#pragma once

// The vocabulary of Lunar Zebro's properties and contracts. Included by those only.

#include <array>
#include <initializer_list>

#include "daemon/vehicles/zebro/modes.h"
#include "gnc/zebro/locomotion.h"
#include "tools/lss-lc/common.h"
#include "tools/lss-lc/zebro/system.h"

namespace lss::zebro::words {

using lc::Contract;
using lc::ControllerState;
using lc::Event;
using lc::Happening;
using lc::Return;
using lc::StateProperty;
using lc::StepProperty;
using lc::Transition;
using lc::common::contact;
using lc::common::emergency;
using lc::common::fatal;
using lc::common::has;
using lc::common::held_after;
using lc::common::idle;
using lc::common::in_service;
using lc::common::keeps;
using lc::common::link;
using lc::common::operational;
using lc::common::S;
using lc::common::same_mode;
using lc::common::solving;
using lc::common::stops_motors;
using lc::common::T;

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
inline bool may_start(S s) {
  return idle(s) && contact(s) && !link(s, lc::kObcSilent) && !has(s, kPanelOut | kPanelMoving);
}
inline bool panel_ready(S s) {
  return idle(s) && contact(s) && !has(s, kPanelMoving) && in_service(s, kModules);
}
inline bool one_of(Mode m, std::initializer_list<Mode> modes) {
  for (const Mode candidate : modes) {
    if (m == candidate) return true;
  }
  return false;
}
inline bool in_mode(S s, std::initializer_list<Mode> modes) {
  return operational(s) && one_of(mode(s), modes);
}
// A motion that ends by itself.
inline bool in_motion(S s) {
  return in_mode(s, {Mode::standing_up, Mode::finishing_step, Mode::lying_down, Mode::stowing});
}
inline bool holds_still(S s) {
  return in_mode(s, {Mode::holding, Mode::standing, Mode::lying, Mode::stowed, Mode::bridge});
}
inline bool confirmed(S s) { return has(s, kMotorsConfirmed); }
inline bool to(T t, Mode m) { return operational(t.result.next) && mode(t.result.next) == m; }
// Comes to standstill with the motors off, at once or by motions that end by themselves.
inline bool stops(S s) {
  return idle(s) || (in_motion(s) && (goal(s) == Goal::idle || goal(s) == Goal::lie_idle));
}

inline constexpr lc::ActionSet kLegMotion =
    lc::ActionSet{kMotorsOn} | kStandUp | kWalk | kFinishStep | kLayDown | kStow | kMoveLeg;
inline constexpr lc::ActionSet kPanelMotion = lc::ActionSet{kPanelDeploy} | kPanelRetract;

}  // namespace lss::zebro::words
