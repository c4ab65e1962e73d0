// What must hold of every state and every step, and the way back to Idle.

#include <array>
#include <bit>

#include "tools/lss-lc/zebro_words.h"

namespace lss::zebro {
namespace {

using namespace words;

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
                    return (s.isolated & ~kLegMask) == 0 && others_can_walk(s.isolated);
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
  m.states = lc::state_properties<kStates>();
  m.steps = lc::step_properties<kSteps>();
  m.contracts = contracts();
  m.returns = kReturns;
  return m;
}

}  // namespace lss::zebro
