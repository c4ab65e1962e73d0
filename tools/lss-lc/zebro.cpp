#include "tools/lss-lc/zebro.h"

#include <fmt/format.h>

#include <array>
#include <bit>

#include "daemon/vehicles/zebro_modes.h"
#include "gnc/zebro/locomotion.h"

namespace lss::zebro {
namespace {

using lc::Contract;
using lc::ControllerState;
using lc::Event;
using lc::Happening;
using lc::Return;
using lc::StateProperty;
using lc::StepProperty;
using lc::Transition;
using S = const ControllerState&;
using T = const Transition&;

constexpr std::uint16_t kLegMask = (1u << kLegs) - 1;

bool enough_legs_without(unsigned isolated) {
  static const auto enough = [] {
    std::array<bool, 1u << kLegs> walks{};
    for (std::size_t i = 0; i < walks.size(); ++i)
      walks[i] = gnc::zebro::can_walk_without(static_cast<gnc::zebro::LegSet>(i));
    return walks;
  }();
  return isolated < enough.size() && enough[isolated];
}

Mode mode(S s) { return static_cast<Mode>(s.mode); }
Goal goal(S s) { return static_cast<Goal>(s.goal); }
bool idle(S s) { return s.state == State::idle; }
bool operational(S s) { return s.state == State::operational; }
bool fatal(S s) { return s.state == State::fatal_error; }
bool solving(S s) { return s.state == State::solve_errors; }
bool has(S s, std::uint8_t flags) { return (s.flags & flags) != 0; }
bool link(S s, lc::Link bit) { return (s.links & bit) != 0; }
bool in_service(S s, unsigned module) { return (s.isolated >> (module - 1) & 1u) == 0; }
bool contact(S s) { return s.silent == 0 && s.unheard == 0 && !link(s, lc::kPortClosed); }
bool may_start(S s) {
  return idle(s) && contact(s) && !link(s, lc::kObcSilent) && !has(s, kPanelOut | kPanelMoving);
}
bool one_of(Mode m, std::initializer_list<Mode> modes) {
  for (const Mode candidate : modes) {
    if (m == candidate) return true;
  }
  return false;
}
bool in_mode(S s, std::initializer_list<Mode> modes) {
  return operational(s) && one_of(mode(s), modes);
}
// A motion that ends by itself.
bool in_motion(S s) {
  return in_mode(s, {Mode::standing_up, Mode::finishing_step, Mode::lying_down, Mode::stowing});
}
bool holds_still(S s) {
  return in_mode(s, {Mode::holding, Mode::standing, Mode::lying, Mode::stowed, Mode::bridge});
}
bool confirmed(S s) { return has(s, kMotorsConfirmed); }
bool stops_motors(lc::ActionSet actions) {
  return (actions & (lc::kMotorsOff | lc::kEmergencyStop)) != 0;
}
bool same_mode(T t) {
  return t.result.next.state == t.before.state && t.result.next.mode == t.before.mode;
}
bool to(T t, Mode m) { return operational(t.result.next) && mode(t.result.next) == m; }
// Comes to rest with the motors off, at once or by motions that end by themselves.
bool stops(S s) {
  return idle(s) || (in_motion(s) && (goal(s) == Goal::idle || goal(s) == Goal::lie_idle));
}

constexpr lc::ActionSet kLegMotion =
    lc::ActionSet{kMotorsOn} | kStandUp | kWalk | kFinishStep | kLayDown | kStow | kMoveLeg;
constexpr lc::ActionSet kPanelMotion = lc::ActionSet{kPanelDeploy} | kPanelRetract;

// ---- states

constexpr std::array kStates = {
    StateProperty{"a mode runs exactly in Operational", "4.3.1",
                  [](const lc::Table&, S s) { return operational(s) == (s.mode != 0); }},
    StateProperty{"Operational has every link: port, OBC, all modules in service", "O-Int-2",
                  [](const lc::Table&, S s) {
                    return !operational(s) || (contact(s) && !link(s, lc::kObcSilent));
                  }},
    StateProperty{
        "a deployed or moving panel forbids operation", "Func-5",
        [](const lc::Table&, S s) { return !operational(s) || !has(s, kPanelOut | kPanelMoving); }},
    StateProperty{"the panel moves only in Idle, and is then not in", "Func-5",
                  [](const lc::Table&, S s) {
                    return !has(s, kPanelMoving) || (idle(s) && has(s, kPanelOut));
                  }},
    StateProperty{"authority is held only in Operational", "architecture",
                  [](const lc::Table&, S s) { return operational(s) || !link(s, lc::kHeld); }},
    StateProperty{"a chain of motions has a goal only in Operational", "4.3.1",
                  [](const lc::Table&, S s) { return operational(s) || goal(s) == Goal::none; }},
    StateProperty{"a strategy runs exactly in SolveErrors", "Conf-3",
                  [](const lc::Table&, S s) {
                    return solving(s) == (s.strategy != 0) && s.strategy <= lc::kMaxStrategies;
                  }},
    StateProperty{"only error solving moves a leg outside Operational", "Oper-7",
                  [](const lc::Table&, S s) { return solving(s) || !has(s, kFreeing); }},
    StateProperty{"legs move only after all motors were confirmed on", "4.3.1",
                  [](const lc::Table&, S s) {
                    return confirmed(s) ? operational(s)
                                        : !operational(s) || mode(s) == Mode::holding;
                  }},
    StateProperty{"a module is silent, never heard or isolated, not two of these", "P-Int-2",
                  [](const lc::Table&, S s) {
                    return (s.silent & s.unheard) == 0 && (s.silent & s.isolated) == 0 &&
                           (s.unheard & s.isolated) == 0;
                  }},
    StateProperty{"the legs that are left can stand and walk", "Conf-3",
                  [](const lc::Table&, S s) {
                    return (s.isolated & ~kLegMask) == 0 && enough_legs_without(s.isolated);
                  }},
    StateProperty{"what is at rest has no goal but its own", "4.3.1",
                  [](const lc::Table&, S s) {
                    return !in_mode(s,
                                    {Mode::standing, Mode::walking, Mode::lying, Mode::stowed}) ||
                           goal(s) == Goal::none;
                  }},
    StateProperty{"every motion has an end", "4.3.1",
                  [](const lc::Table& table, S s) {
                    return !in_motion(s) || lc::step(table, s, event::motion_done).row >= 0;
                  }},
};

// ---- steps that were taken

constexpr std::array kSteps = {
    StepProperty{"Operational is entered only from Idle, by start", "4.3.1", lc::kChange,
                 [](T t) {
                   const Event e = t.happening.event;
                   return operational(t.before) || !operational(t.result.next) ||
                          (idle(t.before) && (e == event::start || e == event::start_stand ||
                                              e == event::start_walk));
                 }},
    StepProperty{"FatalError is left only for SolveErrors, by solve", "Oper-6", lc::kChange,
                 [](T t) {
                   return !fatal(t.before) || fatal(t.result.next) ||
                          (solving(t.result.next) && t.happening.event == Event::solve);
                 }},
    StepProperty{"SolveErrors is left only for FatalError, or for Idle when all is well", "Oper-6",
                 lc::kChange,
                 [](T t) {
                   return !solving(t.before) || solving(t.result.next) || fatal(t.result.next) ||
                          (idle(t.result.next) && t.happening.event == Event::solved &&
                           contact(t.result.next));
                 }},
    StepProperty{
        "SolveErrors is entered only from FatalError", "4.3.1", lc::kChange,
        [](T t) { return !solving(t.result.next) || solving(t.before) || fatal(t.before); }},
    StepProperty{"into FatalError every module gets an emergency stop", "Oper-5", lc::kChange,
                 [](T t) {
                   return fatal(t.before) || !fatal(t.result.next) ||
                          (t.result.actions & lc::kEmergencyStop) != 0;
                 }},
    StepProperty{"leaving Operational stops the motors", "Oper-7", lc::kChange,
                 [](T t) {
                   return !operational(t.before) || operational(t.result.next) ||
                          stops_motors(t.result.actions);
                 }},
    StepProperty{"leaving SolveErrors stops the motors", "Oper-7", lc::kChange,
                 [](T t) {
                   return !solving(t.before) || solving(t.result.next) ||
                          (stops_motors(t.result.actions) &&
                           (t.result.actions & lc::kEndSolve) != 0);
                 }},
    StepProperty{
        "legs are commanded to move only in Operational", "4.3.1", lc::kActions,
        [](T t) { return (t.result.actions & kLegMotion) == 0 || operational(t.result.next); }},
    StepProperty{"a leg is moved free only in SolveErrors", "Conf-3", lc::kActions,
                 [](T t) {
                   return (t.result.actions & kFreeLeg) == 0 ||
                          (solving(t.before) && solving(t.result.next));
                 }},
    StepProperty{"the panel is commanded to move only in Idle", "Func-5", lc::kActions,
                 [](T t) {
                   return (t.result.actions & kPanelMotion) == 0 ||
                          (idle(t.before) && idle(t.result.next));
                 }},
    StepProperty{"motors are switched on only by start", "Oper-7", lc::kActions,
                 [](T t) {
                   return (t.result.actions & kMotorsOn) == 0 ||
                          (idle(t.before) && operational(t.result.next));
                 }},
    StepProperty{"walking follows standing up, standing or walking", "Func-3", lc::kChange,
                 [](T t) {
                   return !to(t, Mode::walking) ||
                          in_mode(t.before, {Mode::standing_up, Mode::standing, Mode::walking});
                 }},
    StepProperty{"a walk ends with its step finished, or in an emergency", "Func-2", lc::kChange,
                 [](T t) {
                   return !in_mode(t.before, {Mode::walking}) || to(t, Mode::walking) ||
                          to(t, Mode::finishing_step) ||
                          (t.result.actions & lc::kEmergencyStop) != 0;
                 }},
    StepProperty{"what begins a motion sets its algorithm going, and nothing else does", "Conf-2",
                 lc::kChange | lc::kActions,
                 [](T t) {
                   const auto begins = [&](Mode m, lc::ActionSet action) {
                     const bool now = to(t, m) && (!in_mode(t.before, {m}) || m == Mode::walking ||
                                                   m == Mode::bridge);
                     const bool set = (t.result.actions & action) != 0;
                     // Walking and bridging go on without a new order, too.
                     return set ? now : !now || in_mode(t.before, {m});
                   };
                   return begins(Mode::standing_up, kStandUp) && begins(Mode::walking, kWalk) &&
                          begins(Mode::finishing_step, kFinishStep) &&
                          begins(Mode::lying_down, kLayDown) && begins(Mode::stowing, kStow) &&
                          begins(Mode::bridge, kMoveLeg);
                 }},
    StepProperty{
        "links change by what is heard of them, only", "O-Int-2", lc::kLinks,
        [](T t) {
          const ControllerState &a = t.before, &b = t.result.next;
          const Event e = t.happening.event;
          const auto changed = [&](lc::Link bit) { return ((a.links ^ b.links) & bit) != 0; };
          if (changed(lc::kPortClosed) && e != Event::port_opened && e != Event::port_closed)
            return false;
          if (changed(lc::kObcSilent) && e != Event::obc_heard && e != Event::obc_silent)
            return false;
          const bool of_modules = e == Event::module_heard || e == Event::module_silent ||
                                  e == Event::restore || e == event::isolate;
          return of_modules || (a.silent == b.silent && a.unheard == b.unheard);
        }},
    StepProperty{"modules are isolated by error solving only, and restored by command only",
                 "Conf-3", lc::kLinks,
                 [](T t) {
                   const unsigned gone = t.before.isolated & ~t.result.next.isolated,
                                  more = t.result.next.isolated & ~t.before.isolated;
                   return (gone == 0 || t.happening.event == Event::restore) &&
                          (more == 0 || (t.happening.event == event::isolate && solving(t.before) &&
                                         more == 1u << (t.happening.subject - 1)));
                 }},
    StepProperty{"the panel's place changes by its own movement and what is seen of it, only",
                 "Func-5", lc::kLinks,
                 [](T t) {
                   const Event e = t.happening.event;
                   return ((t.before.flags ^ t.result.next.flags) & kPanelOut) == 0 ||
                          e == event::panel_deploy || e == event::panel_retract ||
                          e == event::panel_arrived_in || e == event::panel_arrived_out ||
                          e == event::panel_seen_out;
                 }},
    StepProperty{"faults are forgotten only when they are solved", "Oper-6", lc::kActions,
                 [](T t) {
                   return (t.result.actions & lc::kClearFaults) == 0 ||
                          (solving(t.before) && idle(t.result.next));
                 }},
    StepProperty{"authority is taken only by commands that move, and given back only on the way to "
                 "rest",
                 "architecture", lc::kLinks,
                 [](T t) {
                   const bool before = link(t.before, lc::kHeld),
                              after = link(t.result.next, lc::kHeld);
                   if (after && !before) return (t.result.actions & lc::kTakeAuthority) != 0;
                   if (before && !after) return !operational(t.result.next) || stops(t.result.next);
                   return true;
                 }},
};

// ---- contracts: when an event is taken, and where it leads

bool keeps(T t) { return t.result.next == t.before; }
bool emergency(T t) {
  return fatal(t.result.next) && (t.result.actions & lc::kEmergencyStop) != 0 &&
         !link(t.result.next, lc::kHeld);
}
bool lost_is_emergency(T t) { return operational(t.before) ? emergency(t) : same_mode(t); }
bool held_after(T t) { return link(t.result.next, lc::kHeld); }

constexpr std::array kContracts = {
    Contract{"emergency stop", Event::emergency_stop, [](S, unsigned) { return true; },
             [](T t) { return emergency(t) && (t.result.actions & lc::kEndSolve) != 0; }},
    Contract{"fatal fault", Event::emergency, [](S, unsigned) { return true; },
             [](T t) { return fatal(t.before) ? keeps(t) : emergency(t); }},
    Contract{"solve", Event::solve, [](S s, unsigned) { return fatal(s); },
             [](T t) {
               return solving(t.result.next) && (t.result.actions & lc::kBeginSolve) != 0 &&
                      t.result.next.strategy == 1;
             }},
    Contract{"next strategy", Event::next_strategy,
             [](S s, unsigned) { return solving(s) && s.strategy < lc::kMaxStrategies; },
             [](T t) {
               return solving(t.result.next) && t.result.next.strategy == t.before.strategy + 1 &&
                      !has(t.result.next, kFreeing) && stops_motors(t.result.actions);
             }},
    Contract{"solved", Event::solved, [](S s, unsigned) { return solving(s) && contact(s); },
             [](T t) { return idle(t.result.next) && (t.result.actions & lc::kClearFaults) != 0; }},
    Contract{"unsolved", Event::unsolved, [](S s, unsigned) { return solving(s); }, emergency},
    Contract{"reset of the controller", Event::reset_controller, [](S, unsigned) { return true; },
             [](T t) {
               const bool back = fatal(t.before) || solving(t.before);
               return (back ? emergency(t) : idle(t.result.next)) &&
                      stops_motors(t.result.actions) &&
                      (!operational(t.before) || (t.result.actions & lc::kEmergencyStop) != 0);
             }},
    Contract{"reset of a module", Event::reset_module,
             [](S s, unsigned) { return idle(s) || fatal(s); },
             [](T t) { return keeps(t) && (t.result.actions & lc::kResetModule) != 0; }},
    Contract{"restore", Event::restore, [](S s, unsigned) { return idle(s) || fatal(s); },
             [](T t) {
               return same_mode(t) && t.result.next.isolated == 0 &&
                      t.result.next.silent == (t.before.silent | t.before.isolated);
             }},
    Contract{"data", Event::request_data, [](S, unsigned) { return true; },
             [](T t) { return keeps(t) && (t.result.actions & lc::kPublishData) != 0; }},
    Contract{"reset of the timing", Event::reset_timing, [](S, unsigned) { return true; }, keeps},
    Contract{"module heard", Event::module_heard,
             [](S s, unsigned module) { return in_service(s, module); },
             [](T t) {
               const unsigned bit = 1u << (t.happening.subject - 1);
               return same_mode(t) && t.result.next.silent == (t.before.silent & ~bit) &&
                      t.result.next.unheard == (t.before.unheard & ~bit);
             }},
    Contract{"module silent", Event::module_silent,
             [](S s, unsigned module) { return in_service(s, module); },
             [](T t) {
               const unsigned bit = 1u << (t.happening.subject - 1);
               const bool moves = operational(t.before) || idle(t.before);
               return t.result.next.silent == (t.before.silent | bit) &&
                      (moves ? emergency(t) : same_mode(t));
             }},
    Contract{"port opened", Event::port_opened, [](S, unsigned) { return true; },
             [](T t) { return same_mode(t) && !link(t.result.next, lc::kPortClosed); }},
    Contract{"port closed", Event::port_closed, [](S, unsigned) { return true; },
             [](T t) { return lost_is_emergency(t) && link(t.result.next, lc::kPortClosed); }},
    Contract{"OBC heard", Event::obc_heard, [](S, unsigned) { return true; },
             [](T t) { return same_mode(t) && !link(t.result.next, lc::kObcSilent); }},
    Contract{"OBC silent", Event::obc_silent, [](S, unsigned) { return true; },
             [](T t) { return lost_is_emergency(t) && link(t.result.next, lc::kObcSilent); }},
    Contract{"lease expired", Event::lease_expired,
             [](S s, unsigned) { return link(s, lc::kHeld); },
             [](T t) {
               // From its feet it lies down before the motors go off.
               const bool up = in_mode(t.before, {Mode::standing_up, Mode::standing, Mode::bridge});
               const bool walks = in_mode(t.before, {Mode::walking, Mode::finishing_step});
               return stops(t.result.next) && !link(t.result.next, lc::kHeld) &&
                      (!up || to(t, Mode::lying_down)) &&
                      (!walks || goal(t.result.next) == Goal::lie_idle);
             }},

    Contract{"start", event::start, [](S s, unsigned) { return may_start(s); },
             [](T t) {
               return to(t, Mode::holding) && goal(t.result.next) == Goal::none && held_after(t) &&
                      (t.result.actions & kMotorsOn) != 0;
             }},
    Contract{"start, then stand", event::start_stand, [](S s, unsigned) { return may_start(s); },
             [](T t) {
               return to(t, Mode::holding) && goal(t.result.next) == Goal::stand && held_after(t) &&
                      (t.result.actions & kMotorsOn) != 0;
             }},
    Contract{"start, then walk", event::start_walk, [](S s, unsigned) { return may_start(s); },
             [](T t) {
               return to(t, Mode::holding) && goal(t.result.next) == Goal::walk && held_after(t) &&
                      (t.result.actions & kMotorsOn) != 0;
             }},
    Contract{"stop", event::stop, [](S s, unsigned) { return idle(s) || operational(s); },
             [](T t) {
               return idle(t.before) ? keeps(t)
                      : holds_still(t.before)
                          ? idle(t.result.next)
                          : stops(t.result.next) && goal(t.result.next) == Goal::idle;
             }},
    Contract{"stop lying down", event::stop_lay_down,
             [](S s, unsigned) { return idle(s) || operational(s); },
             [](T t) {
               if (idle(t.before)) return keeps(t);
               if (in_mode(t.before, {Mode::holding, Mode::lying, Mode::stowed}))
                 return idle(t.result.next);
               if (in_mode(t.before, {Mode::standing_up, Mode::standing, Mode::bridge}))
                 return to(t, Mode::lying_down) && goal(t.result.next) == Goal::idle;
               return stops(t.result.next) &&
                      (in_mode(t.before, {Mode::walking, Mode::finishing_step})
                           ? goal(t.result.next) == Goal::lie_idle
                           : same_mode(t) && goal(t.result.next) == Goal::idle);
             }},
    Contract{"stand", event::stand,
             [](S s, unsigned) {
               return operational(s) && !in_mode(s, {Mode::lying_down, Mode::stowing}) &&
                      (mode(s) != Mode::holding || confirmed(s));
             },
             [](T t) {
               const bool walks = in_mode(t.before, {Mode::walking, Mode::finishing_step});
               if (in_mode(t.before, {Mode::standing})) return same_mode(t) && held_after(t);
               return held_after(t) && goal(t.result.next) == Goal::stand &&
                      to(t, walks ? Mode::finishing_step : Mode::standing_up);
             }},
    Contract{"walk", event::walk,
             [](S s, unsigned) {
               return in_mode(s, {Mode::standing, Mode::walking});
             },
             [](T t) {
               return to(t, Mode::walking) && held_after(t) && (t.result.actions & kWalk) != 0;
             }},
    Contract{"walk at speed zero", event::walk_zero,
             [](S s, unsigned) {
               return in_mode(s, {Mode::standing, Mode::walking, Mode::finishing_step});
             },
             [](T t) {
               return held_after(t) &&
                      (in_mode(t.before, {Mode::walking})
                           ? to(t, Mode::finishing_step) && goal(t.result.next) == Goal::stand
                           : same_mode(t) && t.result.next.goal == t.before.goal);
             }},
    Contract{"lay down", event::lay_down,
             [](S s, unsigned) {
               return operational(s) && !in_mode(s, {Mode::standing_up, Mode::stowing}) &&
                      (mode(s) != Mode::holding || confirmed(s));
             },
             [](T t) {
               if (!held_after(t)) return false;
               if (in_mode(t.before, {Mode::lying})) return same_mode(t);
               return in_mode(t.before, {Mode::walking, Mode::finishing_step})
                          ? to(t, Mode::finishing_step) && goal(t.result.next) == Goal::lie
                          : to(t, Mode::lying_down) && goal(t.result.next) == Goal::none;
             }},
    Contract{"stow", event::stow,
             [](S s, unsigned) {
               return operational(s) && !in_mode(s, {Mode::standing_up, Mode::lying_down}) &&
                      (mode(s) != Mode::holding || confirmed(s));
             },
             [](T t) {
               if (!held_after(t)) return false;
               if (in_mode(t.before, {Mode::stowed})) return same_mode(t);
               return in_mode(t.before, {Mode::walking, Mode::finishing_step})
                          ? to(t, Mode::finishing_step) && goal(t.result.next) == Goal::stow
                          : to(t, Mode::stowing) && goal(t.result.next) == Goal::none;
             }},
    Contract{"leg", event::leg,
             [](S s, unsigned leg) { return holds_still(s) && in_service(s, leg) && confirmed(s); },
             [](T t) {
               return to(t, Mode::bridge) && goal(t.result.next) == Goal::leg && held_after(t) &&
                      (t.result.actions & kMoveLeg) != 0;
             }},
    Contract{"deploy the panel", event::panel_deploy,
             [](S s, unsigned) { return idle(s) && contact(s) && !has(s, kPanelMoving); },
             [](T t) {
               return same_mode(t) && has(t.result.next, kPanelMoving) &&
                      (t.result.actions & kPanelMotion) == kPanelDeploy;
             }},
    Contract{"retract the panel", event::panel_retract,
             [](S s, unsigned) { return idle(s) && contact(s) && !has(s, kPanelMoving); },
             [](T t) {
               return same_mode(t) && has(t.result.next, kPanelMoving) &&
                      (t.result.actions & kPanelMotion) == kPanelRetract;
             }},
    Contract{"panel arrived in", event::panel_arrived_in, [](S s, unsigned) { return idle(s); },
             [](T t) { return same_mode(t) && !has(t.result.next, kPanelOut | kPanelMoving); }},
    Contract{"panel arrived out", event::panel_arrived_out, [](S s, unsigned) { return idle(s); },
             [](T t) {
               return same_mode(t) && has(t.result.next, kPanelOut) &&
                      !has(t.result.next, kPanelMoving);
             }},
    Contract{"panel seen out", event::panel_seen_out, [](S s, unsigned) { return idle(s); },
             [](T t) {
               return same_mode(t) && has(t.result.next, kPanelOut) &&
                      !has(t.result.next, kPanelMoving);
             }},

    Contract{"motors confirmed", event::motors_confirmed,
             [](S s, unsigned) { return in_mode(s, {Mode::holding}); },
             [](T t) {
               const bool goes_on = goal(t.before) == Goal::stand || goal(t.before) == Goal::walk;
               return confirmed(t.result.next) && t.result.next.goal == t.before.goal &&
                      to(t, goes_on ? Mode::standing_up : Mode::holding);
             }},
    Contract{"motion done", event::motion_done,
             [](S s, unsigned) {
               return in_motion(s) || (in_mode(s, {Mode::bridge}) && goal(s) == Goal::leg);
             },
             [](T t) {
               const Goal was = goal(t.before), is = goal(t.result.next);
               switch (mode(t.before)) {
                 case Mode::standing_up:
                   if (was == Goal::walk) return to(t, Mode::walking) && is == Goal::none;
                   if (was == Goal::idle) return idle(t.result.next);
                   return to(t, Mode::standing) && is == Goal::none;
                 case Mode::finishing_step:
                   if (was == Goal::idle) return idle(t.result.next);
                   if (was == Goal::lie) return to(t, Mode::lying_down) && is == Goal::none;
                   if (was == Goal::lie_idle) return to(t, Mode::lying_down) && is == Goal::idle;
                   if (was == Goal::stow) return to(t, Mode::stowing) && is == Goal::none;
                   return to(t, Mode::standing) && is == Goal::none;
                 case Mode::lying_down:
                   return was == Goal::idle ? idle(t.result.next)
                                            : to(t, Mode::lying) && is == Goal::none;
                 case Mode::stowing:
                   return was == Goal::idle ? idle(t.result.next)
                                            : to(t, Mode::stowed) && is == Goal::none;
                 default:
                   return to(t, Mode::bridge) && is == Goal::none;
               }
             }},

    Contract{"a leg may be moved free", event::free_leg,
             [](S s, unsigned leg) {
               return solving(s) && in_service(s, leg) && !link(s, lc::kPortClosed);
             },
             [](T t) { return same_mode(t) && has(t.result.next, kFreeing); }},
    Contract{"a leg was moved free", event::leg_freed, [](S s, unsigned) { return solving(s); },
             [](T t) {
               return same_mode(t) && !has(t.result.next, kFreeing) &&
                      stops_motors(t.result.actions);
             }},
    Contract{"isolate", event::isolate,
             [](S s, unsigned leg) {
               return solving(s) && in_service(s, leg) && leg <= kLegs &&
                      enough_legs_without(s.isolated | 1u << (leg - 1));
             },
             [](T t) {
               return same_mode(t) && !in_service(t.result.next, t.happening.subject) &&
                      stops_motors(t.result.actions);
             }},
};

// ---- the way back

Happening help(S s) {
  if (link(s, lc::kPortClosed)) return {Event::port_opened, 0};
  const auto lost = static_cast<std::uint16_t>(s.silent | s.unheard);
  if (!operational(s) && lost != 0)
    return {Event::module_heard, static_cast<std::uint8_t>(std::countr_zero(lost) + 1)};
  if (fatal(s)) return {Event::solve, 0};
  if (solving(s)) return {Event::solved, 0};
  if (in_motion(s) && stops(s)) return {event::motion_done, 0};
  return {event::stop, 0};
}

constexpr std::array kReturns = {
    Return{"from every state it comes back to Idle when the world helps",
           [](S s) { return idle(s); }, help},
};

}  // namespace

lc::Model model_of(const lc::Table& table, std::uint16_t modules) {
  lc::Model m = lc::model(table, modules);
  m.states = kStates;
  m.steps = kSteps;
  m.contracts = kContracts;
  m.returns = kReturns;
  return m;
}

std::string text(const ControllerState& s) {
  static constexpr const char* kGoals[] = {"none", "stand", "walk",     "lie",
                                           "stow", "idle",  "lie_idle", "leg"};
  std::string text = kStateNames[static_cast<std::size_t>(s.state)];
  if (s.mode != 0) text += fmt::format(" {}", kModeNames[s.mode]);
  if (s.goal != 0) text += fmt::format(", goal {}", kGoals[s.goal]);
  if (s.strategy != 0) text += fmt::format(", strategy {}", s.strategy);
  const auto say = [&](bool holds, const char* what) {
    if (holds) text += fmt::format(", {}", what);
  };
  say(has(s, kPanelMoving), "panel moves");
  say(has(s, kPanelOut) && !has(s, kPanelMoving), "panel out");
  say(confirmed(s), "motors confirmed");
  say(has(s, kFreeing), "leg is freed");
  say(link(s, lc::kPortClosed), "port closed");
  say(link(s, lc::kObcSilent), "OBC silent");
  say(link(s, lc::kHeld), "held");
  for (std::size_t i = 0; i < kModules; ++i) {
    const auto is = [&](std::uint16_t set) { return (unsigned{set} >> i & 1u) != 0; };
    if (is(s.silent)) text += fmt::format(", {} silent", kModuleNames[i]);
    if (is(s.unheard)) text += fmt::format(", {} never heard", kModuleNames[i]);
    if (is(s.isolated)) text += fmt::format(", {} isolated", kModuleNames[i]);
  }
  return text;
}

std::string text(const lc::Table& table, Happening happening) {
  for (const std::span<const lc::EventInfo> events : {lc::kCommonEvents, table.events}) {
    for (const lc::EventInfo& e : events) {
      if (e.event != happening.event) continue;
      return happening.subject == 0
                 ? e.name
                 : fmt::format("{} {}", e.name, kModuleNames[happening.subject - 1]);
    }
  }
  return "?";
}

}  // namespace lss::zebro
