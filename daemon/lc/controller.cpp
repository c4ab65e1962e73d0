#include "daemon/lc/controller.h"

#include <array>
#include <bit>

namespace lss::lc {
namespace {

constexpr StateSet kIdle = in(State::idle), kOperational = in(State::operational),
                   kFatal = in(State::fatal_error), kSolving = in(State::solve_errors);
constexpr GuardSet kContact = guard(kPortOpen) | guard(kAllHeard) | guard(kAllAnswer);
constexpr ActionSet kAbort = kEmergencyStop | kEndSolve;

// To a state without modes.
constexpr Row go(Event event, StateSet from, GuardSet guards, State to, ActionSet actions) {
  return {event, from, kAnyMode, guards, kKeep, to, 0, 0, actions};
}
constexpr Row stay(Event event, StateSet from, GuardSet guards, ActionSet actions) {
  return {event, from, kAnyMode, guards, kKeep, State::idle, kKeep, kKeep, actions};
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

    // Links. A module that is lost is an emergency also in Idle: nobody knows what its motor does.
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

Verdict common_guard(unsigned number, const ControllerState& s, unsigned subject) noexcept {
  const auto first = [](std::uint16_t modules) {
    return static_cast<std::uint16_t>(std::countr_zero(modules) + 1);
  };
  switch (number) {
    case kInService:
      if (subject != 0 && subject <= 16 && (s.isolated >> (subject - 1) & 1u) != 0)
        return {.reason = Reason::isolated, .subject = static_cast<std::uint16_t>(subject)};
      break;
    case kPortOpen:
      if (s.links & kPortClosed) return {.reason = Reason::port_closed};
      break;
    case kAllHeard:
      if (s.unheard) return {.reason = Reason::never_heard, .subject = first(s.unheard)};
      break;
    case kAllAnswer:
      if (s.silent) return {.reason = Reason::module_silent, .subject = first(s.silent)};
      break;
    case kObcHeard:
      if (s.links & kObcSilent) return {.reason = Reason::obc_silent};
      break;
    case kAuthorityHeld:
      if (!(s.links & kHeld)) return {.reason = Reason::nobody_holds};
      break;
    case kStrategiesLeft:
      if (s.strategy >= kMaxStrategies) return {.reason = Reason::not_solved};
      break;
    default:
      break;
  }
  return {};
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
    s.silent = static_cast<std::uint16_t>(s.silent | s.isolated);
    s.isolated = 0;
  }
  if (actions & kPortIsOpen) set(s.links, kPortClosed, false);
  if (actions & kPortIsClosed) set(s.links, kPortClosed, true);
  if (actions & kObcIsHeard) set(s.links, kObcSilent, false);
  if (actions & kObcIsSilent) set(s.links, kObcSilent, true);
  if (actions & kTakeAuthority) set(s.links, kHeld, true);
  if ((actions & kReleaseAuthority) || s.state != State::operational) set(s.links, kHeld, false);
}

struct Found {
  const Row* row = nullptr;
  int index = -1;
  bool known = false, known_in_state = false;  // the event
};

void find(const Rows& rows, const ControllerState& s, Event event, int offset,
          Found& found) noexcept {
  const auto e = static_cast<std::size_t>(event);
  if (e >= Rows::kEvents) return;
  for (std::size_t i = rows.begin[e]; i < rows.end[e]; ++i) {
    const Row& row = rows.rows[i];
    if (row.event != event) continue;
    found.known = true;
    if ((row.from & in(s.state)) == 0) continue;
    found.known_in_state = true;
    if (s.state == State::operational && (row.modes >> s.mode & 1u) == 0) continue;
    if (row.goal != kKeep && row.goal != s.goal) continue;
    found.row = &row;
    found.index = offset + static_cast<int>(i);
    return;
  }
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
  Found found;
  find(*table.common, state, event, 0, found);
  if (found.row == nullptr)
    find(*table.rows, state, event, static_cast<int>(table.common->rows.size()), found);
  const Row* const row = found.row;
  if (row == nullptr) {
    result.verdict.reason = !found.known            ? Reason::unknown_command
                            : !found.known_in_state ? Reason::not_in_state
                                                    : Reason::not_in_mode;
    result.verdict.measured = found.known_in_state ? state.mode : static_cast<double>(state.state);
    return result;
  }
  for (unsigned bit = 0; row->guards >> bit != 0; ++bit) {
    if ((row->guards >> bit & 1u) == 0) continue;
    result.verdict =
        bit < kVehicleGuards ? common_guard(bit, state, subject) : table.guard(bit, state, subject);
    if (result.verdict.reason != Reason::none) return result;
  }
  result.row = found.index;
  result.actions = row->actions;
  if (row->to_mode != kKeep) {
    result.next.state = row->to;
    result.next.mode = row->to_mode;
  }
  if (row->to_goal != kKeep) result.next.goal = row->to_goal;
  common_effect(result.actions, subject, result.next);
  table.effect(result.actions, result.next);
  return result;
}

}  // namespace lss::lc
