// Requirements on D.I.A.N.A. Ardito's locomotion controller, as properties of its states, steps and
// events, written from the requirements and not from the table. Sources: 7.x, 10, 11 and part III
// are of the Ardito thesis (7.x: docs/fmea.md, part III: its table of rules), icd is
// docs/icd-ardito.md, commands is idl/ardito/commands.h; others are documents of this name or
// requirements of docs/requirements.md.

#include <array>
#include <bit>
#include <utility>

#include "daemon/vehicles/ardito/modes.h"
#include "tools/lss-lc/common.h"
#include "tools/lss-lc/vehicle.h"

namespace lss::ardito {
namespace {

using namespace lc::common;
constexpr std::uint16_t kModules = (1u << (kBusNodes - 1)) - 1;  // without the IMU
constexpr std::uint16_t kWheelMask = (1u << kDriveWheels) - 1;
constexpr std::uint16_t kSteeringMask = ((1u << kSteeredWheels) - 1) << kDriveWheels;

Goal goal(S s) { return static_cast<Goal>(s.goal); }
bool moving(S s) {
  return in_mode(s, {Mode::steering, Mode::running, Mode::parking, Mode::decelerating});
}
bool ready(S s) { return in_mode(s, Mode::stopped) || moving(s); }
bool confirmed(S s) { return has(s, kMotorsConfirmed); }
// Equal except for flags and links.
bool only_flags(T t) { return same_mode(t) && t.result.next.goal == t.before.goal; }
bool flag_is(T t, Flag flag, bool on) {
  return has(t.result.next, flag) == on &&
         (t.result.next.flags & ~flag) == (t.before.flags & ~flag);
}
// Of the button or of power.
Flag told_by(Event e) {
  return one_of(e, {event::button_in, event::button_out}) ? kButtonIn : kPowerBad;
}
// Known from then on, and an emergency in Operational.
bool cut_by(T t, Flag flag) {
  return has(t.result.next, flag) &&
         (operational(t.before) ? emergency(t) : only_flags(t) && flag_is(t, flag, true));
}
bool may_start(S s) { return can_start(s) && !has(s, kButtonIn | kPowerBad); }
// Requested by a command or by itself, in the present mode.
bool aims(T t, Goal wanted, lc::ActionSet action) {
  return same_mode(t) && goal(t.result.next) == wanted && held_after(t) && does(t, action);
}
// Idle at once, or on the way to Idle: the rover slows down first.
bool comes_to_rest(T t) {
  if (!moving(t.before)) return idle(t.result.next);
  return same_mode(t) && goal(t.result.next) == Goal::idle && does(t, kHalt);
}

// It stands, ready for another command.
bool comes_to_stand(T t) {
  return same_mode(t) && goal(t.result.next) == Goal::none && does(t, kHalt);
}

// By a source that has authority from then on.
bool commands_motion(Event e) {
  return one_of(e, {event::drive, event::drive_autonomous, event::park, event::halt});
}
// The mode that the mobility controller reports; none: another report.
Mode reported(Event e) {
  constexpr std::array kReports = {
      std::pair{event::is_stopped, Mode::stopped}, std::pair{event::is_steering, Mode::steering},
      std::pair{event::is_running, Mode::running}, std::pair{event::is_parking, Mode::parking},
      std::pair{event::is_decelerating, Mode::decelerating}};
  for (const auto& [report, mode] : kReports) {
    if (report == e) return mode;
  }
  return Mode::none;
}
constexpr lc::ActionSet kOrders = lc::ActionSet{kDrive} | kPark | kHalt;

// ---- states

constexpr std::array kOwnStates = {
    StateProperty{"nothing moves before all drives are confirmed on, which the lamp precedes",
                  "part III",
                  [](const lc::Table&, S s) {
                    return confirmed(s) ? ready(s) : !moving(s) && goal(s) == Goal::none;
                  }},
    StateProperty{
        "the emergency-stop button and lost power cut everything", "part III",
        [](const lc::Table&, S s) { return !operational(s) || !has(s, kButtonIn | kPowerBad); }},
    StateProperty{"it drives by itself only while it is asked to drive", "10",
                  [](const lc::Table&, S s) {
                    return !has(s, kAutonomous) || (ready(s) && goal(s) == Goal::drive);
                  }},
    StateProperty{"motors that nobody holds are on their way off", "architecture",
                  [](const lc::Table&, S s) {
                    return !operational(s) || link(s, lc::kHeld) || goal(s) == Goal::idle;
                  }},
    StateProperty{"what is on its way off still moves", "10",
                  [](const lc::Table&, S s) { return goal(s) != Goal::idle || moving(s); }},
    StateProperty{"whatever moves can come to a stop", "10",
                  [](const lc::Table& table, S s) {
                    return !moving(s) || lc::step(table, s, event::is_stopped).row >= 0;
                  }},
    StateProperty{"the rover goes on with five wheels, not with four, and steers with all",
                  "Conf-3",
                  [](const lc::Table&, S s) {
                    return (s.isolated & ~kWheelMask) == 0 &&
                           std::popcount(s.isolated) <= static_cast<int>(kMostIsolated);
                  }},
    // An accepted drive would be a promise: its end is motion (commands).
    StateProperty{"before errors are solved none of the rover's own commands is taken but a stop "
                  "of what solves them",
                  "Oper-6",
                  [](const lc::Table& table, S s) {
                    if (fatal(s)) return refuses_for_its_state(table, s, {});
                    return !solving(s) || refuses_for_its_state(table, s, {event::stop});
                  }},
    // The advice of a refusal is what the operator does next: start, or wait for the lamp.
    StateProperty{"motion is refused at rest because of the state, before the lamp ran because of "
                  "the mode",
                  "operators",
                  [](const lc::Table& table, S s) {
                    if (idle(s))
                      return refuses_for_its_state(table, s, {event::start, event::stop});
                    if (!in_mode(s, Mode::warning)) return true;
                    for (const lc::EventInfo& e : table.events) {
                      if (commands_motion(e.event) &&
                          lc::step(table, s, e.event).verdict.reason != Reason::not_in_mode)
                        return false;
                    }
                    return true;
                  }},
};

// ---- steps that were taken

constexpr std::array kOwnSteps = {
    StepProperty{"Operational is entered only from Idle, by start, and begins with the lamp",
                 "part III", lc::kChange | lc::kActions,
                 [](T t) {
                   const bool enters = !operational(t.before) && operational(t.result.next);
                   const bool right =
                       idle(t.before) && t.happening.event == event::start && to(t, Mode::warning);
                   return enters ? right && does(t, kBeacon) : !does(t, kBeacon);
                 }},
    StepProperty{"motors are switched on only after the lamp ran", "part III",
                 lc::kChange | lc::kActions,
                 [](T t) {
                   const bool after = in_mode(t.before, Mode::warning) && ready(t.result.next);
                   return after ? does(t, kMotorsOn) && to(t, Mode::stopped) : !does(t, kMotorsOn);
                 }},
    StepProperty{
        "the mobility controller gets orders only in Operational, with its motors confirmed", "10",
        lc::kActions,
        [](T t) {
          return !does(t, kOrders) || (operational(t.result.next) && confirmed(t.before));
        }},
    StepProperty{"it drives and parks by these commands and by nothing else", "commands",
                 lc::kActions,
                 [](T t) {
                   return only_by(t, kDrive, {event::drive, event::drive_autonomous}) &&
                          only_by(t, kPark, {event::park}) &&
                          only_by(t, kByItself, {event::drive_autonomous});
                 }},
    // Switched to driving by itself again it flashes for 5 s and stands.
    StepProperty{"each order says who drives, operator or rover, and nothing else changes that",
                 "7.7.2", lc::kActions,
                 [](T t) {
                   const bool hand = does(t, kByHand), itself = does(t, kByItself);
                   return does(t, kOrders) ? hand != itself : !hand && !itself;
                 }},
    // An emergency stop holds drives in quick stop, with power.
    StepProperty{"at rest drives are off, not held", "icd 9", lc::kActions,
                 [](T t) {
                   return !does(t, lc::kEmergencyStop) || !idle(t.before) || !idle(t.result.next);
                 }},
    StepProperty{"it drives until another command: what makes it stand ends its goal", "commands",
                 lc::kActions,
                 [](T t) {
                   return !does(t, kHalt) || goal(t.result.next) == Goal::none ||
                          goal(t.result.next) == Goal::idle;
                 }},
    StepProperty{
        "drives are confirmed by their report only", "icd 9", lc::kActions,
        [](T t) { return only_by(t, lc::ActionSet{kConfirm}, {event::motors_confirmed}); }},
    StepProperty{"IMU, button and power are what is reported of them", "icd 10", lc::kActions,
                 [](T t) {
                   return only_by(t, kImuIsGood, {event::imu_good}) &&
                          only_by(t, kImuIsLost, {event::imu_lost}) &&
                          only_by(t, kButtonIsOut, {event::button_out}) &&
                          only_by(t, kButtonIsIn, {event::button_in}) &&
                          only_by(t, kPowerIsGood, {event::power_good}) &&
                          only_by(t, kPowerIsBad, {event::power_bad});
                 }},
    StepProperty{"commands change the goal, the modes are the mobility controller's", "11.2.4",
                 lc::kChange,
                 [](T t) {
                   return !operational(t.before) || !operational(t.result.next) || same_mode(t) ||
                          in_mode(t.before, Mode::warning) || to(t, reported(t.happening.event));
                 }},
    StepProperty{"authority goes to who commands motion", "architecture", lc::kLinks,
                 [](T t) {
                   return !held_after(t) || link(t.before, lc::kHeld) || idle(t.before) ||
                          commands_motion(t.happening.event);
                 }},
    StepProperty{"it begins to drive by itself only with an IMU to be trusted", "7.7.2",
                 lc::kLinks | lc::kActions,
                 [](T t) {
                   const bool begins =
                       has(t.result.next, kAutonomous) && !has(t.before, kAutonomous);
                   return (!begins && !does(t, kByItself)) || !has(t.before, kImuLost);
                 }},
    StepProperty{"the way off is left only by a command that takes authority", "architecture",
                 lc::kChange,
                 [](T t) {
                   return goal(t.before) != Goal::idle || goal(t.result.next) == Goal::idle ||
                          !operational(t.result.next) || does(t, lc::kTakeAuthority);
                 }},
    authority_property<comes_to_rest>(),
};

// ---- what has to happen

// What the command asks for.
Goal goal_of(Event e) {
  return e == event::park ? Goal::park : e == event::halt ? Goal::none : Goal::drive;
}
lc::ActionSet order_of(Event e) {
  return e == event::park ? kPark : e == event::halt ? kHalt : kDrive;
}
bool drives_on(S s) { return ready(s) && confirmed(s); }

constexpr std::array kOwnDuties = {
    Duty{"start leads to the lamp, for the source that commands it",
         "Func-1",
         {event::start},
         [](S s, const Happening&) { return may_start(s); },
         [](T t) {
           return to(t, Mode::warning) && goal(t.result.next) == Goal::none && held_after(t) &&
                  does(t, kBeacon);
         }},
    Duty{"stop leads to a safe stop from every mode: what moves slows down first",
         "Func-2",
         {event::stop},
         [](S s, const Happening&) { return operational(s); },
         [](T t) { return comes_to_rest(t) && !has(t.result.next, kAutonomous); }},
    stop_at_rest({event::stop}),
    stop_while_solving({event::stop}),
    Duty{
        "without the heartbeat of who commands it comes to a safe stop",
        "O-Int-2",
        {Event::lease_expired},
        [](S s, const Happening&) { return link(s, lc::kHeld); },
        [](T t) { return comes_to_rest(t) && !held_after(t) && !has(t.result.next, kAutonomous); }},
    Duty{"with its motors confirmed it drives, parks and stands as commanded, from every mode",
         "10",
         {event::drive, event::drive_autonomous, event::park, event::halt},
         [](S s, const Happening& h) {
           return drives_on(s) && (h.event != event::drive_autonomous || !has(s, kImuLost));
         },
         [](T t) {
           const Event e = t.happening.event;
           return aims(t, goal_of(e), order_of(e)) &&
                  has(t.result.next, kAutonomous) == (e == event::drive_autonomous);
         }},
    Duty{"the mode is what the mobility controller reports, and the goal stays",
         "11.2.4",
         {event::is_steering, event::is_running, event::is_parking, event::is_decelerating},
         [](S s, const Happening& h) { return drives_on(s) && !in_mode(s, reported(h.event)); },
         [](T t) {
           return to(t, reported(t.happening.event)) && t.result.next.goal == t.before.goal;
         }},
    Duty{"what has come to a stop stands, and is switched off where that was the goal",
         "10",
         {event::is_stopped},
         [](S s, const Happening&) { return moving(s); },
         [](T t) {
           return goal(t.before) == Goal::idle
                      ? idle(t.result.next)
                      : to(t, Mode::stopped) && t.result.next.goal == t.before.goal;
         }},
    Duty{"drives that report to be on are known to be, and nothing moves by that",
         "icd 9",
         {event::motors_confirmed},
         [](S s, const Happening&) { return ready(s); },
         [](T t) {
           return only_flags(t) && flag_is(t, kMotorsConfirmed, true) &&
                  starts_nothing_but(t, kConfirm);
         }},
    Duty{"by itself it stops without its IMU, and is driven by hand again",
         "7.7.2",
         {event::autonomy_lost},
         [](S s, const Happening&) { return has(s, kAutonomous); },
         [](T t) {
           return comes_to_stand(t) && !has(t.result.next, kAutonomous) &&
                  held_after(t) == link(t.before, lc::kHeld);
         }},
    Duty{"a rover that is stuck stops and stands, ready for another way",
         "operators",
         {event::stuck},
         [](S s, const Happening&) { return goal(s) == Goal::drive || goal(s) == Goal::park; },
         [](T t) { return comes_to_stand(t) && held_after(t) == link(t.before, lc::kHeld); }},
    Duty{"the state of the IMU is known everywhere, and changes nothing else by itself",
         "7.7.1",
         {event::imu_good, event::imu_lost},
         any_state,
         [](T t) {
           return only_flags(t) && flag_is(t, kImuLost, t.happening.event == event::imu_lost);
         }},
    Duty{"a pressed button and lost power are known everywhere, an emergency in Operational",
         "part III",
         {event::button_in, event::power_bad},
         any_state,
         [](T t) { return cut_by(t, told_by(t.happening.event)); }},
    Duty{"a released button and returned power are known everywhere, and switch nothing on",
         "part III",
         {event::button_out, event::power_good},
         any_state,
         [](T t) { return only_flags(t) && flag_is(t, told_by(t.happening.event), false); }},
    Duty{"a wheel that the others do not need can be taken out of service, its motor off",
         "Conf-3",
         {event::isolate},
         [](S s, const Happening& h) {
           return solving(s) && in_service(s, h.subject) &&
                  std::popcount(s.isolated) < static_cast<int>(kMostIsolated);
         },
         leaves_service},
};
constexpr auto kDuties = lc::join(lc::common::kDuties, kOwnDuties);

// ---- events

bool is(S s, Mode m) { return ready(s) && !in_mode(s, m); }
template <Mode m>
constexpr Contract now_in(const char* name, Event event) {
  return {name, event, [](S s, unsigned) { return is(s, m) && confirmed(s); },
          [](T t) { return to(t, m) && t.result.next.goal == t.before.goal; }};
}
template <Flag flag, bool on>
constexpr Contract says(const char* name, Event event) {
  return {name, event, always, [](T t) { return only_flags(t) && flag_is(t, flag, on); }};
}
template <Flag flag>
constexpr Contract cuts(const char* name, Event event) {
  return {name, event, always, [](T t) { return cut_by(t, flag); }};
}

constexpr std::array kOwnContracts = {
    next_strategy_contract<next_strategy>(),
    lease_expired_contract<[](T t) {
      return comes_to_rest(t) && !has(t.result.next, kAutonomous);
    }>(),

    Contract{"start", event::start, [](S s, unsigned) { return may_start(s); },
             [](T t) {
               return to(t, Mode::warning) && goal(t.result.next) == Goal::none && held_after(t);
             }},
    Contract{"stop", event::stop, [](S s, unsigned) { return !fatal(s); },
             [](T t) {
               if (solving(t.before)) return breaks_off(t);
               return idle(t.before) ? keeps(t) : comes_to_rest(t);
             }},
    Contract{"drive", event::drive, [](S s, unsigned) { return ready(s) && confirmed(s); },
             [](T t) { return aims(t, Goal::drive, kDrive) && !has(t.result.next, kAutonomous); }},
    Contract{"drive autonomous", event::drive_autonomous,
             [](S s, unsigned) { return ready(s) && confirmed(s) && !has(s, kImuLost); },
             [](T t) { return aims(t, Goal::drive, kDrive) && has(t.result.next, kAutonomous); }},
    Contract{"park", event::park, [](S s, unsigned) { return ready(s) && confirmed(s); },
             [](T t) { return aims(t, Goal::park, kPark); }},
    Contract{"halt", event::halt, [](S s, unsigned) { return ready(s) && confirmed(s); },
             [](T t) { return aims(t, Goal::none, kHalt); }},

    Contract{"beacon ran", event::warned, [](S s, unsigned) { return in_mode(s, Mode::warning); },
             [](T t) { return to(t, Mode::stopped) && goal(t.result.next) == Goal::none; }},
    Contract{"motors confirmed", event::motors_confirmed, [](S s, unsigned) { return ready(s); },
             [](T t) { return only_flags(t) && flag_is(t, kMotorsConfirmed, true); }},
    Contract{"is stopped", event::is_stopped, [](S s, unsigned) { return is(s, Mode::stopped); },
             [](T t) {
               if (goal(t.before) == Goal::idle) return idle(t.result.next);
               return to(t, Mode::stopped) && t.result.next.goal == t.before.goal;
             }},
    now_in<Mode::steering>("is steering", event::is_steering),
    now_in<Mode::running>("is running", event::is_running),
    now_in<Mode::parking>("is parking", event::is_parking),
    now_in<Mode::decelerating>("is decelerating", event::is_decelerating),

    says<kImuLost, false>("IMU good", event::imu_good),
    says<kImuLost, true>("IMU lost", event::imu_lost),
    Contract{"autonomy lost", event::autonomy_lost,
             [](S s, unsigned) { return ready(s) && goal(s) == Goal::drive; },
             [](T t) { return comes_to_stand(t) && t.result.next.links == t.before.links; }},
    Contract{
        "stuck", event::stuck,
        [](S s, unsigned) { return ready(s) && (goal(s) == Goal::drive || goal(s) == Goal::park); },
        [](T t) {
          return comes_to_stand(t) && does(t, kByHand) && !has(t.result.next, kAutonomous) &&
                 t.result.next.links == t.before.links;
        }},
    says<kButtonIn, false>("button released", event::button_out),
    cuts<kButtonIn>("button pressed", event::button_in),
    says<kPowerBad, false>("power good", event::power_good),
    cuts<kPowerBad>("power bad", event::power_bad),
    Contract{
        "isolate", event::isolate,
        [](S s, unsigned wheel) { return solving(s) && wheel <= kDriveWheels && s.isolated == 0; },
        leaves_service},
};

// ---- the way back

Happening help(S s) {
  if (const auto any = help_any(s)) return *any;
  return {moving(s) && goal(s) == Goal::idle ? event::is_stopped : event::stop, 0};
}

// To a start.
Happening help_to_start(S s) {
  if (link(s, lc::kObcSilent)) return {Event::obc_heard, 0};
  if (has(s, kButtonIn)) return {event::button_out, 0};
  if (has(s, kPowerBad)) return {event::power_good, 0};
  if (idle(s) && contact(s)) return {event::start, 0};
  if (in_mode(s, Mode::warning)) return {event::warned, 0};
  if (ready(s) && !confirmed(s)) return {event::motors_confirmed, 0};
  return help(s);
}

constexpr auto kStates = lc::join(lc::common::kStates, kOwnStates);
constexpr auto kSteps = lc::join(lc::common::kSteps, kOwnSteps);
constexpr auto kContracts = lc::join(lc::common::kContracts, kOwnContracts);
constexpr std::array kReturns = {
    return_to_idle<help>(),
    Return{"from every state it comes to stand with its motors on when the world helps",
           [](S s) { return in_mode(s, Mode::stopped) && confirmed(s); }, help_to_start},
};

// Neither the table nor the properties above distinguish between wheels, or between steering
// drives: the first ones represent all.
ControllerState stands_for(const ControllerState& s) {
  ControllerState first = s;
  first.isolated = first.unheard = first.silent = 0;
  for (const std::uint16_t group :
       {kWheelMask, kSteeringMask, static_cast<std::uint16_t>(1u << (kIoNode - 1))}) {
    unsigned next = static_cast<unsigned>(std::countr_zero(group));
    const auto put = [&](std::uint16_t from, std::uint16_t& set) {
      for (int n = std::popcount(static_cast<unsigned>(from & group)); n > 0; --n, ++next)
        set = static_cast<std::uint16_t>(set | 1u << next);
    };
    put(s.isolated, first.isolated);
    put(s.unheard, first.unheard);
    put(s.silent, first.silent);
  }
  return first;
}

lc::Model model_of(const lc::Table& table, std::uint16_t modules) {
  lc::Model m = lc::model_of<kStates, kSteps>(table, modules, kDuties, kContracts, kReturns);
  m.stands_for = stands_for;
  return m;
}

constexpr const char* kGoals[] = {"none", "drive", "park", "idle"};
constexpr lc::FlagName kFlags[] = {{kMotorsConfirmed, "motors confirmed"},
                                   {kAutonomous, "by itself"},
                                   {kImuLost, "IMU lost"},
                                   {kButtonIn, "button in"},
                                   {kPowerBad, "power bad"}};

}  // namespace
}  // namespace lss::ardito

LSS_VERIFIED(ardito, .title = "D.I.A.N.A. Ardito", .modules = ardito::kModules,
             .few = 0x3,  // two wheels
             .flag_names = ardito::kFlags, .module_names = ardito::kNodeNames)
