// Requirements on D.I.A.N.A. Ardito's locomotion controller, as properties of its states, steps and
// events, written from the requirements (Ardito thesis 10, 11 and part III) and not from the table.

#include <bit>

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

bool commands_motion(Event e) {
  return one_of(e, {event::drive, event::drive_autonomous, event::park, event::halt});
}
// The mode that this report names.
Mode reported(Event e) {
  return e == event::is_stopped    ? Mode::stopped
         : e == event::is_steering ? Mode::steering
         : e == event::is_running  ? Mode::running
         : e == event::is_parking  ? Mode::parking
                                   : Mode::decelerating;
}
bool is_report_of_mode(Event e) {
  return one_of(e, {event::is_stopped, event::is_steering, event::is_running, event::is_parking,
                    event::is_decelerating});
}

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
    StepProperty{"the rover is commanded to move only in Operational, with its motors confirmed",
                 "10", lc::kActions,
                 [](T t) {
                   return !does(t, lc::ActionSet{kDrive} | kPark) ||
                          (operational(t.result.next) && confirmed(t.before));
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
    StepProperty{"the rover is commanded to move with its motors on, by nothing else", "10",
                 lc::kChange | lc::kActions | lc::kLinks,
                 [](T t) {
                   return !commands_motion(t.happening.event) ||
                          (ready(t.before) && confirmed(t.before));
                 }},
    StepProperty{"authority is given to who commands motion, by nothing else", "architecture",
                 lc::kLinks | lc::kActions,
                 [](T t) {
                   return !does(t, lc::kTakeAuthority) || t.happening.event == event::start ||
                          commands_motion(t.happening.event);
                 }},
    StepProperty{"each order to the drives follows from its own command", "10", lc::kActions,
                 [](T t) {
                   return only_by(t, kDrive, {event::drive, event::drive_autonomous}) &&
                          only_by(t, kPark, {event::park}) &&
                          only_by(t, kHalt,
                                  {event::halt, event::stop, Event::lease_expired,
                                   event::autonomy_lost, event::stuck}) &&
                          only_by(t, kByItself, {event::drive_autonomous}) &&
                          (!does(t, kHalt) || ready(t.before));
                 }},
    StepProperty{"what stops the rover or drives it by hand ends autonomy, and nothing else does",
                 "10", lc::kActions,
                 [](T t) {
                   return only_by(t, kByHand,
                                  {event::drive, event::park, event::halt, event::stop,
                                   Event::lease_expired, event::autonomy_lost, event::stuck});
                 }},
    StepProperty{"lamp, confirmation, IMU, button and power are what is reported of them",
                 "part III", lc::kActions | lc::kLinks,
                 [](T t) {
                   return only_by(t, kConfirm, {event::motors_confirmed}) &&
                          only_by(t, kImuIsGood, {event::imu_good}) &&
                          only_by(t, kImuIsLost, {event::imu_lost}) &&
                          only_by(t, kButtonIsOut, {event::button_out}) &&
                          only_by(t, kButtonIsIn, {event::button_in}) &&
                          only_by(t, kPowerIsGood, {event::power_good}) &&
                          only_by(t, kPowerIsBad, {event::power_bad}) &&
                          (!does(t, kConfirm) || ready(t.before));
                 }},
    StepProperty{"the mode is what the drives do, as they report it", "11", lc::kChange,
                 [](T t) {
                   const Event e = t.happening.event;
                   if (!ready(t.before) || !ready(t.result.next) || same_mode(t)) return true;
                   return is_report_of_mode(e) && to(t, reported(e));
                 }},
    StepProperty{"where it goes is changed by commands, and by what stops it", "10", lc::kChange,
                 [](T t) {
                   if (t.before.goal == t.result.next.goal || !operational(t.result.next))
                     return true;
                   return commands_motion(t.happening.event) ||
                          one_of(t.happening.event, {event::stop, Event::lease_expired,
                                                     event::autonomy_lost, event::stuck});
                 }},
    StepProperty{"it is switched off at rest only by a stop, or by what ends its lease", "10",
                 lc::kChange,
                 [](T t) {
                   if (!operational(t.before) || !idle(t.result.next)) return true;
                   return one_of(t.happening.event,
                                 {event::stop, Event::lease_expired, Event::reset_controller}) ||
                          (t.happening.event == event::is_stopped && goal(t.before) == Goal::idle);
                 }},
    StepProperty{"a lease ends once, an order to stop is not taken back by what is lost", "10",
                 lc::kChange | lc::kActions | lc::kLinks,
                 [](T t) {
                   const Event e = t.happening.event;
                   if (e == Event::lease_expired)
                     return link(t.before, lc::kHeld) || !moving(t.before);
                   if (e == event::autonomy_lost)
                     return ready(t.before) && goal(t.before) == Goal::drive;
                   if (e == event::stuck)
                     return ready(t.before) &&
                            (goal(t.before) == Goal::drive || goal(t.before) == Goal::park);
                   return true;
                 }},
    StepProperty{"a wheel goes out of service by error solving, and back by the operator", "Conf-3",
                 lc::kLinks | lc::kActions,
                 [](T t) {
                   return only_by(t, lc::kIsolate, {event::isolate}) &&
                          only_by(t, lc::kRestore, {Event::restore}) &&
                          (t.happening.event != event::isolate || solving(t.before));
                 }},
    StepProperty{"motors go off during error solving only where a strategy ends", "Conf-3",
                 lc::kActions,
                 [](T t) {
                   return !solving(t.before) || !solving(t.result.next) ||
                          only_by(t, lc::kMotorsOff, {Event::next_strategy, event::isolate});
                 }},
};

// ---- what has to happen

bool drives(S s, const Happening&) { return ready(s) && confirmed(s); }
bool operates(S s, const Happening&) { return operational(s); }
bool only_the_mode(T t) {
  return to(t, reported(t.happening.event)) && t.result.next.goal == t.before.goal &&
         t.result.next.links == t.before.links && (t.result.actions & ~lc::kOnlyState) == 0;
}
bool gives_up(T t) {
  return same_mode(t) && goal(t.result.next) == Goal::none && does(t, kHalt) &&
         !has(t.result.next, kAutonomous) && t.result.next.links == t.before.links;
}

constexpr std::array kOwnDuties = {
    Duty{"start begins with the lamp, and gives authority",
         "part III",
         {event::start},
         [](S s, const Happening&) { return may_start(s); },
         [](T t) {
           return to(t, Mode::warning) && goal(t.result.next) == Goal::none && held_after(t) &&
                  does(t, kBeacon);
         }},
    Duty{"after the lamp the motors are switched on",
         "part III",
         {event::warned},
         [](S s, const Happening&) { return in_mode(s, Mode::warning); },
         [](T t) {
           return to(t, Mode::stopped) && goal(t.result.next) == Goal::none && does(t, kMotorsOn) &&
                  t.result.next.links == t.before.links;
         }},
    Duty{"confirmed motors are remembered, and start nothing",
         "10",
         {event::motors_confirmed},
         [](S s, const Happening&) { return ready(s); },
         [](T t) { return starts_nothing_but(t, kConfirm) && flag_is(t, kMotorsConfirmed, true); }},
    Duty{"with its motors on it drives, parks and halts as commanded, from every mode",
         "10",
         {event::drive, event::park, event::halt},
         drives,
         [](T t) {
           const Event e = t.happening.event;
           const bool right = e == event::drive  ? aims(t, Goal::drive, kDrive)
                              : e == event::park ? aims(t, Goal::park, kPark)
                                                 : aims(t, Goal::none, kHalt);
           return right && !has(t.result.next, kAutonomous);
         }},
    Duty{"with an IMU to be trusted it drives by itself",
         "7.7.2",
         {event::drive_autonomous},
         [](S s, const Happening& h) { return drives(s, h) && !has(s, kImuLost); },
         [](T t) { return aims(t, Goal::drive, kDrive) && has(t.result.next, kAutonomous); }},
    Duty{"stop leads to a safe stop from every mode",
         "10",
         {event::stop},
         operates,
         [](T t) { return comes_to_rest(t) && !has(t.result.next, kAutonomous); }},
    Duty{"stop at rest is accepted and changes nothing",
         "10",
         {event::stop},
         [](S s, const Happening&) { return idle(s); },
         [](T t) { return keeps(t) && starts_nothing(t); }},
    Duty{
        "without the heartbeat of who commands it comes to a safe stop",
        "O-Int-2",
        {Event::lease_expired},
        [](S s, const Happening&) { return link(s, lc::kHeld); },
        [](T t) { return comes_to_rest(t) && !has(t.result.next, kAutonomous) && !held_after(t); }},
    Duty{"the mode follows the drives, and the goal stays",
         "11",
         {event::is_steering, event::is_running, event::is_parking, event::is_decelerating},
         [](S s, const Happening& h) {
           return ready(s) && confirmed(s) && !in_mode(s, reported(h.event));
         },
         only_the_mode},
    Duty{"what has come to a stop stands, or is switched off when that was the aim",
         "11",
         {event::is_stopped},
         [](S s, const Happening&) { return moving(s); },
         [](T t) {
           return goal(t.before) == Goal::idle ? idle(t.result.next) && does(t, lc::kMotorsOff)
                                               : only_the_mode(t);
         }},
    Duty{"the IMU is as it is reported, and starts nothing",
         "7.7.2",
         {event::imu_good, event::imu_lost},
         any_state,
         [](T t) {
           const bool lost = t.happening.event == event::imu_lost;
           return starts_nothing_but(t, lost ? kImuIsLost : kImuIsGood) &&
                  flag_is(t, kImuLost, lost);
         }},
    Duty{"button and power switch everything off where it operates, and are remembered",
         "part III",
         {event::button_in, event::power_bad},
         any_state,
         [](T t) {
           const bool button = t.happening.event == event::button_in;
           const Flag flag = button ? kButtonIn : kPowerBad;
           return has(t.result.next, flag) &&
                  (operational(t.before)
                       ? emergency(t)
                       : flag_is(t, flag, true) &&
                             starts_nothing_but(t, button ? kButtonIsIn : kPowerIsBad));
         }},
    Duty{"released button and good power start nothing by themselves",
         "part III",
         {event::button_out, event::power_good},
         any_state,
         [](T t) {
           const bool button = t.happening.event == event::button_out;
           return flag_is(t, button ? kButtonIn : kPowerBad, false) &&
                  starts_nothing_but(t, button ? kButtonIsOut : kPowerIsGood);
         }},
    Duty{"without what it needs to drive by itself it stands, ready for another command",
         "7.7.2",
         {event::autonomy_lost},
         [](S s, const Happening&) { return ready(s) && goal(s) == Goal::drive; },
         gives_up},
    Duty{"what is stuck stands, ready for another command",
         "10",
         {event::stuck},
         [](S s, const Happening&) {
           return ready(s) && (goal(s) == Goal::drive || goal(s) == Goal::park);
         },
         gives_up},
    Duty{"a wheel that cannot be restored goes out of service when the others are enough",
         "Conf-3",
         {event::isolate},
         [](S s, const Happening& h) {
           return solving(s) && h.subject >= 1 && h.subject <= kDriveWheels && s.isolated == 0;
         },
         [](T t) {
           return same_mode(t) && !in_service(t.result.next, t.happening.subject) &&
                  does(t, lc::kIsolate) && does(t, lc::kMotorsOff);
         }},
};
constexpr auto kAllDuties = lc::join(lc::common::kDuties, kOwnDuties);

// ---- events

bool is(S s, Mode m) { return ready(s) && !in_mode(s, m); }
template <Mode m>
constexpr Contract now_in(const char* name, Event event) {
  return {name, event, [](S s, unsigned) { return is(s, m) && confirmed(s); },
          [](T t) { return to(t, m) && t.result.next.goal == t.before.goal; }};
}
template <Flag flag, bool on>
constexpr Contract says(const char* name, Event event) {
  return {name, event, [](S, unsigned) { return true; },
          [](T t) { return only_flags(t) && flag_is(t, flag, on); }};
}
template <Flag flag>
constexpr Contract cuts(const char* name, Event event) {
  return {name, event, [](S, unsigned) { return true; },
          [](T t) {
            return has(t.result.next, flag) &&
                   (operational(t.before) ? emergency(t) : only_flags(t) && flag_is(t, flag, true));
          }};
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
    Contract{"stop", event::stop, [](S s, unsigned) { return idle(s) || operational(s); },
             [](T t) { return idle(t.before) ? keeps(t) : comes_to_rest(t); }},
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
             [](T t) {
               return same_mode(t) && goal(t.result.next) == Goal::none && does(t, kHalt) &&
                      t.result.next.links == t.before.links;
             }},
    Contract{
        "stuck", event::stuck,
        [](S s, unsigned) { return ready(s) && (goal(s) == Goal::drive || goal(s) == Goal::park); },
        [](T t) {
          return same_mode(t) && goal(t.result.next) == Goal::none && does(t, kHalt) &&
                 does(t, kByHand) && !has(t.result.next, kAutonomous) &&
                 t.result.next.links == t.before.links;
        }},
    says<kButtonIn, false>("button released", event::button_out),
    cuts<kButtonIn>("button pressed", event::button_in),
    says<kPowerBad, false>("power good", event::power_good),
    cuts<kPowerBad>("power bad", event::power_bad),
    Contract{
        "isolate", event::isolate,
        [](S s, unsigned wheel) { return solving(s) && wheel <= kDriveWheels && s.isolated == 0; },
        [](T t) {
          return same_mode(t) && !in_service(t.result.next, t.happening.subject) &&
                 stops_motors(t.result.actions);
        }},
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
  lc::Model m = lc::model_of<kStates, kSteps>(table, modules, kAllDuties, kContracts, kReturns);
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

namespace lss::lc {

const Verified& ardito_verified() {
  static const Verified vehicle{.name = "ardito",
                                .title = "D.I.A.N.A. Ardito",
                                .table = &ardito::kTable,
                                .model = ardito::model_of,
                                .modules = ardito::kModules,
                                .few = 0x3,  // two wheels
                                .mode_names = ardito::kModeNames,
                                .goal_names = ardito::kGoals,
                                .flag_names = ardito::kFlags,
                                .module_names = ardito::kNodeNames};
  return vehicle;
}

}  // namespace lss::lc
