#include "daemon/vehicles/talaris/modes.h"

#include <array>

#include "daemon/cycle/common_commands.h"
#include "daemon/vehicles/talaris/tunables.h"
#include "idl/talaris/codes.h"

namespace lss::talaris {
namespace {

using lc::break_off, lc::in_mode, lc::off, lc::stay;
using lc::kIdle, lc::kOperational, lc::kKeep;
using lc::Row;

constexpr lc::ModeSet kInManual = in_mode(Mode::manual), kInDuty = in_mode(Mode::duty_cycle),
                      kInScript = in_mode(Mode::script), kInStandby = in_mode(Mode::standby),
                      kInCalibrate = in_mode(Mode::calibrate), kInExecute = in_mode(Mode::execute);
constexpr lc::ModeSet kByHand = kInManual | kInDuty;
constexpr lc::ModeSet kGround = kByHand | kInScript | kInStandby | kInCalibrate;

enum Guard : unsigned {
  kIsCalibratedGuard = lc::kVehicleGuards,
  kIsPlanned,
  kImuTrusted,
  kFansStarted,
  kInAir,
  kOnGround,
};
constexpr const char* kGuardNames[] = {"navigation is calibrated", "something is planned",
                                       "the IMU is reliable",      "the fans are started",
                                       "it is in the air",         "it is on the ground"};

Verdict guard(unsigned number, const lc::ControllerState& s, unsigned) {
  switch (number) {
    case kIsCalibratedGuard:
      if (!(s.flags & kCalibrated)) return {.reason = reasons::not_calibrated};
      break;
    case kIsPlanned:
      if (!(s.flags & kPlanned)) return {.reason = reasons::not_planned};
      break;
    case kImuTrusted:
      if (s.flags & kImuLost) return {.reason = Reason::imu_lost, .subject = kImuModule};
      break;
    case kFansStarted:
      if (!(s.flags & kFansArmed))
        return {.reason = reasons::fans_not_armed, .subject = kFanModule};
      break;
    case kInAir:
      if (!airborne(s)) return {.reason = Reason::not_in_flight};
      break;
    case kOnGround:
      if (airborne(s)) return {.reason = reasons::in_flight};
      break;
    default: break;
  }
  return {};
}

void effect(lc::ActionSet actions, lc::ControllerState& s) {
  const auto set = [&](Flag flag, lc::ActionSet on, lc::ActionSet off) {
    lc::follow(s, flag, actions, on, off);
  };
  const lc::ActionSet rest = lc::kEmergencyStop | lc::kMotorsOff;
  set(kCalibrated, kIsCalibrated, rest | kGncOff | kCalibrate | kEndFlight | kImuIsLost);
  set(kPlanned, kPlan, rest | kEndFlight | kGains);
  set(kFansArmed, kIsArmed, kArm | kIsUnarmed);
  set(kImuLost, kImuIsLost, kImuIsGood);
  set(kAltimeterLost, kAltimeterIsLost, kAltimeterIsGood);
}

constexpr std::uint8_t m(Mode mode) { return static_cast<std::uint8_t>(mode); }
constexpr std::uint8_t g(Goal goal) { return static_cast<std::uint8_t>(goal); }

constexpr Row go(lc::Event event, lc::ModeSet from, lc::GuardSet guards, Mode to,
                 lc::ActionSet actions) {
  return {event, kOperational,  from,   guards, kKeep, State::operational,
          m(to), g(Goal::none), actions};
}
// It flies on, to another goal.
constexpr Row aim(lc::Event event, std::uint8_t from, lc::GuardSet guards, Goal goal,
                  lc::ActionSet actions) {
  return {event, kOperational, kInExecute, guards, from, State::operational,
          kKeep, g(goal),      actions};
}

constexpr lc::GuardSet kGroundOnly = lc::guard(kOnGround);
constexpr lc::ActionSet kTake = lc::kTakeAuthority;

constexpr std::array kRows = {
    Row{event::start, kIdle, 0, lc::kMayStart, kKeep, State::operational, m(Mode::manual),
        g(Goal::none), kTake | kShut},

    stay(event::stop, kIdle, 0, 0, 0),
    off(event::stop, kGround, kKeep),
    off(event::stop, kInExecute, g(Goal::none)),
    aim(event::stop, kKeep, 0, Goal::idle, kLand),
    break_off(event::stop),

    stay(event::manual, kOperational, kInManual, 0, kTake),
    go(event::manual, kInDuty, 0, Mode::manual, kTake | kShut),
    go(event::manual, kInStandby | kInCalibrate, 0, Mode::manual, kTake | kShut | kGncOff),
    go(event::manual, kInExecute, kGroundOnly, Mode::manual, kTake | kShut | kGncOff | kEndFlight),
    stay(event::duty_cycle, kOperational, kInDuty, 0, kTake),
    go(event::duty_cycle, kInManual, 0, Mode::duty_cycle, kTake | kShut),
    go(event::duty_cycle, kInStandby | kInCalibrate, 0, Mode::duty_cycle, kTake | kShut | kGncOff),
    go(event::duty_cycle, kInExecute, kGroundOnly, Mode::duty_cycle,
       kTake | kShut | kGncOff | kEndFlight),

    stay(event::valve, kOperational, kInManual, 0, kTake | kValve),
    stay(event::pulse, kOperational, kInDuty, 0, kTake | kPulse),
    stay(event::enable, kIdle | kOperational, kByHand | kInStandby, 0, kEnable),
    stay(event::arm, kOperational, kInManual, 0, kTake | kArm),
    stay(event::assume_armed, kOperational, kInManual, 0, kTake | kIsArmed),
    stay(event::fan, kOperational, kByHand, lc::guard(kFansStarted), kTake | kFan),

    stay(event::standby, kOperational, kInStandby, 0, kTake),
    go(event::standby, kByHand | kInCalibrate, 0, Mode::standby, kTake | kShut | kGncOff),
    go(event::standby, kInExecute, kGroundOnly, Mode::standby, kTake | kShut | kEndFlight),
    go(event::calibrate, kInStandby, lc::guard(kImuTrusted), Mode::calibrate,
       kTake | kShut | kCalibrate),
    go(event::execute, kInStandby,
       lc::guard(kIsCalibratedGuard) | lc::guard(kIsPlanned) | lc::guard(kImuTrusted),
       Mode::execute, kTake | kExecute),
    stay(event::plan, kOperational, kByHand | kInStandby | kInCalibrate, 0, kPlan),
    stay(event::gains, kIdle | kOperational, kByHand | kInStandby, 0, kGains),
    aim(event::land, g(Goal::idle), 0, Goal::idle, 0),
    // Before lift-off it ends the flight: nobody who wants it down may see it rise.
    Row{event::land, kOperational, kInExecute, 0, g(Goal::none), State::operational,
        m(Mode::standby), g(Goal::none), kShut | kEndFlight},
    // From every other mode: on the ground the guard gives the reason.
    Row{event::land, kOperational, lc::kAnyMode, lc::guard(kInAir), kKeep, State::operational,
        kKeep, g(Goal::landing), kLand},

    stay(event::script_upload, kIdle | kOperational, kByHand, 0, kUpload),
    go(event::script_run, kByHand, 0, Mode::script, kTake | kShut | kRunScript),
    Row{event::script_abort, kOperational, kInScript, 0, kKeep, State::fatal_error, 0, 0,
        lc::kEmergencyStop},

    off(lc::Event::lease_expired, kGround, kKeep),
    off(lc::Event::lease_expired, kInExecute, g(Goal::none)),
    aim(lc::Event::lease_expired, kKeep, lc::guard(lc::kAuthorityHeld), Goal::idle,
        lc::ActionSet{kLand} | lc::kReleaseAuthority),

    go(event::calibrated, kInCalibrate, lc::guard(kImuTrusted), Mode::standby, kIsCalibrated),
    go(event::calibration_refused, kInCalibrate, 0, Mode::standby, kGncOff),
    aim(event::lifted_off, g(Goal::none), 0, Goal::flying, 0),
    off(event::finished, kInExecute, g(Goal::idle)),
    go(event::finished, kInExecute, 0, Mode::standby, kShut | kEndFlight),
    go(event::script_ended, kInScript, 0, Mode::manual, kShut),

    stay(event::fans_armed, kOperational, kInManual, 0, kIsArmed),
    stay(event::fans_unarmed, lc::kAnyState, lc::kAnyMode, 0, kIsUnarmed),
    stay(event::imu_good, lc::kAnyState, lc::kAnyMode, 0, kImuIsGood),
    stay(event::imu_lost, lc::kAnyState, lc::kAnyMode, 0, kImuIsLost),
    stay(event::altimeter_good, lc::kAnyState, lc::kAnyMode, 0, kAltimeterIsGood),
    stay(event::altimeter_lost, lc::kAnyState, lc::kAnyMode, 0, kAltimeterIsLost),
};
constexpr lc::Rows kIndexed(kRows);

constexpr std::array kEvents = {
    lc::EventInfo{event::start, "start", true, 0, kind_of(lss::CommandKind::start)},
    lc::EventInfo{event::stop, "stop", true, 0, kind_of(lss::CommandKind::stop)},
    lc::EventInfo{event::manual, "manual", true, 0, kind_of(CommandKind::manual)},
    lc::EventInfo{event::duty_cycle, "duty-cycle", true, 0, kind_of(CommandKind::duty_cycle)},
    lc::EventInfo{event::valve, "valve", true, 0, kind_of(CommandKind::valve)},
    lc::EventInfo{event::pulse, "pulse", true, 0, kind_of(CommandKind::pulse)},
    lc::EventInfo{event::enable, "enable", true, 0, kind_of(CommandKind::enable)},
    lc::EventInfo{event::arm, "edf-arm start-up", true, 0, kind_of(CommandKind::edf_arm)},
    lc::EventInfo{event::assume_armed, "edf-arm done", true, 0},
    lc::EventInfo{event::fan, "edf-throttle, edf-rpm", true, 0, kind_of(CommandKind::edf_throttle)},
    lc::EventInfo{event::standby, "gnc standby", true, 0},
    lc::EventInfo{event::calibrate, "gnc calibrate", true, 0},
    lc::EventInfo{event::execute, "gnc execute", true, 0},
    lc::EventInfo{event::plan, "plan", true, 0, kind_of(CommandKind::plan)},
    lc::EventInfo{event::gains, "gains", true, 0, kind_of(CommandKind::gains)},
    lc::EventInfo{event::land, "land", true, 0, kind_of(CommandKind::land)},
    lc::EventInfo{event::script_upload, "script-begin, script-step", true, 0,
                  kind_of(CommandKind::script_begin)},
    lc::EventInfo{event::script_run, "script-run", true, 0, kind_of(CommandKind::script_run)},
    lc::EventInfo{event::script_abort, "script-abort", true, 0, kind_of(CommandKind::script_abort)},
    lc::EventInfo{event::calibrated, "calibrated", false, 0},
    lc::EventInfo{event::calibration_refused, "calibration refused", false, 0},
    lc::EventInfo{event::lifted_off, "lifted off", false, 0},
    lc::EventInfo{event::finished, "flight over", false, 0},
    lc::EventInfo{event::script_ended, "script ended", false, 0},
    lc::EventInfo{event::fans_armed, "fans started", false, 0},
    lc::EventInfo{event::fans_unarmed, "fans not started", false, 0},
    lc::EventInfo{event::imu_good, "IMU good", false, 0},
    lc::EventInfo{event::imu_lost, "IMU lost", false, 0},
    lc::EventInfo{event::altimeter_good, "altimeter good", false, 0},
    lc::EventInfo{event::altimeter_lost, "altimeter lost", false, 0},
};

}  // namespace

// Valves and fans must answer. IMU and altimeter have their flags: much works without them. The
// load cell exists on the test stand only.
const lc::Table kTable{.rows = &kIndexed,
                       .events = kEvents,
                       .modules = kFanModule,
                       .guard_names = kGuardNames,
                       .guard = guard,
                       .effect = effect,
                       .common = &lc::kCommonRows};

bool airborne(const lc::ControllerState& s) noexcept {
  return s.state == State::operational && s.mode == m(Mode::execute) && s.goal != g(Goal::none);
}

namespace {

// Commands that only the vehicle can judge: gas and thrust, scripts, valves by hand.
bool considered(std::uint16_t kind) noexcept {
  if (kind == kind_of(lss::CommandKind::reset)) return true;
  switch (static_cast<CommandKind>(kind)) {
    case CommandKind::valve:
    case CommandKind::pulse:
    case CommandKind::enable:
    case CommandKind::edf_arm:
    case CommandKind::edf_throttle:
    case CommandKind::edf_rpm:
    case CommandKind::gnc:
    case CommandKind::plan:
    case CommandKind::gains:
    case CommandKind::script_begin:
    case CommandKind::script_step:
    case CommandKind::script_run: return true;
    default: return false;
  }
}

lc::Event event_of(const Request& r) noexcept {
  switch (static_cast<CommandKind>(r.kind)) {
    case CommandKind::edf_arm: return arguments<ArmFans>(r).done ? event::assume_armed : event::arm;
    case CommandKind::edf_rpm: return event::fan;
    case CommandKind::gnc: {
      constexpr std::array kSteps = {event::standby, event::calibrate, event::execute};
      return kSteps[static_cast<std::size_t>(arguments<Gnc>(r).step)];
    }
    case CommandKind::script_step: return event::script_upload;
    default: return lss::event_of(kTable, r);
  }
}

bool reached(std::uint16_t kind, const SupervisorState& state) noexcept {
  if (done_at_once(kind)) return true;
  const lc::ControllerState& s = state.controller;
  const bool operational = s.state == State::operational;
  const auto mode = static_cast<Mode>(s.mode);
  switch (static_cast<lss::CommandKind>(kind)) {
    case lss::CommandKind::start: return operational && mode == Mode::manual;
    case lss::CommandKind::stop: return s.state == State::idle && state.sense[kSenseActive] == 0;
    case lss::CommandKind::solve: return s.state == State::idle;
    default: break;
  }
  switch (static_cast<CommandKind>(kind)) {
    case CommandKind::edf_arm: return (s.flags & kFansArmed) != 0;
    case CommandKind::gnc:  // calibrate and execute end in Standby, too
      return operational && mode == Mode::standby;
    case CommandKind::land: return !airborne(s);
    case CommandKind::valve:
    case CommandKind::pulse: return state.sense[kSensePulsing] == 0;
    case CommandKind::script_run: return operational && mode == Mode::manual;
    default: return true;
  }
}

}  // namespace

const Logic& logic() noexcept {
  static const Logic kLogic{.table = &kTable,
                            .event_of = event_of,
                            .reached = reached,
                            .commands = kCommands,
                            .airborne = airborne,
                            .considered = considered,
                            .tunables = tuning().infos,
                            .codes = kOwnCodes};
  return kLogic;
}

}  // namespace lss::talaris
