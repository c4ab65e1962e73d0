// When each event is accepted, and its result.

#include <array>

#include "tools/lss-lc/zebro/words.h"

namespace lss::zebro {
namespace {

using namespace words;

template <Goal kGoal>
constexpr Contract starts(const char* name, lc::Event event) {
  return {name, event, [](S s, unsigned) { return may_start(s); },
          [](T t) {
            return to(t, Mode::holding) && goal(t.result.next) == kGoal && held_after(t) &&
                   does(t, kMotorsOn);
          }};
}

// To lie or to be stowed; not while it moves the other way.
template <Mode kOther, Mode kDone, Mode kMoving, Goal kGoal>
constexpr Contract to_the_ground(const char* name, lc::Event event) {
  return {name, event,
          [](S s, unsigned) {
            return operational(s) && !in_mode(s, {Mode::standing_up, kOther}) &&
                   (mode(s) != Mode::holding || confirmed(s));
          },
          [](T t) {
            if (!held_after(t)) return false;
            if (in_mode(t.before, {kDone})) return same_mode(t);
            return in_mode(t.before, {Mode::walking, Mode::finishing_step})
                       ? to(t, Mode::finishing_step) && goal(t.result.next) == kGoal
                       : to(t, kMoving) && goal(t.result.next) == Goal::none;
          }};
}

constexpr std::array kOwnContracts = {
    next_strategy_contract<[](T t) { return next_strategy(t) && !has(t.result.next, kFreeing); }>(),
    lease_expired_contract<[](T t) {
      // When it stands, it lies down before the motors go off.
      const bool up = in_mode(t.before, {Mode::standing_up, Mode::standing, Mode::bridge});
      const bool walks = in_mode(t.before, {Mode::walking, Mode::finishing_step});
      return stops(t.result.next) && (!up || to(t, Mode::lying_down)) &&
             (!walks || goal(t.result.next) == Goal::lie_idle);
    }>(),

    starts<Goal::none>("start", event::start),
    starts<Goal::stand>("start, then stand", event::start_stand),
    starts<Goal::walk>("start, then walk", event::start_walk),
    Contract{"stop", event::stop, [](S s, unsigned) { return !fatal(s); },
             [](T t) {
               if (solving(t.before)) return breaks_off(t);
               return idle(t.before) ? panel_stopped(t)
                      : holds_still(t.before)
                          ? idle(t.result.next)
                          : stops(t.result.next) && goal(t.result.next) == Goal::idle;
             }},
    Contract{"stop lying down", event::stop_lay_down, [](S s, unsigned) { return !fatal(s); },
             [](T t) {
               if (solving(t.before)) return breaks_off(t);
               if (idle(t.before)) return panel_stopped(t);
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
             [](T t) { return to(t, Mode::walking) && held_after(t) && does(t, kWalk); }},
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
    to_the_ground<Mode::stowing, Mode::lying, Mode::lying_down, Goal::lie>("lay down",
                                                                           event::lay_down),
    to_the_ground<Mode::lying_down, Mode::stowed, Mode::stowing, Goal::stow>("stow", event::stow),
    Contract{"leg", event::leg, [](S s, unsigned) { return holds_still(s) && confirmed(s); },
             [](T t) {
               return to(t, Mode::bridge) && goal(t.result.next) == Goal::leg && held_after(t) &&
                      does(t, kMoveLeg);
             }},
    Contract{"deploy the panel", event::panel_deploy, [](S s, unsigned) { return panel_ready(s); },
             [](T t) {
               return same_mode(t) && has(t.result.next, kPanelMoving) &&
                      (t.result.actions & kPanelMotion) == kPanelDeploy;
             }},
    Contract{"retract the panel", event::panel_retract,
             [](S s, unsigned) { return panel_ready(s); },
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
    Contract{"panel seen out", event::panel_seen_out, always,
             [](T t) {
               return (operational(t.before) ? emergency(t) : same_mode(t)) &&
                      has(t.result.next, kPanelOut) && !has(t.result.next, kPanelMoving);
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
                 default: return to(t, Mode::bridge) && is == Goal::none;
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
                      others_can_walk((s.isolated & kLegMask) | 1u << (leg - 1));
             },
             leaves_service},
    Contract{"isolate by command", event::isolate_leg,
             [](S s, unsigned leg) {
               return (idle(s) || fatal(s)) && in_service(s, leg) &&
                      others_can_walk((s.isolated & kLegMask) | 1u << (leg - 1));
             },
             [](T t) {
               return same_mode(t) && !in_service(t.result.next, t.happening.subject) &&
                      in_service(t.before, t.happening.subject);
             }},
    Contract{"restore a module", event::restore_leg,
             [](S s, unsigned) { return idle(s) || fatal(s); },
             [](T t) {
               const unsigned module = 1u << (t.happening.subject - 1);
               return same_mode(t) && t.result.next.isolated == (t.before.isolated & ~module) &&
                      t.result.next.silent == (t.before.silent | (t.before.isolated & module)) &&
                      does(t, lc::kRestore);
             }},
    Contract{"the operator answers for the panel", event::panel_is_in,
             [](S s, unsigned) {
               return (idle(s) || fatal(s)) &&
                      ((s.silent | s.unheard) & (kAllModules & ~kLegMask)) != 0;
             },
             [](T t) {
               return same_mode(t) && !in_service(t.result.next, kModules) &&
                      !has(t.result.next, kPanelOut | kPanelMoving);
             }},
};
constexpr auto kContracts = lc::join(lc::common::kContracts, kOwnContracts);

}  // namespace

std::span<const lc::Contract> contracts() { return kContracts; }

}  // namespace lss::zebro
