#include "daemon/cycle/controller.h"

#include <array>
#include <bit>

namespace lss::lc {
namespace {

constexpr ActionSet kAbort = kEmergencyStop | kEndSolve;

// To a state without modes.
constexpr Row go(Event event, StateSet from, GuardSet guards, State to, ActionSet actions) {
  return {event, from, kAnyMode, guards, kKeep, to, 0, 0, actions};
}
constexpr Row stay(Event event, StateSet from, GuardSet guards, ActionSet actions) {
  return stay(event, from, kAnyMode, guards, actions);
}

constexpr std::array kRows = {
    go(Event::emergency_stop, kAnyState, 0, State::fatal_error, kAbort),
    go(Event::emergency, kIdle | kOperational | kSolving, 0, State::fatal_error, kAbort),
    stay(Event::emergency, kFatal, 0, 0),

    go(Event::solve, kFatal, 0, State::solve_errors, kBeginSolve),
    stay(Event::next_strategy, kSolving, guard(kStrategiesLeft), kNextStrategy | kMotorsOff),
    go(Event::solved, kSolving, kContact, State::idle, kEndSolve | kClearFaults | kMotorsOff),
    go(Event::unsolved, kSolving, 0, State::fatal_error, kEndSolve | kEmergencyStop),

    go(Event::reset_controller, kIdle, 0, State::idle, kMotorsOff),
    go(Event::reset_controller, kOperational, 0, State::idle, kEmergencyStop),
    go(Event::reset_controller, kFatal | kSolving, 0, State::fatal_error, kAbort),
    stay(Event::reset_module, kIdle | kFatal, 0, kResetModule),
    stay(Event::restore, kIdle | kFatal, 0, kRestore),

    stay(Event::request_data, kAnyState, 0, kPublishData),
    stay(Event::reset_timing, kAnyState, 0, 0),

    // Links. A lost module is an emergency also in Idle: the state of its motor is unknown.
    stay(Event::module_heard, kAnyState, guard(kInService), kHeard),
    go(Event::module_silent, kIdle | kOperational, guard(kInService), State::fatal_error,
       kSilent | kEmergencyStop),
    stay(Event::module_silent, kFatal | kSolving, guard(kInService), kSilent),
    stay(Event::port_opened, kAnyState, 0, kPortIsOpen),
    go(Event::port_closed, kOperational, 0, State::fatal_error, kPortIsClosed | kEmergencyStop),
    stay(Event::port_closed, kIdle | kFatal | kSolving, 0, kPortIsClosed),
    stay(Event::obc_heard, kAnyState, 0, kObcIsHeard),
    go(Event::obc_silent, kOperational, 0, State::fatal_error, kObcIsSilent | kEmergencyStop),
    stay(Event::obc_silent, kIdle | kFatal | kSolving, 0, kObcIsSilent),
};

constexpr std::array kEvents = {
    EventInfo{Event::emergency_stop, "estop", true, 0},
    EventInfo{Event::solve, "solve", true, 0},
    EventInfo{Event::reset_controller, "reset lc", true, 0},
    EventInfo{Event::reset_module, "reset module", true, 0},
    EventInfo{Event::restore, "restore", true, 0},
    EventInfo{Event::request_data, "data", true, 0},
    EventInfo{Event::reset_timing, "reset-timing", true, 0},
    EventInfo{Event::emergency, "fatal fault", false, 0},
    EventInfo{Event::module_heard, "module heard", false, kEachModule},
    EventInfo{Event::module_silent, "module silent", false, kEachModule},
    EventInfo{Event::port_opened, "port opened", false, 0},
    EventInfo{Event::port_closed, "port closed", false, 0},
    EventInfo{Event::obc_heard, "OBC heard", false, 0},
    EventInfo{Event::obc_silent, "OBC silent", false, 0},
    EventInfo{Event::lease_expired, "lease expired", false, 0},
    EventInfo{Event::next_strategy, "next strategy", false, 0},
    EventInfo{Event::solved, "solved", false, 0},
    EventInfo{Event::unsolved, "unsolved", false, 0},
};

// Whether it holds; if not, `why` is set.
bool holds(unsigned guard, const ControllerState& s, unsigned subject, Verdict& why) noexcept {
  const auto refused = [&](Reason reason, int module = 0) {
    why.reason = reason;
    why.subject = static_cast<std::uint16_t>(module);
    return false;
  };
  const auto first = [](std::uint16_t modules) { return std::countr_zero(modules) + 1; };
  switch (guard) {
    case kInService:
      if (subject != 0 && subject <= 16 && (s.isolated >> (subject - 1) & 1u) != 0)
        return refused(Reason::isolated, static_cast<int>(subject));
      break;
    case kPortOpen:
      if (s.links & kPortClosed) return refused(Reason::port_closed);
      break;
    case kAllHeard:
      if (s.unheard) return refused(Reason::never_heard, first(s.unheard));
      break;
    case kAllAnswer:
      if (s.silent) return refused(Reason::module_silent, first(s.silent));
      break;
    case kObcHeard:
      if (s.links & kObcSilent) return refused(Reason::obc_silent);
      break;
    case kAuthorityHeld:
      if (!(s.links & kHeld)) return refused(Reason::nobody_holds);
      break;
    case kStrategiesLeft:
      if (s.strategy >= kMaxStrategies) return refused(Reason::not_solved);
      break;
    default: break;
  }
  return true;
}

template <class Set>
void set(Set& bits, unsigned mask, bool on) noexcept {
  bits = static_cast<Set>(on ? bits | mask : bits & ~mask);
}

void common_effect(ActionSet actions, unsigned subject, ControllerState& s) noexcept {
  const unsigned module = subject == 0 || subject > 16 ? 0 : 1u << (subject - 1);
  if (actions & kBeginSolve) s.strategy = 1;
  if (actions & kNextStrategy) ++s.strategy;
  if (actions & kEndSolve) s.strategy = 0;
  if (actions & (kHeard | kSilent | kIsolate)) {
    set(s.unheard, module, false);
    set(s.silent, module, (actions & kSilent) != 0);
  }
  if (actions & kIsolate) set(s.isolated, module, true);
  if (actions & kRestore) {  // they have to answer first
    const unsigned these = module != 0 ? s.isolated & module : s.isolated;
    s.silent = static_cast<std::uint16_t>(s.silent | these);
    s.isolated = static_cast<std::uint16_t>(s.isolated & ~these);
  }
  if (actions & kPortIsOpen) set(s.links, kPortClosed, false);
  if (actions & kPortIsClosed) set(s.links, kPortClosed, true);
  if (actions & kObcIsHeard) set(s.links, kObcSilent, false);
  if (actions & kObcIsSilent) set(s.links, kObcSilent, true);
  if (actions & kTakeAuthority) set(s.links, kHeld, true);
  if ((actions & kReleaseAuthority) || s.state != State::operational) set(s.links, kHeld, false);
}

// The first row that takes the event here; -1: none.
int find(const Rows& rows, const ControllerState& s, std::size_t event) noexcept {
  const StateSet here = in(s.state);
  if ((rows.from[event] & here) == 0) return -1;
  for (std::size_t i = rows.begin[event]; i < rows.end[event]; ++i) {
    const Row& row = rows.rows[i];
    if ((row.from & here) == 0) continue;
    if (s.state == State::operational && (row.modes >> s.mode & 1u) == 0) continue;
    if (row.goal == kKeep || row.goal == s.goal) return static_cast<int>(i);
  }
  return -1;
}

// Why no row takes the event.
Verdict no_row(const Table& table, const ControllerState& s, std::size_t event) noexcept {
  const int from = event < Rows::kEvents ? table.common->from[event] | table.rows->from[event] : 0;
  if (from & in(s.state))
    return {.reason = Reason::not_in_mode, .measured = static_cast<double>(s.mode)};
  return {.reason = from == 0 ? Reason::unknown_command : Reason::not_in_state,
          .measured = static_cast<double>(s.state)};
}

}  // namespace

constinit const Rows kCommonRows(kRows);
const std::span<const EventInfo> kCommonEvents = kEvents;

ControllerState begin(const Table& table) noexcept {
  ControllerState state;
  state.unheard = static_cast<std::uint16_t>((1u << table.modules) - 1);
  return state;
}

Result step(const Table& table, const ControllerState& state, Event event,
            unsigned subject) noexcept {
  Result result{.next = state, .actions = 0, .verdict = {}, .row = -1};
  const auto e = static_cast<std::size_t>(event);
  const Rows* rows = table.common;
  int found = e < Rows::kEvents ? find(*rows, state, e) : -1;
  if (found < 0 && e < Rows::kEvents) {
    rows = table.rows;
    found = find(*rows, state, e);
  }
  if (found < 0) {
    result.verdict = no_row(table, state, e);
    return result;
  }
  const Row& row = rows->rows[static_cast<std::size_t>(found)];
  for (unsigned left = row.guards; left != 0; left &= left - 1) {
    const auto number = static_cast<unsigned>(std::countr_zero(left));
    if (number < kVehicleGuards) {
      if (!holds(number, state, subject, result.verdict)) return result;
    } else if (const Verdict why = table.guard(number, state, subject);
               why.reason != Reason::none) {
      result.verdict = why;
      return result;
    }
  }
  result.row = found + (rows == table.rows ? static_cast<int>(table.common->rows.size()) : 0);
  result.actions = row.actions;
  if (row.to_mode != kKeep) {
    result.next.state = row.to;
    result.next.mode = row.to_mode;
  }
  if (row.to_goal != kKeep) result.next.goal = row.to_goal;
  common_effect(result.actions, subject, result.next);
  table.effect(result.actions, result.next);
  return result;
}

}  // namespace lss::lc
