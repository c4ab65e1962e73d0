// Requirements on Lunar Zebro's locomotion controller, as properties of its states and steps,
// written from the requirements and not from the table; and the way back to Idle.

#include <array>

#include "tools/lss-lc/vehicle.h"
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
                          e == event::panel_seen_out;
                 }},
    authority_property<[](T t) { return stops(t.result.next); }>(),
};
constexpr auto kSteps = lc::join(lc::common::kSteps, kOwnSteps);

// ---- the way back

Happening help(S s) {
  if (const auto any = help_any(s)) return *any;
  if (in_motion(s) && stops(s)) return {event::motion_done, 0};
  return {event::stop, 0};
}

constexpr std::array kReturns = {return_to_idle<help>()};

lc::Model model_of(const lc::Table& table, std::uint16_t modules) {
  return lc::model_of<kStates, kSteps>(table, modules, contracts(), kReturns);
}

constexpr const char* kGoals[] = {"none", "stand", "walk",     "lie",
                                  "stow", "idle",  "lie_idle", "leg"};
constexpr lc::FlagName kFlags[] = {{kPanelMoving, "panel moves"},
                                   {kPanelOut, "panel out", kPanelMoving},
                                   {kMotorsConfirmed, "motors confirmed"},
                                   {kFreeing, "leg is freed"}};

}  // namespace
}  // namespace lss::zebro

namespace lss::lc {

const Verified& zebro_verified() {
  static const Verified vehicle{.name = "zebro",
                                .title = "Lunar Zebro",
                                .table = &zebro::kTable,
                                .model = zebro::model_of,
                                .modules = zebro::words::kAllModules,
                                .few = 0x41,  // a leg and the panel
                                .mode_names = zebro::kModeNames,
                                .goal_names = zebro::kGoals,
                                .flag_names = zebro::kFlags,
                                .module_names = zebro::kModuleNames};
  return vehicle;
}

}  // namespace lss::lc
