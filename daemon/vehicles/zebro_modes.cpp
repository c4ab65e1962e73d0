#include "daemon/vehicles/zebro_modes.h"

#include <array>
#include <bit>
#include <cmath>
#include <numbers>

namespace lss::zebro {
namespace {

using lc::kKeep;
using lc::Row;

constexpr lc::StateSet kIdle = lc::in(State::idle), kOperational = lc::in(State::operational);

constexpr lc::ModeSet in(Mode mode) { return 1u << static_cast<unsigned>(mode); }
constexpr lc::ModeSet kHolding = in(Mode::holding), kStandingUp = in(Mode::standing_up),
                      kStanding = in(Mode::standing), kWalking = in(Mode::walking),
                      kFinishing = in(Mode::finishing_step), kLyingDown = in(Mode::lying_down),
                      kLying = in(Mode::lying), kStowing = in(Mode::stowing),
                      kStowed = in(Mode::stowed), kBridge = in(Mode::bridge);

enum GuardBit : unsigned { port, heard, answering, panel_in, panel_still, motors_on };
constexpr lc::GuardSet bit(GuardBit g) { return static_cast<lc::GuardSet>(1u << g); }
constexpr lc::GuardSet kContact = bit(port) | bit(heard) | bit(answering);
constexpr lc::GuardSet kMayStart = kContact | bit(panel_in) | bit(panel_still);
constexpr lc::GuardSet kMotors = bit(motors_on);

Verdict guard(unsigned number, const lc::ControllerState& s) {
  const auto first = [](std::uint16_t mask) {
    return static_cast<std::uint16_t>(std::countr_zero(mask) + 1);
  };
  switch (number) {
    case port:
      if (s.flags & kPortClosed) return {.reason = Reason::port_closed};
      break;
    case heard:
      if (s.unheard) return {.reason = Reason::never_heard, .subject = first(s.unheard)};
      break;
    case answering:
      if (s.silent) return {.reason = Reason::module_silent, .subject = first(s.silent)};
      break;
    case panel_in:
      if (s.flags & kPanelOut) return {.reason = Reason::panel_deployed, .subject = kModules};
      break;
    case panel_still:
      if (s.flags & kPanelMoving) return {.reason = Reason::panel_moving, .subject = kModules};
      break;
    case motors_on:
      if (!(s.flags & kMotorsConfirmed)) return {.reason = Reason::motors_not_on};
      break;
    default:
      break;
  }
  return {};
}

void effect(lc::ActionSet actions, lc::ControllerState& s) {
  const auto set = [&](std::uint8_t flags) {
    s.flags = static_cast<std::uint8_t>(s.flags | flags);
  };
  const auto clear = [&](std::uint8_t flags) {
    s.flags = static_cast<std::uint8_t>(s.flags & ~flags);
  };
  if (actions & (lc::kEmergencyStop | lc::kMotorsOff)) clear(kMotorsConfirmed | kPanelMoving);
  if (actions & kMotorsOn) clear(kMotorsConfirmed);
  if (actions & kConfirm) set(kMotorsConfirmed);
  if (actions & kPanelDeploy) set(kPanelOut | kPanelMoving);
  if (actions & kPanelRetract) set(kPanelOut | kPanelMoving);
  if (actions & kPanelIsOut) {
    set(kPanelOut);
    clear(kPanelMoving);
  }
  if (actions & kPanelIsIn) clear(kPanelOut | kPanelMoving);
}

constexpr std::uint8_t m(Mode mode) { return static_cast<std::uint8_t>(mode); }
constexpr std::uint8_t g(Goal goal) { return static_cast<std::uint8_t>(goal); }

// A row inside Operational.
constexpr Row move(lc::Event event, lc::ModeSet from, lc::GuardSet guards, Mode to, Goal goal,
                   lc::ActionSet actions) {
  return {event, kOperational, from, guards, kKeep, State::operational, m(to), g(goal), actions};
}
// Only the goal changes: the running motion goes on.
constexpr Row aim(lc::Event event, lc::ModeSet from, Goal goal) {
  return {event, kOperational, from, 0, kKeep, State::operational, kKeep, g(goal), 0};
}
// The running motion has ended and the goal says what is next.
constexpr Row done(lc::ModeSet from, Goal goal, Mode to, Goal next, lc::ActionSet actions) {
  return {event::motion_done, kOperational, from,    0,      g(goal),
          State::operational, m(to),        g(next), actions};
}
constexpr Row off(lc::Event event, lc::ModeSet from, std::uint8_t goal) {
  return {event,
          kOperational,
          from,
          0,
          goal,
          State::idle,
          0,
          0,
          lc::kMotorsOff | lc::kReleaseAuthority};
}
// Already there: accepted, nothing to do.
constexpr Row stay(lc::Event event, lc::ModeSet from) {
  return {event, kOperational, from, 0, kKeep, State::operational, kKeep, kKeep, 0};
}

constexpr lc::ModeSet kAtRest = kHolding | kLying | kStowed | kBridge;

constexpr std::array kRows = {
    Row{event::start, kIdle, 0, kMayStart, kKeep, State::operational, m(Mode::holding),
        g(Goal::none), kMotorsOn},
    Row{event::start_stand, kIdle, 0, kMayStart, kKeep, State::operational, m(Mode::holding),
        g(Goal::stand), kMotorsOn},
    Row{event::start_walk, kIdle, 0, kMayStart, kKeep, State::operational, m(Mode::holding),
        g(Goal::walk), kMotorsOn},

    Row{event::motors_confirmed, kOperational, kHolding, 0, g(Goal::stand), State::operational,
        m(Mode::standing_up), g(Goal::stand), kConfirm | kStandUp},
    Row{event::motors_confirmed, kOperational, kHolding, 0, g(Goal::walk), State::operational,
        m(Mode::standing_up), g(Goal::walk), kConfirm | kStandUp},
    Row{event::motors_confirmed, kOperational, lc::kAnyMode, 0, kKeep, State::operational, kKeep,
        kKeep, kConfirm},

    move(event::stand, kAtRest, kMotors, Mode::standing_up, Goal::stand, kStandUp),
    move(event::stand, kWalking, 0, Mode::finishing_step, Goal::stand, kFinishStep),
    aim(event::stand, kStandingUp | kFinishing, Goal::stand),
    stay(event::stand, kStanding),

    move(event::walk, kStanding | kWalking, 0, Mode::walking, Goal::none, kWalk),
    move(event::walk_zero, kWalking, 0, Mode::finishing_step, Goal::stand, kFinishStep),
    stay(event::walk_zero, kStanding | kFinishing),

    move(event::lay_down, kHolding | kStanding | kStowed | kBridge, kMotors, Mode::lying_down,
         Goal::none, kLayDown),
    move(event::lay_down, kWalking, 0, Mode::finishing_step, Goal::lie, kFinishStep),
    aim(event::lay_down, kFinishing, Goal::lie),
    aim(event::lay_down, kLyingDown, Goal::none),
    stay(event::lay_down, kLying),

    move(event::stow, kHolding | kStanding | kLying | kBridge, kMotors, Mode::stowing, Goal::none,
         kStow),
    move(event::stow, kWalking, 0, Mode::finishing_step, Goal::stow, kFinishStep),
    aim(event::stow, kFinishing, Goal::stow),
    aim(event::stow, kStowing, Goal::none),
    stay(event::stow, kStowed),

    move(event::leg, kAtRest | kStanding, kMotors, Mode::bridge, Goal::leg, kMoveLeg),

    Row{event::stop, kIdle, 0, 0, kKeep, State::idle, kKeep, kKeep, 0},
    off(event::stop, kAtRest | kStanding, kKeep),
    move(event::stop, kWalking, 0, Mode::finishing_step, Goal::idle, kFinishStep),
    aim(event::stop, kStandingUp | kFinishing | kLyingDown | kStowing, Goal::idle),

    Row{event::stop_lay_down, kIdle, 0, 0, kKeep, State::idle, kKeep, kKeep, 0},
    off(event::stop_lay_down, kHolding | kLying | kStowed, kKeep),
    move(event::stop_lay_down, kStandingUp | kStanding | kBridge, 0, Mode::lying_down, Goal::idle,
         kLayDown),
    move(event::stop_lay_down, kWalking, 0, Mode::finishing_step, Goal::lie_idle, kFinishStep),
    aim(event::stop_lay_down, kFinishing, Goal::lie_idle),
    aim(event::stop_lay_down, kLyingDown | kStowing, Goal::idle),

    off(event::lease_expired, kHolding | kLying | kStowed, kKeep),
    move(event::lease_expired, kStandingUp | kStanding | kBridge, 0, Mode::lying_down, Goal::idle,
         lc::ActionSet{kLayDown} | lc::kReleaseAuthority),
    move(event::lease_expired, kWalking, 0, Mode::finishing_step, Goal::lie_idle,
         lc::ActionSet{kFinishStep} | lc::kReleaseAuthority),
    Row{event::lease_expired, kOperational, kFinishing, 0, kKeep, State::operational, kKeep,
        g(Goal::lie_idle), lc::kReleaseAuthority},
    Row{event::lease_expired, kOperational, kLyingDown | kStowing, 0, kKeep, State::operational,
        kKeep, g(Goal::idle), lc::kReleaseAuthority},

    done(kStandingUp, Goal::stand, Mode::standing, Goal::none, 0),
    done(kStandingUp, Goal::walk, Mode::walking, Goal::none, kWalk),
    off(event::motion_done, kStandingUp | kFinishing | kLyingDown | kStowing, g(Goal::idle)),
    done(kFinishing, Goal::stand, Mode::standing, Goal::none, 0),
    done(kFinishing, Goal::lie, Mode::lying_down, Goal::none, kLayDown),
    done(kFinishing, Goal::stow, Mode::stowing, Goal::none, kStow),
    done(kFinishing, Goal::lie_idle, Mode::lying_down, Goal::idle, kLayDown),
    done(kLyingDown, Goal::none, Mode::lying, Goal::none, 0),
    done(kStowing, Goal::none, Mode::stowed, Goal::none, 0),
    done(kBridge, Goal::leg, Mode::bridge, Goal::none, 0),

    Row{event::panel_deploy, kIdle, 0, kContact | bit(panel_still), kKeep, State::idle, kKeep,
        kKeep, kPanelDeploy},
    Row{event::panel_retract, kIdle, 0, kContact | bit(panel_still), kKeep, State::idle, kKeep,
        kKeep, kPanelRetract},
    Row{event::panel_arrived_in, kIdle, 0, 0, kKeep, State::idle, kKeep, kKeep, kPanelIsIn},
    Row{event::panel_arrived_out, kIdle, 0, 0, kKeep, State::idle, kKeep, kKeep, kPanelIsOut},
    Row{event::panel_seen_out, kIdle, 0, 0, kKeep, State::idle, kKeep, kKeep, kPanelIsOut},
};

}  // namespace

const lc::Table kTable{kRows, guard, effect};

lc::Event event_of(const Request& r) noexcept {
  switch (static_cast<lss::CommandKind>(r.kind)) {
    case lss::CommandKind::start: {
      constexpr std::array kStarts = {event::start, event::start_stand, event::start_walk};
      return kStarts[static_cast<std::size_t>(r.parameter[0])];
    }
    case lss::CommandKind::stop:
      return r.parameter[0] > 0.5 ? event::stop_lay_down : event::stop;
    case lss::CommandKind::emergency_stop:
      return lc::Event::emergency_stop;
    case lss::CommandKind::solve:
      return lc::Event::solve;
    case lss::CommandKind::reset:
      return r.parameter[0] < 0 ? lc::Event::reset_controller : lc::Event::reset_module;
    case lss::CommandKind::request_data:
      return lc::Event::request_data;
    case lss::CommandKind::reset_timing:
      return lc::Event::reset_timing;
    default:
      break;
  }
  switch (static_cast<CommandKind>(r.kind)) {
    case CommandKind::stand:
      return event::stand;
    case CommandKind::lay_down:
      return event::lay_down;
    case CommandKind::stow:
      return event::stow;
    case CommandKind::walk:
      return r.parameter[2] < 0.5 ? event::walk_zero : event::walk;
    case CommandKind::leg:
      return event::leg;
    case CommandKind::panel:
      return r.parameter[0] > 0.5 ? event::panel_deploy : event::panel_retract;
  }
  return lc::Event::none;
}

bool reached(std::uint16_t kind, const lc::ControllerState& s) noexcept {
  const auto mode = static_cast<Mode>(s.mode);
  const bool operational = s.state == State::operational;
  switch (static_cast<lss::CommandKind>(kind)) {
    case lss::CommandKind::start:
      return operational && (s.flags & kMotorsConfirmed) && s.goal == g(Goal::none);
    case lss::CommandKind::stop:
      return s.state == State::idle && (s.flags & kMotorsRunning) == 0;
    case lss::CommandKind::solve:
      return s.state == State::idle;
    case lss::CommandKind::emergency_stop:
    case lss::CommandKind::reset:
    case lss::CommandKind::request_data:
    case lss::CommandKind::reset_timing:
      return true;
    default:
      break;
  }
  switch (static_cast<CommandKind>(kind)) {
    case CommandKind::stand:
      return operational && mode == Mode::standing;
    case CommandKind::lay_down:
      return operational && mode == Mode::lying;
    case CommandKind::stow:
      return operational && mode == Mode::stowed;
    case CommandKind::panel:
      return !(s.flags & kPanelMoving);
    case CommandKind::walk:
      return operational && mode == Mode::standing;  // with speed zero
    case CommandKind::leg:
      return operational && mode == Mode::bridge && s.goal == g(Goal::none);
  }
  return false;
}

Verdict sense(const SupervisorState& state, const Request& r) noexcept {
  if (r.kind != static_cast<std::uint16_t>(CommandKind::leg)) return {};
  constexpr double kTurn = 2 * std::numbers::pi;
  const double from_rad = state.sense[static_cast<std::size_t>(r.parameter[0]) - 1];
  const double forward_rad = std::fmod(r.parameter[1] - from_rad + 2 * kTurn, kTurn);
  const double rate_rad_s =
      (r.parameter[3] > 0.5 ? forward_rad : kTurn - forward_rad) / r.parameter[2];
  const double limit_rad_s = state.sense[kSenseTurnLimit];
  if (rate_rad_s <= limit_rad_s || std::isnan(rate_rad_s)) return {};
  return {.reason = Reason::too_fast,
          .measured = rate_rad_s,
          .limit = limit_rad_s,
          .subject = static_cast<std::uint16_t>(r.parameter[0])};
}

const CommandInfo* command(std::uint16_t kind) noexcept {
  for (const CommandInfo& info : kCommands) {
    if (info.kind == kind) return &info;
  }
  for (const CommandInfo& info : kCommonCommands) {
    if (info.kind == kind) return &info;
  }
  return nullptr;
}

}  // namespace lss::zebro
