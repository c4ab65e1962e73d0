// When each event is accepted, and its result.

#include <array>

#include "tools/lss-lc/talaris/words.h"

namespace lss::talaris {
namespace {

using namespace words;

bool on_ground(S s) { return operational(s) && !in_air(s); }
// By a command to the mode that it names; in that mode already, nothing changes.
template <Mode m>
bool changes_to(T t) {
  return to(t, m) && takes(t, 0) && (in_mode(t.before, m) ? keeps(t) : does(t, kShut));
}
template <Mode m>
constexpr Contract changes(const char* name, Event event) {
  return {name, event, [](S s, unsigned) { return on_ground(s) && !in_mode(s, Mode::script); },
          changes_to<m>};
}
// By hand, in this mode: the state stays as it is.
template <Mode m, lc::ActionSet actions>
constexpr Contract acts(const char* name, Event event) {
  return {name, event, [](S s, unsigned) { return in_mode(s, m); },
          [](T t) { return keeps(t) && takes(t, actions); }};
}
template <unsigned on, unsigned off>
constexpr Contract says(const char* name, Event event) {
  return {name, event, always, [](T t) { return only_flags(t, on, off); }};
}

constexpr std::array kOwn = {
    next_strategy_contract<next_strategy>(),
    lease_expired_contract<comes_to_rest>(),

    Contract{"start", event::start, [](S s, unsigned) { return can_start(s); },
             [](T t) { return to(t, Mode::manual) && takes(t, kShut); }},
    Contract{"stop", event::stop, [](S s, unsigned) { return !fatal(s); },
             [](T t) {
               if (solving(t.before)) return breaks_off(t);
               return idle(t.before) ? keeps(t) : comes_to_rest(t);
             }},
    changes<Mode::manual>("manual", event::manual),
    changes<Mode::duty_cycle>("duty cycle", event::duty_cycle),
    changes<Mode::standby>("standby", event::standby),
    Contract{"calibrate", event::calibrate,
             [](S s, unsigned) { return in_mode(s, Mode::standby) && !has(s, kImuLost); },
             [](T t) { return to(t, Mode::calibrate) && takes(t, kCalibrate | kShut); }},
    Contract{"execute", event::execute,
             [](S s, unsigned) {
               return in_mode(s, Mode::standby) && has(s, kCalibrated) && has(s, kPlanned) &&
                      !has(s, kImuLost);
             },
             [](T t) { return to(t, Mode::execute) && takes(t, kExecute); }},

    acts<Mode::manual, kValve>("valve", event::valve),
    acts<Mode::duty_cycle, kPulse>("pulse", event::pulse),
    Contract{"enable", event::enable,
             [](S s, unsigned) { return idle(s) || by_hand(s) || in_mode(s, Mode::standby); },
             [](T t) { return keeps(t) && does(t, kEnable); }},
    Contract{"start-up of the fans", event::arm,
             [](S s, unsigned) { return in_mode(s, Mode::manual); },
             [](T t) { return only_flags(t, 0, kFansArmed) && takes(t, kArm); }},
    Contract{"fans were started", event::assume_armed,
             [](S s, unsigned) { return in_mode(s, Mode::manual); },
             [](T t) { return only_flags(t, kFansArmed, 0) && takes(t, kIsArmed); }},
    Contract{"fan", event::fan, [](S s, unsigned) { return by_hand(s) && has(s, kFansArmed); },
             [](T t) { return keeps(t) && takes(t, kFan); }},

    Contract{"plan", event::plan,
             [](S s, unsigned) {
               return on_ground(s) && !in_mode(s, Mode::script) && !in_mode(s, Mode::execute);
             },
             [](T t) { return only_flags(t, kPlanned, 0) && does(t, kPlan); }},
    Contract{"gains", event::gains,
             [](S s, unsigned) { return idle(s) || by_hand(s) || in_mode(s, Mode::standby); },
             [](T t) { return only_flags(t, 0, kPlanned) && does(t, kGains); }},
    Contract{"land", event::land,
             [](S s, unsigned) { return in_air(s) || in_mode(s, Mode::execute); },
             [](T t) {
               if (!in_air(t.before)) return to(t, Mode::standby) && does(t, kShut | kEndFlight);
               return goal(t.before) == Goal::idle
                          ? keeps(t)
                          : aims(t, Goal::landing) && t.result.next.links == t.before.links;
             }},
    Contract{"script upload", event::script_upload,
             [](S s, unsigned) { return idle(s) || by_hand(s); },
             [](T t) { return keeps(t) && does(t, kUpload); }},
    Contract{"script run", event::script_run, [](S s, unsigned) { return by_hand(s); },
             [](T t) { return to(t, Mode::script) && takes(t, kRunScript); }},
    Contract{"script abort", event::script_abort,
             [](S s, unsigned) { return in_mode(s, Mode::script); },
             [](T t) { return emergency(t); }},

    Contract{"calibrated", event::calibrated,
             [](S s, unsigned) { return in_mode(s, Mode::calibrate) && !has(s, kImuLost); },
             [](T t) { return to(t, Mode::standby) && has(t.result.next, kCalibrated); }},
    Contract{"calibration refused", event::calibration_refused,
             [](S s, unsigned) { return in_mode(s, Mode::calibrate); },
             [](T t) {
               return to(t, Mode::standby) && does(t, kGncOff) && !has(t.result.next, kCalibrated);
             }},
    Contract{"lifted off", event::lifted_off,
             [](S s, unsigned) { return in_mode(s, Mode::execute) && !in_air(s); },
             [](T t) { return same_mode(t) && goal(t.result.next) == Goal::flying; }},
    Contract{"flight over", event::finished,
             [](S s, unsigned) { return in_mode(s, Mode::execute); },
             [](T t) {
               return goal(t.before) == Goal::idle
                          ? idle(t.result.next)
                          : to(t, Mode::standby) && t.result.next.links == t.before.links;
             }},
    Contract{"script ended", event::script_ended,
             [](S s, unsigned) { return in_mode(s, Mode::script); },
             [](T t) { return to(t, Mode::manual) && held_after(t); }},
    Contract{"fans started", event::fans_armed,
             [](S s, unsigned) { return in_mode(s, Mode::manual); },
             [](T t) { return only_flags(t, kFansArmed, 0); }},
    says<0, kFansArmed>("fans not started", event::fans_unarmed),
    says<0, kImuLost>("IMU good", event::imu_good),
    says<kImuLost, kCalibrated>("IMU lost", event::imu_lost),
    says<0, kAltimeterLost>("altimeter good", event::altimeter_good),
    says<kAltimeterLost, 0>("altimeter lost", event::altimeter_lost),
};
constexpr auto kContracts = lc::join(lc::common::kContracts, kOwn);

}  // namespace

std::span<const lc::Contract> contracts() { return kContracts; }

}  // namespace lss::talaris
