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

inline constexpr lc::ActionSet kLegMotion =
    lc::ActionSet{kMotorsOn} | kStandUp | kWalk | kFinishStep | kLayDown | kStow | kMoveLeg;
inline constexpr lc::ActionSet kPanelMotion = lc::ActionSet{kPanelDeploy} | kPanelRetract;

}  // namespace words
}  // namespace lss::zebro
