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
};

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
