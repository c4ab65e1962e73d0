#include "daemon/vehicles/ardito/modes.h"

#include <array>
#include <bit>
#include <cmath>

#include "daemon/cycle/common_commands.h"
#include "daemon/vehicles/ardito/tunables.h"
#include "idl/ardito/codes.h"

namespace lss::ardito {
namespace {

using lc::aim, lc::break_off, lc::off, lc::in_mode;
using lc::kIdle, lc::kOperational, lc::kFatal, lc::kSolving, lc::kKeep;
using lc::Row;

constexpr lc::ModeSet kWarning = in_mode(Mode::warning), kStopped = in_mode(Mode::stopped),
                      kSteering = in_mode(Mode::steering), kRunning = in_mode(Mode::running),
                      kParking = in_mode(Mode::parking),
                      kDecelerating = in_mode(Mode::decelerating);
constexpr lc::ModeSet kMoving = kSteering | kRunning | kParking | kDecelerating;
constexpr lc::ModeSet kReady = kStopped | kMoving;

enum Guard : unsigned {
  kButtonReleased = lc::kVehicleGuards,
  kPowered,
  kMotorsOnConfirmed,
  kImuTrusted,
  kEnoughWheels,  // to go on without the subject
};
constexpr const char* kGuardNames[] = {"the emergency-stop button is released",
                                       "the motors have power", "all drives are enabled",
                                       "the IMU is reliable", "the other wheels are enough"};
constexpr lc::GuardSet kMayStart = lc::kMayStart | lc::guard(kButtonReleased) | lc::guard(kPowered);
constexpr lc::GuardSet kMotors = lc::guard(kMotorsOnConfirmed);
constexpr lc::GuardSet kHeld = lc::guard(lc::kAuthorityHeld);

Verdict guard(unsigned number, const lc::ControllerState& s, unsigned subject) {
  switch (number) {
    case kButtonReleased:
      if (s.flags & kButtonIn) return {.reason = reasons::button_pressed, .subject = kIoNode};
      break;
    case kPowered:
      if (s.flags & kPowerBad) return {.reason = reasons::power_bad, .subject = kIoNode};
      break;
    case kMotorsOnConfirmed:
      if (!(s.flags & kMotorsConfirmed)) return {.reason = Reason::motors_not_on};
      break;
    case kImuTrusted:
      if (s.flags & kImuLost) return {.reason = Reason::imu_lost, .subject = kImuNode};
      break;
    case kEnoughWheels: {
      const bool wheel = subject >= 1 && subject <= kDriveWheels;
      const unsigned others = wheel ? s.isolated & ~(1u << (subject - 1)) : 0;
      if (!wheel || static_cast<unsigned>(std::popcount(others)) >= kMostIsolated)
        return {.reason = reasons::too_few_wheels, .subject = static_cast<std::uint16_t>(subject)};
      break;
    }
    default: break;
  }
  return {};
}

void effect(lc::ActionSet actions, lc::ControllerState& s) {
  const auto set = [&](Flag flag, lc::ActionSet on, lc::ActionSet off) {
    lc::follow(s, flag, actions, on, off);
  };
  const lc::ActionSet rest = lc::kEmergencyStop | lc::kMotorsOff;
  set(kMotorsConfirmed, kConfirm, rest | kMotorsOn);
  set(kAutonomous, kByItself, rest | kByHand);
  set(kImuLost, kImuIsLost, kImuIsGood);
  set(kButtonIn, kButtonIsIn, kButtonIsOut);
  set(kPowerBad, kPowerIsBad, kPowerIsGood);
}

constexpr std::uint8_t m(Mode mode) { return static_cast<std::uint8_t>(mode); }
constexpr std::uint8_t g(Goal goal) { return static_cast<std::uint8_t>(goal); }

// It went to another mode. Nothing moves before the motors are on.
constexpr Row now_in(lc::Event event, Mode mode) {
  const lc::GuardSet guards = mode == Mode::stopped ? lc::GuardSet{0} : kMotors;
  return {event,   kOperational, kReady & ~in_mode(mode),
          guards,  kKeep,        State::operational,
          m(mode), kKeep,        0};
}
// The goal is given up: it stands, ready for another command. A stop that was ordered before goes
// on.
constexpr Row give_up(lc::Event event, Goal goal) {
  Row row = aim(event, kReady, 0, Goal::none, lc::ActionSet{kHalt} | kByHand);
  row.goal = g(goal);
  return row;
}
// Only flags change.
constexpr Row stay(lc::Event event, lc::StateSet from, lc::ActionSet actions) {
  return lc::stay(event, from, lc::kAnyMode, 0, actions);
}
constexpr Row emergency(lc::Event event, lc::ActionSet actions) {
  return {event,
          kOperational,
          lc::kAnyMode,
          0,
          kKeep,
          State::fatal_error,
          0,
          0,
          actions | lc::kEmergencyStop};
}

constexpr std::array kRows = {
    Row{event::start, kIdle, 0, kMayStart, kKeep, State::operational, m(Mode::warning),
        g(Goal::none), lc::ActionSet{kBeacon} | lc::kTakeAuthority},
    Row{event::warned, kOperational, kWarning, 0, kKeep, State::operational, m(Mode::stopped),
        g(Goal::none), kMotorsOn},
    Row{event::motors_confirmed, kOperational, kReady, 0, kKeep, State::operational, kKeep, kKeep,
        kConfirm},

    stay(event::stop, kIdle, 0),
    off(event::stop, kWarning | kStopped, kKeep),
    aim(event::stop, kMoving, 0, Goal::idle, lc::ActionSet{kHalt} | kByHand),
    break_off(event::stop),

    aim(event::drive, kReady, kMotors, Goal::drive,
        lc::ActionSet{kDrive} | kByHand | lc::kTakeAuthority),
    aim(event::drive_autonomous, kReady, kMotors | lc::guard(kImuTrusted), Goal::drive,
        lc::ActionSet{kDrive} | kByItself | lc::kTakeAuthority),
    aim(event::park, kReady, kMotors, Goal::park,
        lc::ActionSet{kPark} | kByHand | lc::kTakeAuthority),
    aim(event::halt, kReady, kMotors, Goal::none,
        lc::ActionSet{kHalt} | kByHand | lc::kTakeAuthority),

    off(lc::Event::lease_expired, kWarning | kStopped, kKeep),
    aim(lc::Event::lease_expired, kMoving, kHeld, Goal::idle,
        lc::ActionSet{kHalt} | kByHand | lc::kReleaseAuthority),

    off(event::is_stopped, kMoving, g(Goal::idle)),
    now_in(event::is_stopped, Mode::stopped),
    now_in(event::is_steering, Mode::steering),
    now_in(event::is_running, Mode::running),
    now_in(event::is_parking, Mode::parking),
    now_in(event::is_decelerating, Mode::decelerating),

    stay(event::imu_good, lc::kAnyState, kImuIsGood),
    stay(event::imu_lost, lc::kAnyState, kImuIsLost),
    give_up(event::autonomy_lost, Goal::drive),
    give_up(event::stuck, Goal::drive),
    give_up(event::stuck, Goal::park),
    stay(event::button_out, lc::kAnyState, kButtonIsOut),
    emergency(event::button_in, kButtonIsIn),
    stay(event::button_in, kIdle | kFatal | kSolving, kButtonIsIn),
    stay(event::power_good, lc::kAnyState, kPowerIsGood),
    emergency(event::power_bad, kPowerIsBad),
    stay(event::power_bad, kIdle | kFatal | kSolving, kPowerIsBad),

    Row{event::isolate, kSolving, 0, lc::guard(lc::kInService) | lc::guard(kEnoughWheels), kKeep,
        State::idle, kKeep, kKeep, lc::ActionSet{lc::kIsolate} | lc::kMotorsOff},
};
constexpr lc::Rows kIndexed(kRows);

constexpr std::array kEvents = {
    lc::EventInfo{event::start, "start", true, 0, kind_of(lss::CommandKind::start)},
    lc::EventInfo{event::stop, "stop", true, 0, kind_of(lss::CommandKind::stop)},
    lc::EventInfo{event::drive, "drive", true, 0, kind_of(CommandKind::drive)},
    lc::EventInfo{event::drive_autonomous, "drive autonomous", true, 0},
    lc::EventInfo{event::park, "park", true, 0, kind_of(CommandKind::park)},
    lc::EventInfo{event::halt, "halt", true, 0, kind_of(CommandKind::halt)},
    lc::EventInfo{event::warned, "beacon ran", false, 0},
    lc::EventInfo{event::motors_confirmed, "motors confirmed", false, 0},
    lc::EventInfo{event::is_stopped, "is stopped", false, 0},
    lc::EventInfo{event::is_steering, "is steering", false, 0},
    lc::EventInfo{event::is_running, "is running", false, 0},
    lc::EventInfo{event::is_parking, "is parking", false, 0},
    lc::EventInfo{event::is_decelerating, "is decelerating", false, 0},
    lc::EventInfo{event::imu_good, "IMU good", false, 0},
    lc::EventInfo{event::imu_lost, "IMU lost", false, 0},
    lc::EventInfo{event::button_out, "button released", false, 0},
    lc::EventInfo{event::button_in, "button pressed", false, 0},
    lc::EventInfo{event::power_good, "power good", false, 0},
    lc::EventInfo{event::power_bad, "power bad", false, 0},
    lc::EventInfo{event::autonomy_lost, "autonomy lost", false, 0},
    lc::EventInfo{event::isolate, "isolate", false, kDriveWheels},
    lc::EventInfo{event::stuck, "stuck", false, 0},
};

}  // namespace

// The IMU is not among the modules that must answer: the rover drives by hand without it.
const lc::Table kTable{.rows = &kIndexed,
                       .events = kEvents,
                       .modules = kBusNodes - 1,
                       .guard_names = kGuardNames,
                       .guard = guard,
                       .effect = effect,
                       .common = &lc::kCommonRows};

namespace {

lc::Event event_of(const Request& r) noexcept {
  if (r.kind == kind_of(CommandKind::drive) && arguments<Drive>(r).autonomous)
    return event::drive_autonomous;
  return lss::event_of(kTable, r);
}

// drive and park never end by themselves.
bool reached(std::uint16_t kind, const SupervisorState& state) noexcept {
  if (done_at_once(kind)) return true;
  const lc::ControllerState& s = state.controller;
  const bool ready = s.state == State::operational && (s.flags & kMotorsConfirmed) != 0;
  const bool stopped = s.mode == m(Mode::stopped);
  switch (static_cast<lss::CommandKind>(kind)) {
    case lss::CommandKind::start: return ready && stopped;
    case lss::CommandKind::stop: return s.state == State::idle && state.sense[kSenseMotorsOn] == 0;
    case lss::CommandKind::solve: return s.state == State::idle;
    default: break;
  }
  return static_cast<CommandKind>(kind) == CommandKind::halt && ready && stopped;
}

Verdict sense(const SupervisorState& state, const Request& r) noexcept {
  const double cap_m_s = state.sense[kSenseCap];
  if (r.kind == kind_of(lss::CommandKind::start)) {
    const auto start = arguments<Start>(r);
    const double asked_m_s = start.speed_m_s > 0
                                 ? start.speed_m_s
                                 : kSpeedLimits_m_s[static_cast<std::size_t>(start.limit)];
    if (asked_m_s <= cap_m_s) return {};
    return {.reason = reasons::over_cap, .measured = asked_m_s, .limit = cap_m_s};
  }
  const bool drives = r.kind == kind_of(CommandKind::drive);
  if (!drives && r.kind != kind_of(CommandKind::park)) return {};
  const double speed_m_s =
      std::abs(drives ? arguments<Drive>(r).speed_m_s : arguments<Park>(r).speed_m_s);
  if (speed_m_s > cap_m_s)
    return {.reason = reasons::over_cap, .measured = speed_m_s, .limit = cap_m_s};
  const double limit_m_s = state.sense[kSenseLimit];
  if (speed_m_s > limit_m_s)
    return {.reason = reasons::over_limit, .measured = speed_m_s, .limit = limit_m_s};
  constexpr double kRounding_rad = 1e-9;  // of degrees
  const double heading_rad = drives ? std::abs(arguments<Drive>(r).heading_rad) : 0;
  const double most_rad = state.sense[kSenseHeading];
  if (heading_rad <= most_rad + kRounding_rad) return {};
  return {.reason = reasons::over_heading, .measured = heading_rad, .limit = most_rad};
}

}  // namespace

const Logic& logic() noexcept {
  static const Logic kLogic{.table = &kTable,
                            .event_of = event_of,
                            .reached = reached,
                            .commands = kCommands,
                            .sense = sense,
                            .tunables = tuning().infos,
                            .codes = kOwnCodes};
  return kLogic;
}

}  // namespace lss::ardito
