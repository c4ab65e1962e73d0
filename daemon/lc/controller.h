#pragma once

// The locomotion controller (LC): four states (Zebro thesis 4.3.1), the vehicle's modes inside
// Operational, and one table of rows (event, from, guards, actions, to) from which come the code
// that runs, the rejects with their reasons, and the list of what is allowed when. step() is a pure
// function: the same state and event give the same result; no clock, no I/O, no allocation. Called
// from the frame thread, from the command thread (to answer at once, on a copy of the state) and
// from tests.
//
// A vehicle brings its modes, goals, flags, guards and its own rows; the rows of kCommonRows hold
// for all.

#include <cstdint>
#include <span>

#include "daemon/core/messages.h"

namespace lss::lc {

// What can happen. Commands first, then what the world does. A vehicle's own begin at
// kVehicleEvents.
enum class Event : std::uint8_t {
  none,
  emergency_stop,    // commanded, by anyone
  emergency,         // a fatal fault was raised
  solve,             // commanded: leave FatalError
  solved,            // all errors are solved
  unsolved,          // the strategies gave up
  reset_controller,  // commanded: back to a safe state
  reset_module,      // commanded
  request_data,      // commanded
  reset_timing,      // commanded
};
inline constexpr std::uint8_t kVehicleEvents = 16;

// Sets as bit masks.
using StateSet = std::uint8_t;
using ModeSet = std::uint32_t;
using GuardSet = std::uint16_t;
using ActionSet = std::uint32_t;

constexpr StateSet in(State s) { return static_cast<StateSet>(1u << static_cast<unsigned>(s)); }
inline constexpr StateSet kAnyState = 0x0F;
inline constexpr ModeSet kAnyMode = ~ModeSet{0};

// Actions that every vehicle knows; its own are bits from kVehicleActions on.
enum Action : ActionSet {
  kEmergencyStop = 1u << 0,  // to every actuator, in this frame
  kMotorsOff = 1u << 1,
  kBeginSolve = 1u << 2,
  kEndSolve = 1u << 3,
  kResetModule = 1u << 4,
  kPublishData = 1u << 5,
  kClearFaults = 1u << 6,
  kReleaseAuthority = 1u << 7,
};
inline constexpr unsigned kVehicleActions = 8;  // first free bit

// The discrete state, all of it: what a guard may look at. Continuous values stay outside.
struct ControllerState {
  State state = State::idle;
  std::uint8_t mode = 0;      // 0 outside Operational
  std::uint8_t goal = 0;      // where the chain of modes is going; the vehicle's numbering
  std::uint8_t flags = 0;     // the vehicle's own booleans
  std::uint16_t silent = 0;   // bit i: module i+1 was heard and is silent now
  std::uint16_t unheard = 0;  // bit i: module i+1 was never heard since start
  bool operator==(const ControllerState&) const = default;
};

inline constexpr std::uint8_t kKeep = 0xFF;  // as mode or goal: stays as it is

struct Row {
  Event event;
  StateSet from;
  ModeSet modes;      // looked at in Operational only
  GuardSet guards;    // all must hold, lowest bit first; the first that does not gives the reason
  std::uint8_t goal;  // looked at: the row holds only for this goal; kKeep: for any
  State to;
  std::uint8_t to_mode;
  std::uint8_t to_goal;
  ActionSet actions;
};

struct Result {
  ControllerState next;
  ActionSet actions = 0;
  Verdict verdict;  // reason none: a row was taken
  int row = -1;     // index in the table, common rows first; -1: none
};

// What a vehicle brings.
struct Table {
  std::span<const Row> rows;
  // Guard number `bit` on this state; reason none: it holds.
  Verdict (*guard)(unsigned bit, const ControllerState& state);
  // Applied after a row was taken: flags that follow from the actions.
  void (*effect)(ActionSet actions, ControllerState& state);
};

extern const std::span<const Row> kCommonRows;

// One event. Total: an event that no row takes leaves the state as it is and says why.
Result step(const Table& table, const ControllerState& state, Event event) noexcept;

}  // namespace lss::lc
