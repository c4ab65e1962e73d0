#include "daemon/vehicles/zebro/modes.h"

#include <array>
#include <cmath>
#include <numbers>

#include "daemon/cycle/common_commands.h"
#include "daemon/vehicles/zebro/tunables.h"
#include "gnc/zebro/locomotion.h"
#include "idl/angles.h"
#include "idl/zebro/codes.h"

namespace lss::zebro {
namespace {

using lc::aim, lc::break_off, lc::off, lc::in_mode;
using lc::kIdle, lc::kOperational, lc::kSolving, lc::kContact, lc::kKeep;
using lc::Row;

constexpr lc::StateSet kSafe = lc::in(State::idle) | lc::in(State::fatal_error);
constexpr lc::ModeSet kHolding = in_mode(Mode::holding), kStandingUp = in_mode(Mode::standing_up),
                      kStanding = in_mode(Mode::standing), kWalking = in_mode(Mode::walking),
                      kFinishing = in_mode(Mode::finishing_step),
                      kLyingDown = in_mode(Mode::lying_down), kLying = in_mode(Mode::lying),
                      kStowing = in_mode(Mode::stowing), kStowed = in_mode(Mode::stowed),
                      kBridge = in_mode(Mode::bridge);

enum Guard : unsigned {
  kPanelIn = lc::kVehicleGuards,
  kPanelStill,
  kMotorsOnConfirmed,
  kEnoughLegs,  // to stand and walk on without the subject
  kPanelLost,   // its module does not answer
  kPanelServed,
};
constexpr const char* kGuardNames[] = {"the panel is in",
                                       "the panel is still",
                                       "all motors are confirmed on",
                                       "the other legs can stand and walk",
                                       "the panel's module does not answer",
                                       "the panel's module is in service"};
constexpr lc::GuardSet kInService = lc::guard(lc::kInService),
                       kPanelAtRest = lc::guard(kPanelStill) | lc::guard(kPanelServed),
                       kMotors = lc::guard(kMotorsOnConfirmed);
constexpr lc::GuardSet kMayStart = lc::kMayStart | lc::guard(kPanelIn);

Verdict guard(unsigned number, const lc::ControllerState& s, unsigned subject) {
  switch (number) {
    case kPanelIn:
      if (s.flags & kPanelOut) return {.reason = reasons::panel_deployed, .subject = kModules};
      break;
    case kPanelStill:
      if (s.flags & kPanelMoving) return {.reason = reasons::panel_moving, .subject = kModules};
      break;
    case kMotorsOnConfirmed:
      if (!(s.flags & kMotorsConfirmed)) return {.reason = Reason::motors_not_on};
      break;
    case kEnoughLegs: {
      const bool leg = subject >= 1 && subject <= kLegs;
      if (!leg || !enough_legs_without(s.isolated | 1u << (subject - 1)))
        return {.reason = reasons::not_stable, .subject = static_cast<std::uint16_t>(subject)};
      break;
    }
    case kPanelLost:
      if (((s.silent | s.unheard) >> (kModules - 1) & 1u) == 0)
        return {.reason = reasons::panel_answers, .subject = kModules};
      break;
    case kPanelServed:
      if ((s.isolated >> (kModules - 1) & 1u) != 0)
        return {.reason = Reason::isolated, .subject = kModules};
      break;
    default: break;
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
  if (actions & (lc::kEmergencyStop | lc::kMotorsOff))
    clear(kMotorsConfirmed | kPanelMoving | kFreeing);
  if (actions & kMotorsOn) clear(kMotorsConfirmed);
  if (actions & kConfirm) set(kMotorsConfirmed);
  if (actions & kPanelDeploy) set(kPanelOut | kPanelMoving);
  if (actions & kPanelRetract) set(kPanelOut | kPanelMoving);
  if (actions & kPanelIsOut) {
    set(kPanelOut);
    clear(kPanelMoving);
  }
  if (actions & kPanelIsIn) clear(kPanelOut | kPanelMoving);
  if (actions & kPanelStop) clear(kPanelMoving);
  if (actions & kFreeLeg) set(kFreeing);
  if (actions & kPanelForgone) {
    constexpr unsigned kPanel = 1u << (kModules - 1);
    s.isolated = static_cast<std::uint16_t>(s.isolated | kPanel);
    s.silent = static_cast<std::uint16_t>(s.silent & ~kPanel);
    s.unheard = static_cast<std::uint16_t>(s.unheard & ~kPanel);
  }
}

constexpr std::uint8_t m(Mode mode) { return static_cast<std::uint8_t>(mode); }
constexpr std::uint8_t g(Goal goal) { return static_cast<std::uint8_t>(goal); }

// A row inside Operational. The source of the command has had authority since start, unless the
// lease expired and a stop is in progress: only those rows take it.
constexpr Row move(lc::Event event, lc::ModeSet from, lc::GuardSet guards, Mode to, Goal goal,
                   lc::ActionSet actions) {
  return {event, kOperational, from, guards, kKeep, State::operational, m(to), g(goal), actions};
}
// Already there: accepted, nothing to do.
constexpr Row stay(lc::Event event, lc::ModeSet from, lc::ActionSet actions) {
  return lc::stay(event, kOperational, from, 0, actions);
}
// The running motion has ended and the goal determines the next.
constexpr Row done(lc::ModeSet from, Goal goal, Mode to, Goal next, lc::ActionSet actions) {
  return {event::motion_done, kOperational, from,    0,      g(goal),
          State::operational, m(to),        g(next), actions};
}
// Outside Operational.
constexpr Row in_state(lc::StateSet from, lc::Event event, lc::GuardSet guards,
                       lc::ActionSet actions) {
  return lc::stay(event, from, 0, guards, actions);
}
constexpr Row begin(lc::Event event, Goal goal) {
  return {event,
          kIdle,
          0,
          kMayStart,
          kKeep,
          State::operational,
          m(Mode::holding),
          g(goal),
          lc::ActionSet{kMotorsOn} | lc::kTakeAuthority};
}

constexpr lc::ModeSet kAtRest = kHolding | kLying | kStowed | kBridge;

constexpr lc::GuardSet kHeld = lc::guard(lc::kAuthorityHeld);

constexpr std::array kRows = {
    begin(event::start, Goal::none),
    begin(event::start_stand, Goal::stand),
    begin(event::start_walk, Goal::walk),

    Row{event::motors_confirmed, kOperational, kHolding, 0, g(Goal::stand), State::operational,
        m(Mode::standing_up), g(Goal::stand), kConfirm | kStandUp},
    Row{event::motors_confirmed, kOperational, kHolding, 0, g(Goal::walk), State::operational,
        m(Mode::standing_up), g(Goal::walk), kConfirm | kStandUp},
    Row{event::motors_confirmed, kOperational, kHolding, 0, kKeep, State::operational, kKeep, kKeep,
        kConfirm},

    move(event::stand, kAtRest, kMotors, Mode::standing_up, Goal::stand, kStandUp),
    move(event::stand, kWalking, 0, Mode::finishing_step, Goal::stand, kFinishStep),
    aim(event::stand, kStandingUp | kFinishing, 0, Goal::stand, lc::kTakeAuthority),
    stay(event::stand, kStanding, 0),

    move(event::walk, kStanding | kWalking, 0, Mode::walking, Goal::none, kWalk),
    move(event::walk_zero, kWalking, 0, Mode::finishing_step, Goal::stand, kFinishStep),
    stay(event::walk_zero, kStanding | kFinishing, lc::kTakeAuthority),

    move(event::lay_down, kHolding | kStanding | kStowed | kBridge, kMotors, Mode::lying_down,
         Goal::none, kLayDown),
    move(event::lay_down, kWalking, 0, Mode::finishing_step, Goal::lie, kFinishStep),
    aim(event::lay_down, kFinishing, 0, Goal::lie, lc::kTakeAuthority),
    aim(event::lay_down, kLyingDown, 0, Goal::none, lc::kTakeAuthority),
    stay(event::lay_down, kLying, 0),

    move(event::stow, kHolding | kStanding | kLying | kBridge, kMotors, Mode::stowing, Goal::none,
         kStow),
    move(event::stow, kWalking, 0, Mode::finishing_step, Goal::stow, kFinishStep),
    aim(event::stow, kFinishing, 0, Goal::stow, lc::kTakeAuthority),
    aim(event::stow, kStowing, 0, Goal::none, lc::kTakeAuthority),
    stay(event::stow, kStowed, 0),

    move(event::leg, kAtRest | kStanding, kMotors, Mode::bridge, Goal::leg, kMoveLeg),

    in_state(kIdle, event::stop, 0, kPanelStop),
    off(event::stop, kAtRest | kStanding, kKeep),
    move(event::stop, kWalking, 0, Mode::finishing_step, Goal::idle, kFinishStep),
    aim(event::stop, kStandingUp | kFinishing | kLyingDown | kStowing, 0, Goal::idle, 0),
    break_off(event::stop),

    in_state(kIdle, event::stop_lay_down, 0, kPanelStop),
    off(event::stop_lay_down, kHolding | kLying | kStowed, kKeep),
    move(event::stop_lay_down, kStandingUp | kStanding | kBridge, 0, Mode::lying_down, Goal::idle,
         kLayDown),
    move(event::stop_lay_down, kWalking, 0, Mode::finishing_step, Goal::lie_idle, kFinishStep),
    aim(event::stop_lay_down, kFinishing, 0, Goal::lie_idle, 0),
    aim(event::stop_lay_down, kLyingDown | kStowing, 0, Goal::idle, 0),
    break_off(event::stop_lay_down),

    off(lc::Event::lease_expired, kHolding | kLying | kStowed, kKeep),
    move(lc::Event::lease_expired, kStandingUp | kStanding | kBridge, 0, Mode::lying_down,
         Goal::idle, lc::ActionSet{kLayDown} | lc::kReleaseAuthority),
    move(lc::Event::lease_expired, kWalking, 0, Mode::finishing_step, Goal::lie_idle,
         lc::ActionSet{kFinishStep} | lc::kReleaseAuthority),
    aim(lc::Event::lease_expired, kFinishing, kHeld, Goal::lie_idle, lc::kReleaseAuthority),
    aim(lc::Event::lease_expired, kLyingDown | kStowing, kHeld, Goal::idle, lc::kReleaseAuthority),

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

    in_state(kIdle, event::panel_deploy, kContact | kPanelAtRest, kPanelDeploy),
    in_state(kIdle, event::panel_retract, kContact | kPanelAtRest, kPanelRetract),
    in_state(kIdle, event::panel_arrived_in, 0, kPanelIsIn),
    in_state(kIdle, event::panel_arrived_out, 0, kPanelIsOut),
    in_state(kIdle | lc::in(State::fatal_error) | kSolving, event::panel_seen_out, 0, kPanelIsOut),
    Row{event::panel_seen_out, kOperational, lc::kAnyMode, 0, kKeep, State::fatal_error, 0, 0,
        lc::ActionSet{kPanelIsOut} | lc::kEmergencyStop},

    in_state(kSolving, event::free_leg, kInService | lc::guard(lc::kPortOpen), kFreeLeg),
    in_state(kSolving, event::leg_freed, 0, lc::kMotorsOff),
    in_state(kSolving, event::isolate, kInService | lc::guard(kEnoughLegs),
             lc::ActionSet{lc::kIsolate} | lc::kMotorsOff),

    in_state(kSafe, event::isolate_leg, kInService | lc::guard(kEnoughLegs), lc::kIsolate),
    in_state(kSafe, event::restore_leg, 0, lc::kRestore),
    in_state(kSafe, event::panel_is_in, lc::guard(kPanelLost),
             lc::ActionSet{kPanelForgone} | kPanelIsIn),
};
constexpr lc::Rows kIndexed(kRows);

constexpr std::array kEvents = {
    lc::EventInfo{event::start, "start", true, 0},
    lc::EventInfo{event::start_stand, "start stand", true, 0},
    lc::EventInfo{event::start_walk, "start walk", true, 0},
    lc::EventInfo{event::stop, "stop", true, 0},
    lc::EventInfo{event::stop_lay_down, "stop lay-down", true, 0},
    lc::EventInfo{event::stand, "stand", true, 0, kind_of(CommandKind::stand)},
    lc::EventInfo{event::lay_down, "lay-down", true, 0, kind_of(CommandKind::lay_down)},
    lc::EventInfo{event::stow, "stow", true, 0, kind_of(CommandKind::stow)},
    lc::EventInfo{event::walk, "walk", true, 0, kind_of(CommandKind::walk)},
    lc::EventInfo{event::walk_zero, "walk zero", true, 0},
    lc::EventInfo{event::leg, "leg", true, kLegs, kind_of(CommandKind::leg)},
    lc::EventInfo{event::panel_deploy, "panel deploy", true, 0},
    lc::EventInfo{event::panel_retract, "panel retract", true, 0},
    lc::EventInfo{event::motors_confirmed, "motors confirmed", false, 0},
    lc::EventInfo{event::motion_done, "motion done", false, 0},
    lc::EventInfo{event::panel_arrived_in, "panel arrived in", false, 0},
    lc::EventInfo{event::panel_arrived_out, "panel arrived out", false, 0},
    lc::EventInfo{event::panel_seen_out, "panel seen out", false, 0},
    lc::EventInfo{event::free_leg, "free leg", false, kLegs},
    lc::EventInfo{event::leg_freed, "leg freed", false, 0},
    lc::EventInfo{event::isolate, "isolate", false, lc::kEachModule},
    lc::EventInfo{event::isolate_leg, "isolate leg", true, kLegs, kind_of(CommandKind::isolate)},
    lc::EventInfo{event::restore_leg, "restore leg", true, kLegs,
                  kind_of(CommandKind::restore_leg)},
    lc::EventInfo{event::panel_is_in, "panel is in", true, 0, kind_of(CommandKind::panel_is_in)},
};

// Computed once, at start-up.
const auto kEnoughLegsWithout = [] {
  std::array<bool, 1u << kLegs> enough{};
  for (std::size_t i = 0; i < enough.size(); ++i)
    enough[i] = gnc::zebro::can_walk_without(static_cast<gnc::zebro::LegSet>(i));
  return enough;
}();

}  // namespace

bool enough_legs_without(unsigned isolated) noexcept {
  return kEnoughLegsWithout[isolated % kEnoughLegsWithout.size()];  // the panel is no leg
}

const lc::Table kTable{&kIndexed, kEvents, kModules, kGuardNames, guard, effect, &lc::kCommonRows};

lc::Event event_of(const Request& r) noexcept {
  if (r.kind == kind_of(lss::CommandKind::start)) {
    constexpr std::array kStarts = {event::start, event::start_stand, event::start_walk};
    return kStarts[static_cast<std::size_t>(arguments<Start>(r).then)];
  }
  if (r.kind == kind_of(lss::CommandKind::stop))
    return arguments<SafeStop>(r).lay_down ? event::stop_lay_down : event::stop;
  if (r.kind == kind_of(CommandKind::walk) && arguments<Walk>(r).speed == WalkSpeed::zero)
    return event::walk_zero;
  if (r.kind == kind_of(CommandKind::panel))
    return arguments<MovePanel>(r).deploy ? event::panel_deploy : event::panel_retract;
  return lss::event_of(kTable, r);
}

namespace {

unsigned subject_of(const Request& r) noexcept {
  if (r.kind == kind_of(CommandKind::leg)) return arguments<MoveLeg>(r).leg;
  if (r.kind == kind_of(CommandKind::isolate) || r.kind == kind_of(CommandKind::restore_leg))
    return arguments<OneLeg>(r).leg;
  return 0;
}

bool reached(std::uint16_t kind, const SupervisorState& state) noexcept {
  if (done_at_once(kind)) return true;
  const lc::ControllerState& s = state.controller;
  const auto mode = static_cast<Mode>(s.mode);
  const bool operational = s.state == State::operational;
  switch (static_cast<lss::CommandKind>(kind)) {
    case lss::CommandKind::start:
      return operational && (s.flags & kMotorsConfirmed) && s.goal == g(Goal::none);
    case lss::CommandKind::stop: return s.state == State::idle && state.sense[kSenseMotorsOn] == 0;
    case lss::CommandKind::solve: return s.state == State::idle;
    default: break;
  }
  switch (static_cast<CommandKind>(kind)) {
    case CommandKind::stand: return operational && mode == Mode::standing;
    case CommandKind::lay_down: return operational && mode == Mode::lying;
    case CommandKind::stow: return operational && mode == Mode::stowed;
    case CommandKind::panel: return s.state == State::idle && !(s.flags & kPanelMoving);
    case CommandKind::walk: return operational && mode == Mode::standing;  // with speed zero
    case CommandKind::leg: return operational && mode == Mode::bridge && s.goal == g(Goal::none);
    case CommandKind::isolate:
    case CommandKind::panel_is_in:
    case CommandKind::restore_leg: return true;
  }
  return false;
}

Verdict sense(const SupervisorState& state, const Request& r) noexcept {
  const CommandInfo* info = find_command(kCommands, r.kind);
  const double longest_ms = state.sense[kSenseLongestLease];
  if (info != nullptr && info->leased && longest_ms > 0 && r.lease_ms > longest_ms)
    return {.reason = Reason::bad_lease,
            .measured = static_cast<double>(r.lease_ms),
            .limit = longest_ms};
  const auto tripped = static_cast<std::uint16_t>(state.sense[kSenseTripped]);
  if (r.kind == kind_of(lss::CommandKind::start) && tripped != 0)
    return {.reason = reasons::fault_latched, .subject = tripped};
  const auto unstable = static_cast<std::uint16_t>(state.sense[kSenseUnstable]);
  if (r.kind == kind_of(lss::CommandKind::start) && unstable != 0)
    return {.reason = reasons::not_stable, .subject = unstable};
  const double rounds = state.sense[kSenseSolveRounds], limit = state.sense[kSenseSolveLimit];
  if (r.kind == kind_of(lss::CommandKind::solve) && limit > 0 && rounds >= limit)
    return {.reason = reasons::solved_too_often,
            .measured = rounds,
            .limit = limit,
            .subject = static_cast<std::uint16_t>(state.sense[kSenseSolveModule])};
  if (r.kind != kind_of(CommandKind::leg)) return {};
  constexpr double kRound_rad = 2 * std::numbers::pi;
  const auto move = arguments<MoveLeg>(r);
  const double from_rad = state.sense[move.leg - 1];
  const double forward_rad = std::fmod(move.position_rad - from_rad + 2 * kRound_rad, kRound_rad);
  double way_rad = move.forward ? forward_rad : kRound_rad - forward_rad;
  constexpr double kGoBack_rad = 5 * kDegree;  // docs/icd-zebro.md section 6
  if (way_rad > kRound_rad - kGoBack_rad) way_rad = kRound_rad - way_rad;
  const double rate_rad_s = way_rad / move.duration_s;
  const double limit_rad_s = state.sense[kSenseTurnLimit];
  if (rate_rad_s <= limit_rad_s || std::isnan(rate_rad_s)) return {};
  return {.reason = reasons::too_fast,
          .measured = rate_rad_s,
          .limit = limit_rad_s,
          .subject = static_cast<std::uint16_t>(move.leg)};
}

// Whether the configured gaits can do without a leg is the vehicle's to say.
bool considered(std::uint16_t kind) noexcept { return kind == kind_of(CommandKind::isolate); }

}  // namespace

Request isolation_of(unsigned module) noexcept {
  const bool panel = module == kModules;
  Request request{.kind = kind_of(panel ? CommandKind::panel_is_in : CommandKind::isolate)};
  if (!panel) request.parameter[0] = module;
  return request;
}

const Logic& logic() noexcept {
  static const Logic kLogic{.table = &kTable,
                            .event_of = event_of,
                            .subject_of = subject_of,
                            .reached = reached,
                            .commands = kCommands,
                            .sense = sense,
                            .considered = considered,
                            .tunables = tuning().infos,
                            .codes = kOwnCodes,
                            .isolation_of = isolation_of};
  return kLogic;
}

}  // namespace lss::zebro
