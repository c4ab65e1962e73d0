// Properties of every state and every step, and the way back to Idle.

#include <array>
#include <bit>

#include "tools/lss-lc/zebro/words.h"

namespace lss::zebro {
namespace {

using namespace words;

// ---- states

constexpr std::array kOwnStates = {
    StateProperty{
        "a deployed or moving panel forbids operation", "Func-5",
        [](const lc::Table&, S s) { return !operational(s) || !has(s, kPanelOut | kPanelMoving); }},
    StateProperty{"the panel moves only in Idle, and is then not in", "Func-5",
                  [](const lc::Table&, S s) {
                    return !has(s, kPanelMoving) || (idle(s) && has(s, kPanelOut));
                  }},
    StateProperty{"only error solving moves a leg outside Operational", "Oper-7",
                  [](const lc::Table&, S s) { return solving(s) || !has(s, kFreeing); }},
    StateProperty{"legs move only after all motors were confirmed on", "4.3.1",
                  [](const lc::Table&, S s) {
                    return confirmed(s) ? operational(s)
                                        : !operational(s) || mode(s) == Mode::holding;
                  }},
    StateProperty{"the legs that are left can stand and walk", "Conf-3",
                  [](const lc::Table&, S s) { return others_can_walk(s.isolated & kLegMask); }},
    StateProperty{
        "a panel whose module is out of service is in", "Func-5",
        [](const lc::Table&, S s) { return in_service(s, kModules) || !has(s, kPanelMoving); }},
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
constexpr auto kStates = lc::join(lc::common::kStates, kOwnStates);

// ---- steps that were taken

constexpr std::array kOwnSteps = {
    StepProperty{"Operational is entered only from Idle, by start", "4.3.1", lc::kChange,
                 [](T t) {
                   const Event e = t.happening.event;
                   return operational(t.before) || !operational(t.result.next) ||
                          (idle(t.before) && (e == event::start || e == event::start_stand ||
                                              e == event::start_walk));
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
    StepProperty{"the panel's place changes by its own movement and what is seen of it, only",
                 "Func-5", lc::kLinks,
                 [](T t) {
                   const Event e = t.happening.event;
                   return ((t.before.flags ^ t.result.next.flags) & kPanelOut) == 0 ||
                          e == event::panel_deploy || e == event::panel_retract ||
                          e == event::panel_arrived_in || e == event::panel_arrived_out ||
                          e == event::panel_seen_out || e == event::panel_is_in;
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
constexpr auto kSteps = lc::join(lc::common::kSteps, kOwnSteps);

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
