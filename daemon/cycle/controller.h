#pragma once

// The locomotion controller (LC): four states (Zebro thesis 4.3.1), the vehicle's modes inside
// Operational, the links to modules, port and OBC, and one table of rows (event, from, guards,
// actions, to). The executed code, the reject reasons, the list of allowed commands and the
// verified model (tools/lss-lc) all come from the table. step() is pure: the same state and event
// give the same result; no clock, no I/O, no allocation. Called from the frame thread, the command
// thread (on a copy of the state) and tests.
//
// A vehicle adds its modes, goals, flags, guards and rows; the rows of kCommonRows are for all.

#include <array>
#include <cstdint>
#include <span>

#include "daemon/cycle/messages.h"

namespace lss::lc {

// Events: first commands, then reports. A vehicle's own begin at kVehicleEvents. Events of a module
// have its number, from 1 on, as subject.
enum class Event : std::uint8_t {
  none,
  emergency_stop,    // commanded, by anyone
  solve,             // commanded: leave FatalError
  reset_controller,  // commanded: back to a safe state
  reset_module,      // commanded
  restore,           // commanded: isolated modules are in service again
  request_data,      // commanded
  reset_timing,      // commanded
  emergency,         // a fatal fault was raised
  module_heard,      // subject; it answers
  module_silent,     // subject; no answer in its time
  port_opened,
  port_closed,
  obc_heard,
  obc_silent,     // no command and no heartbeat of anyone in its time
  lease_expired,  // no heartbeat of the holder in its time
  next_strategy,  // the one before did not solve the errors
  solved,         // all errors are solved
  unsolved,       // the strategies gave up
};
inline constexpr std::uint8_t kVehicleEvents = 32;
constexpr Event vehicle_event(unsigned n) { return static_cast<Event>(kVehicleEvents + n); }

// Sets as bit masks.
using StateSet = std::uint8_t;
using ModeSet = std::uint32_t;
using GuardSet = std::uint16_t;
using ActionSet = std::uint64_t;

constexpr StateSet in(State s) { return static_cast<StateSet>(1u << static_cast<unsigned>(s)); }
inline constexpr StateSet kAnyState = 0x0F, kIdle = in(State::idle),
                          kOperational = in(State::operational), kFatal = in(State::fatal_error),
                          kSolving = in(State::solve_errors);
// A vehicle's modes.
template <class Mode>
constexpr ModeSet in_mode(Mode mode) {
  return 1u << static_cast<unsigned>(mode);
}
inline constexpr ModeSet kAnyMode = ~ModeSet{0};

// Actions of every vehicle; its own are bits from kVehicleActions on. The vehicle carries out the
// first ones; the others only change the state and are done when step() returns.
enum Action : ActionSet {
  kEmergencyStop = 1u << 0,  // to every actuator, in this frame
  kMotorsOff = 1u << 1,
  kBeginSolve = 1u << 2,
  kEndSolve = 1u << 3,
  kResetModule = 1u << 4,
  kPublishData = 1u << 5,
  kClearFaults = 1u << 6,
  kNextStrategy = 1u << 7,
  kTakeAuthority = 1u << 8,
  kReleaseAuthority = 1u << 9,
  kHeard = 1u << 10,
  kSilent = 1u << 11,
  kPortIsOpen = 1u << 12,
  kPortIsClosed = 1u << 13,
  kObcIsHeard = 1u << 14,
  kObcIsSilent = 1u << 15,
  kIsolate = 1u << 16,
  kRestore = 1u << 17,
};
inline constexpr ActionSet kOnlyState = kTakeAuthority | kReleaseAuthority | kHeard | kSilent |
                                        kPortIsOpen | kPortIsClosed | kObcIsHeard | kObcIsSilent;
inline constexpr unsigned kVehicleActions = 20;  // first free bit

enum Link : std::uint8_t {
  kPortClosed = 1u << 0,
  kObcSilent = 1u << 1,
  kHeld = 1u << 2,  // a source has authority: its lease runs
};

inline constexpr std::uint8_t kMaxStrategies = 6;  // tried one after the other

// The complete discrete state, which guards may read. Only step() changes it. Continuous values are
// not part of it.
struct ControllerState {
  State state = State::idle;
  std::uint8_t mode = 0;   // 0 outside Operational
  std::uint8_t goal = 0;   // target of the chain of modes; the vehicle's numbering
  std::uint8_t flags = 0;  // the vehicle's own booleans
  std::uint8_t links = kPortClosed | kObcSilent;
  std::uint8_t strategy = 0;   // of error solving, counted from 1; 0 outside SolveErrors
  std::uint16_t silent = 0;    // bit i: module i+1 answered before and is silent now
  std::uint16_t unheard = 0;   // bit i: module i+1 has not answered since start
  std::uint16_t isolated = 0;  // bit i: module i+1 is out of service; nothing is asked of it
  bool operator==(const ControllerState&) const = default;
};

inline constexpr std::uint8_t kKeep = 0xFF;  // as mode or goal: stays as it is

// Guards of every vehicle, by bit; its own from kVehicleGuards on.
enum CommonGuard : unsigned {
  kInService,  // the subject is not isolated
  kPortOpen,
  kAllHeard,  // modules, since start
  kAllAnswer,
  kObcHeard,
  kAuthorityHeld,
  kStrategiesLeft,
};
inline constexpr unsigned kVehicleGuards = 8;
// Conditions of the guards, for people.
inline constexpr const char* kCommonGuardNames[] = {
    "the module is in service", "the port is open",         "every module has answered",
    "all modules answer",       "the OBC sends heartbeats", "a source has authority",
    "there is a strategy left"};
constexpr GuardSet guard(unsigned number) { return static_cast<GuardSet>(1u << number); }
inline constexpr GuardSet kContact = guard(kPortOpen) | guard(kAllHeard) | guard(kAllAnswer);
inline constexpr GuardSet kMayStart = kContact | guard(kObcHeard);  // as every vehicle

struct Row {
  Event event;
  StateSet from;
  ModeSet modes;      // looked at in Operational only
  GuardSet guards;    // all must hold, lowest bit first; the first that fails gives the reason
  std::uint8_t goal;  // the row holds only for this goal; kKeep: for any
  State to;           // with kKeep as to_mode: the state stays, too
  std::uint8_t to_mode;
  std::uint8_t to_goal;
  ActionSet actions;
};

// Rows of every vehicle. To Idle, motors off.
constexpr Row off(Event event, ModeSet from, std::uint8_t goal) {
  return {event, kOperational, from, 0, goal, State::idle, 0, 0, kMotorsOff};
}
// State, mode and goal stay.
constexpr Row stay(Event event, StateSet from, ModeSet modes, GuardSet guards, ActionSet actions) {
  return {event, from, modes, guards, kKeep, State::idle, kKeep, kKeep, actions};
}
// A stop breaks error solving off: everything gets an emergency stop, and the errors stay.
constexpr Row break_off(Event event) {
  return {
      event, kSolving, kAnyMode, 0, kKeep, State::fatal_error, 0, 0, kEmergencyStop | kEndSolve};
}
// Only the goal changes: the running motion goes on towards another one.
template <class Goal>
constexpr Row aim(Event event, ModeSet from, GuardSet guards, Goal goal, ActionSet actions) {
  return {event,  kOperational,       from,  guards,
          kKeep,  State::operational, kKeep, static_cast<std::uint8_t>(goal),
          actions};
}

// Rows, grouped by event; begin and end of each group; and the union of its `from` states, by which
// most events are rejected.
struct Rows {
  static constexpr std::size_t kEvents = 64;

  std::span<const Row> rows;
  std::array<std::uint8_t, kEvents> begin{}, end{};
  std::array<StateSet, kEvents> from{};

  constexpr explicit Rows(std::span<const Row> all) : rows(all) {
    for (std::size_t i = 0; i < all.size(); ++i) {
      const auto event = static_cast<std::size_t>(all[i].event);
      if (end[event] == 0) begin[event] = static_cast<std::uint8_t>(i);
      if (end[event] != 0 && end[event] != i) throw "rows of one event stand together";
      end[event] = static_cast<std::uint8_t>(i + 1);
      from[event] = static_cast<StateSet>(from[event] | all[i].from);
    }
  }
};

struct Result {
  ControllerState next;
  ActionSet actions = 0;
  Verdict verdict;  // reason none: a row was taken
  int row = -1;     // index in the table, common rows first; -1: none
};

struct EventInfo {
  Event event;
  const char* name;
  bool command;           // of a client; else a report, or of the daemon itself
  std::uint8_t subjects;  // 0: it has no subject; n: 1..n
  // The command that causes it, where its number alone says so; 0: none.
  std::uint16_t kind = 0;
};
inline constexpr std::uint8_t kEachModule =
    0xFF;  // as subjects: as many as the vehicle has modules

// The vehicle's part.
struct Table {
  const Rows* rows;
  std::span<const EventInfo> events;  // its own; those of kCommonEvents apply to all
  std::uint8_t modules;
  std::span<const char* const> guard_names;  // of its own
  // Guard number `bit`, from kVehicleGuards on, on this state; reason none: it holds.
  Verdict (*guard)(unsigned bit, const ControllerState& state, unsigned subject);
  // Applied after a row was taken: flags that follow from the actions.
  void (*effect)(ActionSet actions, ControllerState& state);
  const Rows* common;  // kCommonRows; another only to test that a wrong one is noticed
};

extern const Rows kCommonRows;
extern const std::span<const EventInfo> kCommonEvents;

// A flag of the vehicle that the actions `on` set and the actions `off` clear; both: it is set.
constexpr void follow(ControllerState& s, std::uint8_t flag, ActionSet actions, ActionSet on,
                      ActionSet off) {
  if (actions & off) s.flags = static_cast<std::uint8_t>(s.flags & ~flag);
  if (actions & on) s.flags = static_cast<std::uint8_t>(s.flags | flag);
}

// At boot: Idle, no module has answered yet.
ControllerState begin(const Table& table) noexcept;

// One event. Total: an event that no row takes leaves the state unchanged and gives the reason.
Result step(const Table& table, const ControllerState& state, Event event,
            unsigned subject = 0) noexcept;

}  // namespace lss::lc
