// Requirements on TALARIS' locomotion controller, as properties of its states, steps and events,
// written from the requirements and not from the table. Sources: numbers and A.x are of the TALARIS
// thesis, icd is docs/icd-talaris.md, gnc is docs/gnc-talaris.md, commands is
// idl/talaris/commands.h; others are documents of this name or requirements of
// docs/requirements.md.

#include <array>

#include "tools/lss-lc/talaris/words.h"
#include "tools/lss-lc/vehicle.h"

namespace lss::talaris {
namespace {

using namespace words;

constexpr std::uint16_t kModules = (1u << kFanModule) - 1;  // without the load cell
constexpr std::uint16_t kActuators = 1u << (kValveModule - 1) | 1u << (kFanModule - 1);
constexpr std::span<const char* const> kNames(kModuleNames, kFanModule);

// None of the vehicle's own commands but these.
bool takes_only(const lc::Table& table, S s, std::initializer_list<Event> these) {
  for (const lc::EventInfo& e : table.events) {
    if (e.command && !one_of(e.event, these) && lc::step(table, s, e.event).row >= 0) return false;
  }
  return true;
}
// Where a run is under way nothing may change what was checked before it.
bool runs(S s) { return in_mode(s, {Mode::script, Mode::execute}); }
// A run or a calibration ends.
bool ends(T t) {
  const Event e = t.happening.event;
  return (in_mode(t.before, Mode::script) && e == event::script_ended) ||
         (in_mode(t.before, Mode::calibrate) &&
          (e == event::calibrated || e == event::calibration_refused)) ||
         (in_mode(t.before, Mode::execute) && e == event::finished);
}
bool chooses_mode(Event e) {
  return one_of(e, {event::manual, event::duty_cycle, event::standby, event::calibrate,
                    event::execute, event::script_run, event::land});
}

// ---- states

constexpr std::array kOwnStates = {
    StateProperty{"an all-stop leads to FatalError at once, everything shut, from everywhere",
                  "A.5.3",
                  [](const lc::Table& table, S s) {
                    const lc::Result r = lc::step(table, s, Event::emergency_stop);
                    return r.row >= 0 && fatal(r.next) && r.next.mode == 0 &&
                           (r.actions & lc::kEmergencyStop) != 0;
                  }},
    StateProperty{"until errors are solved no command of the vehicle's own is taken but a stop of "
                  "what solves them",
                  "A.5.3",
                  [](const lc::Table& table, S s) {
                    if (fatal(s)) return refuses_for_its_state(table, s, {});
                    return !solving(s) || refuses_for_its_state(table, s, {event::stop});
                  }},
    // The advice of a refusal is what the operator does next: start.
    StateProperty{"in Idle nothing acts and no mode is chosen, because of the state", "operators",
                  [](const lc::Table& table, S s) {
                    return !idle(s) ||
                           refuses_for_its_state(table, s,
                                                 {event::start, event::stop, event::enable,
                                                  event::gains, event::script_upload});
                  }},
    StateProperty{"a script that runs is only stopped or broken off", "A.3.2",
                  [](const lc::Table& table, S s) {
                    return !in_mode(s, Mode::script) ||
                           takes_only(table, s, {event::stop, event::script_abort});
                  }},
    StateProperty{"what is in the air is only brought down", "operators",
                  [](const lc::Table& table, S s) {
                    return !in_air(s) || takes_only(table, s, {event::stop, event::land});
                  }},
    StateProperty{"calibrate and execute follow Standby, and say so elsewhere", "4.5.1",
                  [](const lc::Table& table, S s) {
                    if (!operational(s) || in_mode(s, Mode::standby)) return true;
                    for (const Event e : {event::calibrate, event::execute}) {
                      if (lc::step(table, s, e).verdict.reason != Reason::not_in_mode) return false;
                    }
                    return true;
                  }},
    StateProperty{"nothing is done by hand while the GNC is on", "4.5.1",
                  [](const lc::Table& table, S s) {
                    return !gnc(s) ||
                           takes_none(table, s,
                                      {event::valve, event::pulse, event::arm, event::assume_armed,
                                       event::fan, event::script_upload, event::script_run});
                  }},
    StateProperty{"it is in the air in Execute only", "4.2",
                  [](const lc::Table&, S s) { return !in_air(s) || in_mode(s, Mode::execute); }},
    StateProperty{"whatever is in the air can land and touch down", "4.2",
                  [](const lc::Table& table, S s) {
                    return !in_air(s) || (lc::step(table, s, event::land).row >= 0 &&
                                          lc::step(table, s, event::finished).row >= 0);
                  }},
    StateProperty{"a landing before lift-off ends the flight", "architecture",
                  [](const lc::Table& table, S s) {
                    return !in_mode(s, Mode::execute) || in_air(s) ||
                           lc::step(table, s, event::land).row >= 0;
                  }},
    StateProperty{"a landing asked for on the ground is rejected: it is there", "architecture",
                  [](const lc::Table& table, S s) {
                    return !operational(s) || in_mode(s, Mode::execute) ||
                           lc::step(table, s, event::land).verdict.reason == Reason::not_in_flight;
                  }},
    StateProperty{"what nobody holds comes down and is over then", "architecture",
                  [](const lc::Table&, S s) {
                    return !operational(s) || link(s, lc::kHeld) || goal(s) == Goal::idle;
                  }},
    StateProperty{"calibrated is only a GNC that is on, by an IMU to be trusted", "4.5.1",
                  [](const lc::Table&, S s) {
                    return !has(s, kCalibrated) ||
                           ((in_mode(s, Mode::standby) || in_mode(s, Mode::execute)) &&
                            !has(s, kImuLost));
                  }},
    StateProperty{"a plan is there in Operational only", "4.5.1",
                  [](const lc::Table&, S s) { return !has(s, kPlanned) || operational(s); }},
    StateProperty{"it does without none of its modules", "2.3",
                  [](const lc::Table&, S s) { return s.isolated == 0; }},
};

// ---- steps that were taken

constexpr std::array kOwnSteps = {
    StepProperty{"Operational is entered only from Idle, by start, in Manual, everything shut",
                 "4.5.1", lc::kChange,
                 [](T t) {
                   return operational(t.before) || !operational(t.result.next) ||
                          (idle(t.before) && t.happening.event == event::start &&
                           to(t, Mode::manual) && does(t, kShut));
                 }},
    StepProperty{"it executes only from Standby, calibrated, planned and with a good IMU", "4.5.1",
                 lc::kChange | lc::kActions,
                 [](T t) {
                   if (!enters(t, Mode::execute)) return !does(t, kExecute);
                   return does(t, kExecute) && in_mode(t.before, Mode::standby) &&
                          has(t.before, kCalibrated) && has(t.before, kPlanned) &&
                          !has(t.before, kImuLost) && !in_air(t.result.next);
                 }},
    StepProperty{
        "a calibration begins in Standby, and wherever the GNC goes on or off none is left",
        "4.5.1", lc::kChange | lc::kActions,
        [](T t) {
          if (enters(t, Mode::calibrate) != does(t, kCalibrate)) return false;
          if (does(t, kCalibrate) && !in_mode(t.before, Mode::standby)) return false;
          const bool switched = operational(t.before) && operational(t.result.next) &&
                                gnc(t.before) != gnc(t.result.next);
          return !switched || (does(t, kGncOff) && !has(t.result.next, kCalibrated));
        }},
    StepProperty{"a calibration that is broken off is forgotten", "4.5.1", lc::kChange,
                 [](T t) {
                   return !in_mode(t.before, Mode::calibrate) || !operational(t.result.next) ||
                          same_mode(t) || t.happening.event == event::calibrated ||
                          does(t, kGncOff);
                 }},
    StepProperty{"after a run it has to be calibrated and planned again", "4.5.1", lc::kChange,
                 [](T t) {
                   return !in_mode(t.before, Mode::execute) || to(t, Mode::execute) ||
                          !has(t.result.next, kCalibrated | kPlanned);
                 }},
    StepProperty{"the air is left by touching down or by an all-stop", "4.2", lc::kChange,
                 [](T t) {
                   return !in_air(t.before) || in_air(t.result.next) ||
                          t.happening.event == event::finished || does(t, lc::kEmergencyStop);
                 }},
    StepProperty{"what is on its way down is not called back", "4.2", lc::kChange,
                 [](T t) {
                   return !in_mode(t.before, Mode::execute) || !to(t, Mode::execute) ||
                          goal(t.result.next) >= goal(t.before);
                 }},
    StepProperty{"what acts in one mode is shut on the way to another", "4.5.1", lc::kChange,
                 [](T t) {
                   const bool acts = by_hand(t.before) || in_mode(t.before, Mode::script) ||
                                     in_mode(t.before, Mode::execute);
                   return !acts || !operational(t.result.next) || same_mode(t) || does(t, kShut);
                 }},
    StepProperty{"a script runs by hand only, and ends in Manual or with everything off", "A.3.2",
                 lc::kChange | lc::kActions,
                 [](T t) {
                   if (enters(t, Mode::script) != does(t, kRunScript)) return false;
                   if (enters(t, Mode::script)) return by_hand(t.before);
                   return !in_mode(t.before, Mode::script) || !operational(t.result.next) ||
                          same_mode(t) || to(t, Mode::manual);
                 }},
    StepProperty{"flags change only by what they report", "4.5.1", lc::kLinks,
                 [](T t) {
                   const Event e = t.happening.event;
                   const auto changed = [&](Flag flag) {
                     return ((t.before.flags ^ t.result.next.flags) & flag) != 0;
                   };
                   const auto only_on = [&](Flag flag, bool allowed) {
                     return !changed(flag) || has(t.before, flag) || allowed;
                   };
                   const bool fans = e == event::arm || e == event::assume_armed ||
                                     e == event::fans_armed || e == event::fans_unarmed;
                   const bool imu = e == event::imu_good || e == event::imu_lost;
                   const bool altimeter = e == event::altimeter_good || e == event::altimeter_lost;
                   return only_on(kCalibrated, e == event::calibrated) &&
                          only_on(kPlanned, e == event::plan) && (!changed(kFansArmed) || fans) &&
                          (!changed(kImuLost) || imu) && (!changed(kAltimeterLost) || altimeter);
                 }},
    authority_property<comes_to_rest>(),
    StepProperty{
        "nobody takes over what comes down because its source is lost", "operators", lc::kLinks,
        [](T t) { return !operational(t.before) || link(t.before, lc::kHeld) || !held_after(t); }},
    StepProperty{"a mode is left by command or when what runs in it has ended", "commands",
                 lc::kChange,
                 [](T t) {
                   if (!operational(t.before) || !operational(t.result.next) || same_mode(t))
                     return true;
                   if (in_mode(t.before, Mode::script)) return ends(t);
                   return ends(t) || chooses_mode(t.happening.event);
                 }},
    StepProperty{"what a command asks for is done by that command and by nothing else", "commands",
                 lc::kActions,
                 [](T t) {
                   return only_by(t, kValve, {event::valve}) &&
                          only_by(t, kPulse, {event::pulse}) &&
                          only_by(t, kEnable, {event::enable}) && only_by(t, kArm, {event::arm}) &&
                          only_by(t, kFan, {event::fan}) && only_by(t, kPlan, {event::plan}) &&
                          only_by(t, kGains, {event::gains}) &&
                          only_by(t, kUpload, {event::script_upload});
                 }},
    StepProperty{"valves and fans are commanded by hand in the modes for that only", "4.5.1",
                 lc::kActions,
                 [](T t) {
                   const bool manual = in_mode(t.before, Mode::manual);
                   return (!does(t, kValve) || manual) &&
                          (!does(t, kPulse) || in_mode(t.before, Mode::duty_cycle)) &&
                          (!does(t, kArm) || manual) && (!does(t, kFan) || by_hand(t.before));
                 }},
    StepProperty{"fans run by hand only after their start-up", "operators", lc::kActions,
                 [](T t) { return !does(t, kFan) || has(t.before, kFansArmed); }},
    // A start-up that was broken off by leaving Manual does not count.
    StepProperty{"fans are started when their start-up in Manual ended, or an operator says so",
                 "icd 7", lc::kActions,
                 [](T t) {
                   return only_by(t, kIsArmed, {event::assume_armed, event::fans_armed}) &&
                          (!does(t, kIsArmed) || in_mode(t.before, Mode::manual)) &&
                          only_by(t, kIsUnarmed, {event::fans_unarmed});
                 }},
    StepProperty{"valves in use, gains, plan and script are changed between runs only", "operators",
                 lc::kActions,
                 [](T t) {
                   return !lc::common::does(t, kEnable | kGains | kPlan | kUpload) ||
                          !runs(t.before);
                 }},
    // Also in the air: shutting ends a flight that is under way.
    StepProperty{
        "what acts goes on until its mode is left: nothing else shuts it", "commands", lc::kActions,
        [](T t) { return !does(t, kShut) || (operational(t.result.next) && !same_mode(t)); }},
    StepProperty{"by hand, and for a calibration, it begins with everything shut", "operators",
                 lc::kChange,
                 [](T t) {
                   const bool begins = enters(t, Mode::manual) || enters(t, Mode::duty_cycle) ||
                                       enters(t, Mode::calibrate);
                   return !begins || does(t, kShut);
                 }},
    StepProperty{"navigation begins again where the GNC goes on or off, or was not calibrated",
                 "4.5.1", lc::kActions,
                 [](T t) {
                   if (!does(t, kGncOff)) return true;
                   const bool switched = gnc(t.before) != gnc(t.result.next);
                   const bool broken_off = in_mode(t.before, Mode::calibrate) && !same_mode(t) &&
                                           t.happening.event != event::calibrated;
                   return operational(t.before) && operational(t.result.next) &&
                          (switched || broken_off);
                 }},
    StepProperty{"a calibration begins with an IMU to be trusted, and its end alone calibrates",
                 "4.5.1", lc::kActions,
                 [](T t) {
                   return (!does(t, kCalibrate) || !has(t.before, kImuLost)) &&
                          only_by(t, kIsCalibrated, {event::calibrated}) &&
                          (!does(t, kIsCalibrated) || in_mode(t.before, Mode::calibrate));
                 }},
    StepProperty{
        "a run ends where Execute is left for another mode, and only there", "4.5.1", lc::kActions,
        [](T t) {
          return !does(t, kEndFlight) ||
                 (in_mode(t.before, Mode::execute) && operational(t.result.next) && !same_mode(t));
        }},
    StepProperty{"a landing begins in the air, by command or for want of a heartbeat", "operators",
                 lc::kActions,
                 [](T t) {
                   return only_by(t, kLand, {event::land, event::stop, Event::lease_expired}) &&
                          (!does(t, kLand) || (in_air(t.before) && in_air(t.result.next)));
                 }},
    StepProperty{
        "an abort of a script is an all-stop only where a script runs", "operators", lc::kChange,
        [](T t) {
          return t.happening.event != event::script_abort || in_mode(t.before, Mode::script);
        }},
    StepProperty{"IMU and altimeter are what is reported of them", "gnc", lc::kActions,
                 [](T t) {
                   return only_by(t, kImuIsGood, {event::imu_good}) &&
                          only_by(t, kImuIsLost, {event::imu_lost}) &&
                          only_by(t, kAltimeterIsGood, {event::altimeter_good}) &&
                          only_by(t, kAltimeterIsLost, {event::altimeter_lost});
                 }},
};

// ---- what has to happen

Mode mode_of(Event e) {
  return e == event::manual       ? Mode::manual
         : e == event::duty_cycle ? Mode::duty_cycle
                                  : Mode::standby;
}
lc::ActionSet action_of(Event e) {
  return e == event::valve ? kValve : e == event::pulse ? kPulse : kFan;
}
// What was commanded, and who commanded it has authority.
bool for_its_source(T t, lc::ActionSet all) { return does(t, all) && held_after(t); }
// Nothing runs that settings could disturb.
bool settable(S s) { return idle(s) || by_hand(s) || in_mode(s, Mode::standby); }

constexpr std::array kOwnDuties = {
    Duty{"start leads to Manual with everything shut, for the source that commands it",
         "Func-1",
         {event::start},
         [](S s, const Happening&) { return can_start(s); },
         [](T t) { return to(t, Mode::manual) && for_its_source(t, kShut); }},
    Duty{"stop leads to Idle from every mode, from the air by a landing",
         "Func-2",
         {event::stop},
         [](S s, const Happening&) { return operational(s); },
         comes_to_rest},
    stop_at_rest({event::stop}),
    stop_while_solving({event::stop}),
    Duty{"without the heartbeat of who commands it comes to rest, from the air by a landing",
         "O-Int-2",
         {Event::lease_expired},
         [](S s, const Happening&) { return link(s, lc::kHeld); },
         [](T t) { return comes_to_rest(t) && !held_after(t); }},
    Duty{"on the ground it goes to Manual, DutyCycle and Standby from every mode but a script",
         "4.5.1",
         {event::manual, event::duty_cycle, event::standby},
         [](S s, const Happening&) {
           return operational(s) && !in_air(s) && !in_mode(s, Mode::script);
         },
         [](T t) {
           const Mode wanted = mode_of(t.happening.event);
           return to(t, wanted) && goal(t.result.next) == Goal::none && held_after(t) &&
                  (!in_mode(t.before, wanted) || keeps(t));
         }},
    Duty{"by hand valves open, pulse and fans run as commanded",
         "4.5.1",
         {event::valve, event::pulse, event::fan},
         [](S s, const Happening& h) {
           return h.event == event::valve   ? in_mode(s, Mode::manual)
                  : h.event == event::pulse ? in_mode(s, Mode::duty_cycle)
                                            : by_hand(s) && has(s, kFansArmed);
         },
         [](T t) { return keeps(t) && for_its_source(t, action_of(t.happening.event)); }},
    Duty{"fans that start up are not started before that has ended",
         "icd 7",
         {event::arm, event::assume_armed, event::fans_armed},
         [](S s, const Happening&) { return in_mode(s, Mode::manual); },
         [](T t) {
           return t.happening.event == event::arm
                      ? only_flags(t, 0, kFansArmed) && for_its_source(t, kArm)
                      : only_flags(t, kFansArmed, 0);
         }},
    Duty{"fans that lost their start-up are not started, wherever it is",
         "icd 7",
         {event::fans_unarmed},
         any_state,
         [](T t) { return only_flags(t, 0, kFansArmed); }},
    Duty{"which valves may fire is set where nothing runs",
         "commands",
         {event::enable},
         [](S s, const Happening&) { return settable(s); },
         [](T t) { return keeps(t) && does(t, kEnable); }},
    Duty{
        "gains are selected between runs, and a flight is planned with those that it is flown with",
        "commands",
        {event::gains},
        [](S s, const Happening&) { return settable(s); },
        [](T t) { return only_flags(t, 0, kPlanned) && does(t, kGains); }},
    Duty{"a script is sent at rest and by hand, and is run by hand",
         "A.3.2",
         {event::script_upload, event::script_run},
         [](S s, const Happening& h) {
           return by_hand(s) || (idle(s) && h.event == event::script_upload);
         },
         [](T t) {
           return t.happening.event == event::script_upload
                      ? keeps(t) && does(t, kUpload)
                      : to(t, Mode::script) && for_its_source(t, kRunScript);
         }},
    Duty{"a script that is broken off is an all-stop, one that ends leads to Manual",
         "A.3.2",
         {event::script_abort, event::script_ended},
         [](S s, const Happening&) { return in_mode(s, Mode::script); },
         [](T t) {
           return t.happening.event == event::script_abort ? emergency(t)
                                                           : to(t, Mode::manual) && held_after(t);
         }},
    Duty{"what shall be flown is planned on the ground, also while it calibrates",
         "4.5.1",
         {event::plan},
         [](S s, const Happening&) { return operational(s) && !runs(s); },
         [](T t) { return only_flags(t, kPlanned, 0) && does(t, kPlan); }},
    Duty{"a calibration leads back to Standby, and counts unless it was refused",
         "4.5.1",
         {event::calibrated, event::calibration_refused},
         [](S s, const Happening& h) {
           return in_mode(s, Mode::calibrate) &&
                  (h.event == event::calibration_refused || !has(s, kImuLost));
         },
         [](T t) {
           return to(t, Mode::standby) &&
                  has(t.result.next, kCalibrated) == (t.happening.event == event::calibrated);
         }},
    Duty{"land brings it down to Standby from the air, and ends a run that is not yet there",
         "operators",
         {event::land},
         [](S s, const Happening&) { return in_mode(s, Mode::execute); },
         [](T t) {
           if (!in_air(t.before)) return to(t, Mode::standby) && does(t, kShut | kEndFlight);
           return goal(t.before) == Goal::idle
                      ? keeps(t)
                      : aims(t, Goal::landing) && t.result.next.links == t.before.links;
         }},
    Duty{"the state of IMU and altimeter is known everywhere; without its IMU it is not calibrated",
         "gnc",
         {event::imu_good, event::imu_lost, event::altimeter_good, event::altimeter_lost},
         any_state,
         [](T t) {
           const Event e = t.happening.event;
           return e == event::imu_good         ? only_flags(t, 0, kImuLost)
                  : e == event::imu_lost       ? only_flags(t, kImuLost, kCalibrated)
                  : e == event::altimeter_good ? only_flags(t, 0, kAltimeterLost)
                                               : only_flags(t, kAltimeterLost, 0);
         }},
};
constexpr auto kDuties = lc::join(lc::common::kDuties, kOwnDuties);

// ---- the way back

Happening help(S s) {
  if (const auto any = help_any(s)) return *any;
  return {goal(s) == Goal::idle ? event::finished : event::stop, 0};
}

// To a flight.
Happening help_to_fly(S s) {
  if (link(s, lc::kObcSilent)) return {Event::obc_heard, 0};
  if (has(s, kImuLost)) return {event::imu_good, 0};
  if (idle(s) && contact(s)) return {event::start, 0};
  if (!operational(s)) return help(s);
  if (in_mode(s, Mode::script)) return {event::script_ended, 0};
  if (in_mode(s, Mode::calibrate)) return {event::calibrated, 0};
  if (in_mode(s, Mode::execute)) return {in_air(s) ? event::finished : event::lifted_off, 0};
  if (by_hand(s)) return {event::standby, 0};
  if (!has(s, kCalibrated)) return {event::calibrate, 0};
  return {has(s, kPlanned) ? event::execute : event::plan, 0};
}

constexpr auto kStates = lc::join(lc::common::kStates, kOwnStates);
constexpr auto kSteps = lc::join(lc::common::kSteps, kOwnSteps);
constexpr std::array kReturns = {
    return_to_idle<help>(),
    Return{"from every state it comes to fly as planned when the world helps",
           [](S s) { return goal(s) == Goal::flying; }, help_to_fly},
};

lc::Model model_of(const lc::Table& table, std::uint16_t modules) {
  return lc::model_of<kStates, kSteps>(table, modules, kDuties, contracts(), kReturns);
}

constexpr const char* kGoals[] = {"none", "flying", "landing", "idle"};
constexpr lc::FlagName kFlags[] = {{kCalibrated, "calibrated"},
                                   {kPlanned, "planned"},
                                   {kFansArmed, "fans started"},
                                   {kImuLost, "IMU lost"},
                                   {kAltimeterLost, "altimeter lost"}};

}  // namespace
}  // namespace lss::talaris

LSS_VERIFIED(talaris, .title = "TALARIS", .modules = talaris::kModules, .few = talaris::kActuators,
             .flag_names = talaris::kFlags, .module_names = talaris::kNames)
