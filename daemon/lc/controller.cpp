#include "daemon/lc/controller.h"

#include <array>

namespace lss::lc {
namespace {

constexpr StateSet kIdle = in(State::idle), kOperational = in(State::operational),
                   kFatal = in(State::fatal_error), kSolving = in(State::solve_errors);

constexpr std::array kRows = {
    // event, from, modes, guards, goal, to, mode, goal, actions
    Row{Event::emergency_stop, kAnyState, kAnyMode, 0, kKeep, State::fatal_error, 0, 0,
        kEmergencyStop | kEndSolve | kReleaseAuthority},
    Row{Event::emergency, kIdle | kOperational | kSolving, kAnyMode, 0, kKeep, State::fatal_error,
        0, 0, kEmergencyStop | kEndSolve | kReleaseAuthority},
    Row{Event::emergency, kFatal, kAnyMode, 0, kKeep, State::fatal_error, 0, 0, 0},
    Row{Event::solve, kFatal, kAnyMode, 0, kKeep, State::solve_errors, 0, 0, kBeginSolve},
    Row{Event::solved, kSolving, kAnyMode, 0, kKeep, State::idle, 0, 0,
        kEndSolve | kClearFaults | kMotorsOff},
    Row{Event::unsolved, kSolving, kAnyMode, 0, kKeep, State::fatal_error, 0, 0,
        kEndSolve | kEmergencyStop},
    Row{Event::reset_controller, kIdle, kAnyMode, 0, kKeep, State::idle, 0, 0,
        kMotorsOff | kReleaseAuthority},
    Row{Event::reset_controller, kOperational, kAnyMode, 0, kKeep, State::idle, 0, 0,
        kEmergencyStop | kReleaseAuthority},
    Row{Event::reset_controller, kFatal | kSolving, kAnyMode, 0, kKeep, State::fatal_error, 0, 0,
        kEmergencyStop | kEndSolve | kReleaseAuthority},
    Row{Event::reset_module, kIdle | kFatal, kAnyMode, 0, kKeep, State::idle, kKeep, kKeep,
        kResetModule},
    Row{Event::request_data, kAnyState, kAnyMode, 0, kKeep, State::idle, kKeep, kKeep,
        kPublishData},
    Row{Event::reset_timing, kAnyState, kAnyMode, 0, kKeep, State::idle, kKeep, kKeep, 0},
};

const Row* find(std::span<const Row> rows, const ControllerState& s, Event event,
                bool& known_in_state, bool& known, int& index) {
  for (const Row& row : rows) {
    ++index;
    if (row.event != event) continue;
    known = true;
    if ((row.from & in(s.state)) == 0) continue;
    known_in_state = true;
    if (s.state == State::operational && (row.modes >> s.mode & 1u) == 0) continue;
    if (row.goal != kKeep && row.goal != s.goal) continue;
    return &row;
  }
  return nullptr;
}

}  // namespace

const std::span<const Row> kCommonRows = kRows;

Result step(const Table& table, const ControllerState& state, Event event) noexcept {
  Result result{.next = state, .actions = 0, .verdict = {}, .row = -1};
  bool known = false, known_in_state = false;
  int index = -1;
  const Row* row = find(kCommonRows, state, event, known_in_state, known, index);
  if (row == nullptr) row = find(table.rows, state, event, known_in_state, known, index);
  if (row == nullptr) {
    result.verdict.reason = !known            ? Reason::unknown_command
                            : !known_in_state ? Reason::not_in_state
                                              : Reason::not_in_mode;
    result.verdict.measured = known_in_state ? state.mode : static_cast<double>(state.state);
    return result;
  }
  for (unsigned bit = 0; row->guards >> bit != 0; ++bit) {
    if ((row->guards >> bit & 1u) == 0) continue;
    result.verdict = table.guard(bit, state);
    if (result.verdict.reason != Reason::none) return result;
  }
  result.row = index;
  result.actions = row->actions;
  if (row->to_mode != kKeep) {
    result.next.state = row->to;
    result.next.mode = row->to_mode;
  }
  if (row->to_goal != kKeep) result.next.goal = row->to_goal;
  table.effect(result.actions, result.next);
  return result;
}

}  // namespace lss::lc
