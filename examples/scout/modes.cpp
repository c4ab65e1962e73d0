#include "modes.h"

#include "daemon/cycle/common_commands.h"
#include "vehicle.h"

namespace lss::scout {
namespace {

using lc::break_off, lc::in_mode, lc::off, lc::stay;
using lc::kIdle, lc::kKeep, lc::kOperational;

constexpr std::uint8_t m(Mode mode) { return static_cast<std::uint8_t>(mode); }
constexpr std::uint8_t kOff = static_cast<std::uint8_t>(Goal::off);
constexpr lc::ModeSet kRests = in_mode(Mode::enabling) | in_mode(Mode::ready);
constexpr lc::ModeSet kMoves = in_mode(Mode::driving) | in_mode(Mode::stopping);

constexpr lc::Row slow_down(lc::Event event, lc::ModeSet from, lc::GuardSet guards,
                            lc::ActionSet actions) {
  return {event, kOperational,   from, guards, kKeep, State::operational, m(Mode::stopping),
          kOff,  kHalt | actions};
}

// event, from: states, modes, guards, goal; to: state, mode, goal; actions
constexpr std::array kRows = {
    lc::Row{event::start, kIdle, 0, lc::kMayStart, kKeep, State::operational, m(Mode::enabling), 0,
            lc::ActionSet{kMotorsOn} | lc::kTakeAuthority},
    stay(event::stop, kIdle, lc::kAnyMode, 0, 0),
    off(event::stop, kRests, kKeep),
    slow_down(event::stop, kMoves, 0, 0),
    break_off(event::stop),
    lc::Row{event::drive, kOperational, in_mode(Mode::ready) | kMoves, 0, kKeep, State::operational,
            m(Mode::driving), 0, lc::ActionSet{kDrive} | lc::kTakeAuthority},
    off(lc::Event::lease_expired, kRests, kKeep),
    slow_down(lc::Event::lease_expired, kMoves, lc::guard(lc::kAuthorityHeld),
              lc::kReleaseAuthority),
    lc::Row{event::motors_confirmed, kOperational, in_mode(Mode::enabling), 0, kKeep,
            State::operational, m(Mode::ready), 0, 0},
    off(event::stands, in_mode(Mode::stopping), kKeep),
};
constexpr lc::Rows kIndexed(kRows);

constexpr std::array kEvents = {
    lc::EventInfo{event::start, "start", true, 0, kStartCommand},
    lc::EventInfo{event::stop, "stop", true, 0, kStopCommand},
    lc::EventInfo{event::drive, "drive", true, 0, kDriveCommand},
    lc::EventInfo{event::motors_confirmed, "motors confirmed", false, 0},
    lc::EventInfo{event::stands, "stands", false, 0},
};

// Whether the command's goal has been reached; drive never ends by itself.
bool reached(std::uint16_t kind, const SupervisorState& state) noexcept {
  if (done_at_once(kind)) return true;
  const lc::ControllerState& s = state.controller;
  if (kind == kStartCommand) return s.mode == m(Mode::ready);
  const bool to_idle =
      kind == kStopCommand || kind == static_cast<std::uint16_t>(CommandKind::solve);
  return to_idle ? s.state == State::idle : kind != kDriveCommand;
}

}  // namespace

const lc::Table kTable{
    .rows = &kIndexed,
    .events = kEvents,
    .modules = kDrives,
    .guard_names = {},
    .guard = [](unsigned, const lc::ControllerState&, unsigned) { return Verdict{}; },
    .effect = [](lc::ActionSet, lc::ControllerState&) {},
    .common = &lc::kCommonRows};

const Logic& logic() noexcept {
  static const Logic kLogic{
      .table = &kTable,
      .event_of = [](const Request& request) { return lss::event_of(kTable, request); },
      .reached = reached,
      .commands = kCommands,
      .tunables = tuning().infos,
      .codes = {.faults = kFaults}};
  return kLogic;
}

}  // namespace lss::scout
