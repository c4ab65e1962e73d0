// Requirements on TALARIS' locomotion controller, as properties of its states, steps and events,
// written from the requirements (TALARIS thesis 4.5.1, A.3 and A.5.3) and not from the table.

#include <array>
#include <bit>

#include "tools/lss-lc/talaris/words.h"
#include "tools/lss-lc/vehicle.h"

namespace lss::talaris {
namespace {

using namespace words;

constexpr std::uint16_t kModules = (1u << kFanModule) - 1;  // without the load cell
constexpr std::uint16_t kActuators = 1u << (kValveModule - 1) | 1u << (kFanModule - 1);
constexpr std::span<const char* const> kNames(kModuleNames, kFanModule);

// ---- states

constexpr std::array kOwnStates = {
    StateProperty{"an all-stop leads to FatalError at once, everything shut, from everywhere",
                  "A.5.3",
                  [](const lc::Table& table, S s) {
                    const lc::Result r = lc::step(table, s, Event::emergency_stop);
                    return r.row >= 0 && fatal(r.next) && r.next.mode == 0 &&
                           (r.actions & lc::kEmergencyStop) != 0;
                  }},
    StateProperty{"FatalError takes no command of the vehicle's own", "A.5.3",
                  [](const lc::Table& table, S s) {
                    if (!fatal(s)) return true;
                    for (const lc::EventInfo& e : table.events) {
                      if (e.command && lc::step(table, s, e.event).row >= 0) return false;
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
    StepProperty{"flags change by what they tell of, only", "4.5.1", lc::kLinks,
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
};

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
