// Requirements on Lunar Zebro's locomotion controller, as properties of its states and steps,
// written from the requirements and not from the table; and the way back to Idle.

#include <array>

#include "tools/lss-lc/vehicle.h"
#include "tools/lss-lc/zebro/composed.h"
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

// ---- words of steps

bool commands_motion(Event e) {
  return one_of(
      e, {event::stand, event::lay_down, event::stow, event::walk, event::walk_zero, event::leg});
}
// As commanded, for the source of the command.
bool leads_where_it_says(T t) {
  return end_of(t.result.next) == end_of(t.happening.event) && held_after(t);
}
// Off is off, lying or not: what lies is switched off where it lies.
bool ends_alike(End before, End after) {
  return before == after || (before == End::lying_off && after == End::off);
}
bool same_or_finishing(T t) {
  return same_mode(t) || (to(t, Mode::finishing_step) && in_mode(t.before, {Mode::walking}));
}
// Another mode on the way to the same end, or the end itself.
bool comes_nearer(T t) {
  if (in_mode(t.before, Mode::bridge)) return same_mode(t) && goal(t.result.next) == Goal::none;
  const bool there = !operational(t.result.next) || holds_still(t.result.next) ||
                     in_mode(t.result.next, {Mode::walking});
  return ends_alike(end_of(t.before), end_of(t.result.next)) &&
         (there || (in_mode(t.before, {Mode::finishing_step}) && !same_mode(t)));
}

// ---- steps that were taken

// These actions only in a step between these states.
template <lc::ActionSet kActions, State kBefore, State kAfter>
bool only(T t) {
  return !does(t, kActions) || (t.before.state == kBefore && t.result.next.state == kAfter);
}

constexpr std::array kOwnSteps = {
    StepProperty{"Operational is entered only from Idle, by start", "4.3.1", lc::kChange,
                 [](T t) {
                   const Event e = t.happening.event;
                   return operational(t.before) || !operational(t.result.next) ||
                          (idle(t.before) && (e == event::start || e == event::start_stand ||
                                              e == event::start_walk));
                 }},
    StepProperty{"legs are commanded to move only in Operational", "4.3.1", lc::kActions,
                 [](T t) { return !does(t, kLegMotion) || operational(t.result.next); }},
    StepProperty{"a leg is moved free only in SolveErrors", "Conf-3", lc::kActions,
                 only<kFreeLeg, State::solve_errors, State::solve_errors>},
    StepProperty{"the panel is commanded to move only in Idle", "Func-5", lc::kActions,
                 only<kPanelMotion, State::idle, State::idle>},
    StepProperty{"motors are switched on only by start", "Oper-7", lc::kActions,
                 only<kMotorsOn, State::idle, State::operational>},
    StepProperty{"walking follows standing up, standing or walking", "Func-3", lc::kChange,
                 [](T t) {
                   return !to(t, Mode::walking) ||
                          in_mode(t.before, {Mode::standing_up, Mode::standing, Mode::walking});
                 }},
    StepProperty{"a walk ends with its step finished, or in an emergency", "Func-2", lc::kChange,
                 [](T t) {
                   return !in_mode(t.before, {Mode::walking}) || to(t, Mode::walking) ||
                          to(t, Mode::finishing_step) || does(t, lc::kEmergencyStop);
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
    authority_property<[](T t) { return stops(t.result.next); }>(),
    StepProperty{"modes are commanded in Operational only", "4.3.1",
                 lc::kChange | lc::kActions | lc::kLinks,
                 [](T t) { return operational(t.before) || !commands_motion(t.happening.event); }},
    StepProperty{"authority is given to who commands motion, by nothing else", "architecture",
                 lc::kLinks,
                 [](T t) {
                   return !held_after(t) || link(t.before, lc::kHeld) || idle(t.before) ||
                          commands_motion(t.happening.event);
                 }},
    StepProperty{"only a walk has a step to finish", "Func-2", lc::kChange,
                 [](T t) {
                   return !to(t, Mode::finishing_step) ||
                          in_mode(t.before, {Mode::walking, Mode::finishing_step});
                 }},
    StepProperty{"a leg out of service is moved by its own command only", "Conf-3", lc::kActions,
                 [](T t) {
                   return only_by(t, lc::ActionSet{kMoveLeg}, {event::leg}) &&
                          (!does(t, kFreeLeg) || in_service(t.before, t.happening.subject));
                 }},
    StepProperty{"out of service and back goes a module by error solving and by the operator, at "
                 "rest",
                 "Conf-3", lc::kActions,
                 [](T t) {
                   const bool rest = idle(t.before) || fatal(t.before);
                   return only_by(t, lc::kIsolate, {event::isolate, event::isolate_leg}) &&
                          only_by(t, lc::kRestore, {Event::restore, event::restore_leg}) &&
                          only_by(t, kPanelForgone, {event::panel_is_in}) &&
                          (!one_of(t.happening.event,
                                   {event::isolate_leg, event::restore_leg, event::panel_is_in}) ||
                           rest);
                 }},
    StepProperty{"the panel moves with every module in contact, one movement at a time", "Func-5",
                 lc::kActions,
                 [](T t) {
                   return !does(t, kPanelMotion) ||
                          (contact(t.before) && !has(t.before, kPanelMoving));
                 }},
    StepProperty{
        "where it goes is changed by commands, and by what stops it", "Func-3", lc::kChange,
        [](T t) {
          const Event e = t.happening.event;
          const bool report = one_of(e, {event::motors_confirmed, event::motion_done}) ||
                              e == event::panel_arrived_in || e == event::panel_arrived_out;
          return !report || ends_alike(end_of(t.before), end_of(t.result.next));
        }},
    StepProperty{
        "motors are confirmed by their report only, and move nothing that was not commanded",
        "4.3.1", lc::kActions,
        [](T t) {
          return only_by(t, lc::ActionSet{kConfirm}, {event::motors_confirmed}) &&
                 (t.happening.event != event::motors_confirmed ||
                  (t.result.actions & kLegMotion & ~lc::ActionSet{kStandUp}) == 0);
        }},
    StepProperty{
        "the panel moves by its command and in its sense, and its place is what is seen", "Func-5",
        lc::kActions,
        [](T t) {
          return only_by(t, kPanelDeploy, {event::panel_deploy}) &&
                 only_by(t, kPanelRetract, {event::panel_retract}) &&
                 only_by(t, lc::ActionSet{kPanelStop}, {event::stop, event::stop_lay_down}) &&
                 (!does(t, kPanelStop) || idle(t.before)) &&
                 only_by(t, kPanelIsIn, {event::panel_arrived_in, event::panel_is_in}) &&
                 only_by(t, kPanelIsOut, {event::panel_arrived_out, event::panel_seen_out}) &&
                 (idle(t.before) ||
                  !one_of(t.happening.event, {event::panel_arrived_in, event::panel_arrived_out}));
        }},
    StepProperty{"the panel goes out of service when its module is lost, and the operator says so",
                 "Func-5", lc::kActions,
                 [](T t) {
                   return !in_service(t.before, kModules) || in_service(t.result.next, kModules) ||
                          (t.happening.event == event::panel_is_in &&
                           lost_module(t.before, kModules));
                 }},
    StepProperty{"a leg is moved free by its strategy only, and motors go off during error solving "
                 "where a strategy or its movement ends",
                 "Conf-3", lc::kActions,
                 [](T t) {
                   return only_by(t, kFreeLeg, {event::free_leg}) &&
                          (!solving(t.before) || !solving(t.result.next) ||
                           only_by(t, lc::kMotorsOff,
                                   {Event::next_strategy, event::leg_freed, event::isolate}));
                 }},
};
constexpr auto kSteps = lc::join(lc::common::kSteps, kOwnSteps);

// ---- what has to happen

bool operates(S s, const Happening&) { return operational(s); }

constexpr std::array kOwnDuties = {
    Duty{"start leads to motors on and to what it names",
         "Func-1",
         {event::start, event::start_stand, event::start_walk},
         [](S s, const Happening&) { return may_start(s); },
         [](T t) {
           return to(t, Mode::holding) && does(t, kMotorsOn) && held_after(t) &&
                  end_of(t.result.next) == end_of(t.happening.event);
         }},
    Duty{"stop leads to a safe stop from every mode, lying down when that is asked for",
         "Func-2",
         {event::stop, event::stop_lay_down},
         operates,
         [](T t) {
           const bool lie = t.happening.event == event::stop_lay_down && !lies(t.before);
           return stops(t.result.next) && (idle(t.result.next) || same_or_finishing(t) || lie) &&
                  (lie ? end_of(t.result.next) == End::lying_off
                       : idle(t.result.next) || lies(t.before) ||
                             end_of(t.result.next) == End::off);
         }},
    Duty{"what stands still is switched off at once, unless it has to lie down first",
         "Func-2",
         {event::stop, event::stop_lay_down},
         [](S s, const Happening& h) {
           return holds_still(s) && (h.event == event::stop || lies(s));
         },
         [](T t) { return idle(t.result.next); }},
    Duty{"stop at rest stops the panel, and changes nothing else",
         "Func-2",
         {event::stop, event::stop_lay_down},
         [](S s, const Happening&) { return idle(s); },
         panel_stopped},
    stop_while_solving({event::stop, event::stop_lay_down}),
    Duty{"without the heartbeat of who commands it comes to a safe stop, lying",
         "O-Int-2",
         {Event::lease_expired},
         [](S s, const Happening&) { return link(s, lc::kHeld); },
         [](T t) {
           return stops(t.result.next) && !held_after(t) &&
                  (same_or_finishing(t) || idle(t.result.next) || to(t, Mode::lying_down)) &&
                  (lies(t.before) || end_of(t.result.next) == End::lying_off) &&
                  (!holds_still(t.before) || !lies(t.before) || idle(t.result.next));
         }},
    Duty{"what stands or walks can walk, in any direction and at any speed",
         "Func-3",
         {event::walk, event::walk_zero},
         [](S s, const Happening&) {
           return in_mode(s, {Mode::standing, Mode::walking});
         },
         leads_where_it_says},
    Duty{"what holds its motors on can stand, lie down and be stowed, also while it walks",
         "Func-3",
         {event::stand, event::lay_down, event::stow},
         [](S s, const Happening&) {
           return confirmed(s) &&
                  (holds_still(s) || in_mode(s, {Mode::walking, Mode::finishing_step}));
         },
         leads_where_it_says},
    Duty{"what is on the way there is commanded there again",
         "Func-3",
         {event::stand, event::lay_down, event::stow, event::walk_zero},
         [](S s, const Happening& h) {
           return in_motion(s) && (in_mode(s, {Mode::finishing_step}) ? end_of(s) == end_of(h.event)
                                   : in_mode(s, {Mode::standing_up})  ? h.event == event::stand
                                   : in_mode(s, {Mode::lying_down})   ? h.event == event::lay_down
                                                                      : h.event == event::stow);
         },
         leads_where_it_says},
    Duty{"what holds still can move each leg, also one out of service",
         "7.2.1",
         {event::leg},
         [](S s, const Happening&) { return holds_still(s) && confirmed(s); },
         [](T t) {
           return leads_where_it_says(t) && does(t, kMoveLeg) && goal(t.result.next) == Goal::leg;
         }},
    Duty{"confirmed motors are remembered, and the chain goes on",
         "4.3.1",
         {event::motors_confirmed},
         [](S s, const Happening&) { return in_mode(s, {Mode::holding}); },
         [](T t) {
           return confirmed(t.result.next) &&
                  (end_of(t.before) == End::holding ? same_mode(t) : to(t, Mode::standing_up));
         }},
    Duty{"a motion that ends goes on to its goal",
         "4.3.1",
         {event::motion_done},
         [](S s, const Happening&) {
           return in_motion(s) || (in_mode(s, {Mode::bridge}) && goal(s) == Goal::leg);
         },
         [](T t) { return comes_nearer(t); }},
    Duty{"in Idle with all modules the panel can be deployed and retracted",
         "Func-5",
         {event::panel_deploy, event::panel_retract},
         [](S s, const Happening&) { return panel_ready(s); },
         [](T t) {
           return has(t.result.next, kPanelMoving) &&
                  does(t, t.happening.event == event::panel_deploy ? kPanelDeploy : kPanelRetract);
         }},
    Duty{"the panel's place is what is seen of it",
         "Func-5",
         {event::panel_arrived_in, event::panel_arrived_out, event::panel_seen_out},
         [](S s, const Happening& h) { return h.event == event::panel_seen_out || idle(s); },
         [](T t) {
           return has(t.result.next, kPanelOut) == (t.happening.event != event::panel_arrived_in) &&
                  !has(t.result.next, kPanelMoving) &&
                  (operational(t.before) ? emergency(t) : same_mode(t));
         }},
    Duty{"a leg can be moved free, and rests after it",
         "Conf-3",
         {event::free_leg, event::leg_freed},
         [](S s, const Happening& h) {
           return solving(s) && (h.event == event::leg_freed ||
                                 (in_service(s, h.subject) && !link(s, lc::kPortClosed)));
         },
         [](T t) {
           const bool moves = t.happening.event == event::free_leg;
           return same_mode(t) && has(t.result.next, kFreeing) == moves &&
                  (moves || does(t, lc::kMotorsOff));
         }},
    Duty{"a leg that the others do not need can be taken out of service",
         "Conf-3",
         {event::isolate},
         [](S s, const Happening& h) {
           return solving(s) && h.subject <= kLegs && in_service(s, h.subject) &&
                  others_can_walk((s.isolated & kLegMask) | 1u << (h.subject - 1));
         },
         [](T t) {
           return same_mode(t) && !in_service(t.result.next, t.happening.subject) &&
                  does(t, lc::kMotorsOff);
         }},
    Duty{"at rest the operator can take a leg out of service that the others do not need",
         "Conf-3",
         {event::isolate_leg},
         [](S s, const Happening& h) {
           return rests(s, h) && in_service(s, h.subject) &&
                  others_can_walk((s.isolated & kLegMask) | 1u << (h.subject - 1));
         },
         [](T t) {
           return starts_nothing_but(t, lc::kIsolate) &&
                  !in_service(t.result.next, t.happening.subject);
         }},
    Duty{"at rest one leg can be put into service again, and has to answer then",
         "Conf-3",
         {event::restore_leg},
         rests,
         [](T t) {
           const unsigned leg = 1u << (t.happening.subject - 1);
           return starts_nothing_but(t, lc::kRestore) &&
                  t.result.next.isolated == (t.before.isolated & ~leg) &&
                  t.result.next.silent == (t.before.silent | (t.before.isolated & leg));
         }},
    Duty{"at rest the operator can answer for a panel whose module is lost",
         "Func-5",
         {event::panel_is_in},
         [](S s, const Happening& h) { return rests(s, h) && lost_module(s, kModules); },
         [](T t) {
           return same_mode(t) && !in_service(t.result.next, kModules) &&
                  !lost_module(t.result.next, kModules) &&
                  !has(t.result.next, kPanelOut | kPanelMoving);
         }},
};
constexpr auto kDuties = lc::join(lc::common::kDuties, kOwnDuties);

// ---- the way back

Happening help(S s) {
  if (const auto any = help_any(s)) return *any;
  if (in_motion(s) && stops(s)) return {event::motion_done, 0};
  return {event::stop, 0};
}

constexpr std::array kReturns = {return_to_idle<help>()};

lc::Model model_of(const lc::Table& table, std::uint16_t modules) {
  return lc::model_of<kStates, kSteps>(table, modules, kDuties, contracts(), kReturns);
}

constexpr const char* kGoals[] = {"none", "stand", "walk",     "lie",
                                  "stow", "idle",  "lie_idle", "leg"};
constexpr lc::FlagName kFlags[] = {{kPanelMoving, "panel moves"},
                                   {kPanelOut, "panel out", kPanelMoving},
                                   {kMotorsConfirmed, "motors confirmed"},
                                   {kFreeing, "leg is freed"}};

}  // namespace
}  // namespace lss::zebro

LSS_VERIFIED(
    zebro, .title = "Lunar Zebro", .modules = zebro::words::kAllModules,
    .few = 0x41,  // a leg and the panel
    .flag_names = zebro::kFlags, .module_names = zebro::kModuleNames,
    .composition = [](const Depth& depth) { return zebro::compose(depth); })
