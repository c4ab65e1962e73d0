#pragma once

// The numbered lists of reject reasons, faults and events that vehicles share; those of one vehicle
// are in idl/NAME/codes.h. Numbers are never reused: a retired line stays and is marked so. The
// daemon, the command line and the documents use them; on the wire only the number travels. Pure
// data, callable from every thread.

#include <cstdint>
#include <span>

namespace lss {

// number, name, text, advice
#define LSS_REASONS(X)                                                                            \
  X(0, none, "no reason", "")                                                                     \
  X(1, unknown_command, "unknown command type", "list the commands with: lss-cli command list")   \
  X(2, wrong_vehicle, "command of another vehicle",                                               \
    "list the commands with: lss-cli command list")                                               \
  X(3, not_finite, "parameter is not a finite number", "send a number")                           \
  X(4, out_of_range, "parameter is out of range", "see: lss-cli command describe NAME")           \
  X(5, not_a_choice, "parameter is none of its choices", "see: lss-cli command describe NAME")    \
  X(6, bad_source, "source name is empty or not terminated", "name the source")                   \
  X(7, stale_sequence, "its sender used the sequence number before",                              \
    "count the sequence number up")                                                               \
  X(8, too_many_sources, "retired", "")                                                           \
  X(9, bad_lease, "lease is out of range", "ask for a lease within the limits of the config")     \
  X(10, busy, "request queue is full", "send fewer commands at a time")                           \
  X(11, not_authorised, "another source has authority",                                           \
    "let it stop, or stop it: any emergency stop is obeyed")                                      \
  X(12, not_in_state, "not allowed in this state", "see the state with: lss-cli status")          \
  X(13, not_in_mode, "not allowed in this mode", "see the mode with: lss-cli status")             \
  X(14, module_silent, "a module does not answer",                                                \
    "check its power and the bus, then: lss-cli solve")                                           \
  X(16, motors_not_on, "motion control is not confirmed by all modules",                          \
    "wait for it, or check lss-cli status")                                                       \
  X(18, port_closed, "the bus port is not open", "check the port named in the config")            \
  X(19, emergency, "an emergency ended it", "see lss-cli status, then: lss-cli solve")            \
  X(20, lease_expired, "the heartbeat of its source stopped",                                     \
    "keep the client running, or start lss-cli heartbeat")                                        \
  X(21, superseded, "another command took its place", "")                                         \
  X(22, over_current, "a module draws too much current", "free the leg, then: lss-cli solve")     \
  X(23, not_solved, "errors remain", "see lss-cli status for the faults that are still there")    \
  X(24, shutting_down, "the daemon is stopping", "start it again")                                \
  X(26, unused_parameter, "a parameter that the command does not have is not zero",               \
    "see: lss-cli command describe NAME")                                                         \
  X(27, never_heard, "a module has not answered since the daemon started",                        \
    "check its power and the bus, or go on without it where the vehicle can: lss-cli isolate")    \
  X(29, isolated, "the module is out of service", "lss-cli restore, when it is repaired")         \
  X(30, obc_silent, "no heartbeat from the OBC", "start the OBC's client or lss-cli heartbeat")   \
  X(31, nobody_holds, "nobody has authority", "")                                                 \
  X(34, imu_lost, "the IMU is not reliable", "drive by hand, or repair the IMU")                  \
  X(38, too_early, "retired", "")                                                                 \
  X(55, script_overlap, "a pulse begins before the last of the same valve ended: s",              \
    "let the first one end; the subject is the step, counted from 1")                             \
  X(56, script_backwards, "the step is before the one before it: s",                              \
    "sort the steps; the subject is the step, counted from 1")                                    \
  X(57, script_too_long, "the script ends too late: s",                                           \
    "make two of it; the subject is the step, counted from 1")                                    \
  X(58, script_actuator, "the step is for a fan that there is not: set, and the largest",         \
    "valves are bits 0 to 7, fans bits 0 to 3; the subject is the step, counted from 1")          \
  X(59, script_value, "the value of the step is out of range",                                    \
    "pulses 0.04 s to 30 s, throttle 0 to 1, rpm 0 to 40000; the subject is the step, counted "   \
    "from 1")                                                                                     \
  X(61, script_other, "another script was begun: the number sent, and the one that is there",     \
    "send it again, as a whole")                                                                  \
  X(62, script_order, "the steps have to come in order: the one that came, and the one expected", \
    "send it again, as a whole")                                                                  \
  X(65, not_in_flight, "it is not in the air", "")                                                \
  X(72, no_such_parameter, "there is no parameter of this name",                                  \
    "list them with: lss-cli param get")                                                          \
  X(73, parameter_range, "the value of the parameter is out of its range",                        \
    "see its range with: lss-cli param get NAME")                                                 \
  X(74, parameter_whole, "the parameter is a whole number", "give it without a fraction")         \
  X(75, parameter_together, "the value does not go with those of other parameters",               \
    "change the others first; docs/parameters.md says which hang together")                       \
  X(76, save_failed, "the parameters could not be written: error number",                         \
    "free or repair the disk, make the folder writable, then save again; the journal says more")  \
  X(77, name_conflict, "another daemon with this vehicle_id is on the domain",                    \
    "stop one, or change its vehicle_id; lss-cli doctor names both")                              \
  X(78, not_reset, "a module answers, but was not reset",                                         \
    "send it again; if that does not help, switch its power off and on")                          \
  X(79, fell, "it was in the air: it fell", "")                                                   \
  X(92, not_configured,                                                                           \
    "a module answers, but is another one than configured or refuses its configuration",          \
    "lss-cli status names its link; check its number, firmware and description")                  \
  X(96, bad_name, "the name of the parameter is not terminated or not printable",                 \
    "send one of lss/parameters, with zeros behind it")                                           \
  X(97, unused_name, "a name is sent that the command does not have", "leave it empty")

// number, name, severity (of lss.idl: 0 info, 1 warning, 2 error, 3 fatal), text, advice
#define LSS_FAULTS(X)                                                                             \
  X(1, emergency_stop, 3, "emergency stop commanded", "lss-cli solve")                            \
  X(2, obc_silent, 3, "no heartbeat from the OBC",                                                \
    "start the OBC's client or lss-cli heartbeat, then: lss-cli solve")                           \
  X(3, frame_overrun, 3, "too many frames in a row without a command in time",                    \
    "check the load and the real-time contract: lss-cli status")                                  \
  X(4, module_silent, 3, "module does not answer",                                                \
    "check its power and the bus, then: lss-cli solve")                                           \
  X(5, module_over_current, 3, "module stopped by over-current",                                  \
    "free what blocks it, then: lss-cli solve")                                                   \
  X(8, module_reset, 3, "module was reset while operational",                                     \
    "check its supply, then: lss-cli solve")                                                      \
  X(9, module_disobeys, 3, "module does not do what it was commanded", "lss-cli solve resets it") \
  X(11, port_lost, 3, "bus port is gone",                                                         \
    "plug it in again: it is reopened by itself; then: lss-cli solve")                            \
  X(12, port_absent, 1, "bus port is not there yet", "plug it in: it is opened by itself")        \
  X(14, temperature_warning, 1, "module is hot", "let it cool down")                              \
  X(15, shared_memory_lost, 1, "RouDi ended or was replaced: telemetry goes by the network",      \
    "restart the daemon when the vehicle is idle")                                                \
  X(16, bus_noise, 1, "many broken frames on the bus", "check wiring and termination")            \
  X(17, bus_stuck, 3, "bus thread made no cycle in time", "check the port and the load")          \
  X(19, gate_closed, 3, "an order failed a check at the gate",                                    \
    "report it with the events before it; then: lss-cli solve")                                   \
  X(20, orders_stale, 3, "the cycle gave no orders in time and the bus stopped the modules",      \
    "check the load and the real-time contract: lss-cli status; then: lss-cli solve")             \
  X(31, stale_input, 3, "a measurement that is needed is too old",                                \
    "check the node and the bus, then: lss-cli solve")                                            \
  X(34, drive_fault, 3, "a drive reports a fault", "lss-cli solve resets it")                     \
  X(35, node_wrong, 1, "the node is of another type than configured",                             \
    "check its number and the config")                                                            \
  X(36, node_refuses, 1, "the node refused its configuration",                                    \
    "check its firmware and the config")                                                          \
  X(37, bus_off, 3, "the CAN controller went bus-off",                                            \
    "check wiring and termination, then: lss-cli solve")                                          \
  X(38, node_babbles, 1, "the node sends too much and is not listened to",                        \
    "in Idle: lss-cli reset NODE; or replace it")                                                 \
  X(50, stop_not_followed, 3, "the bus obeyed an emergency stop and the cycle did not follow",    \
    "report it with the events before it; then: lss-cli solve")                                   \
  X(55, name_conflict, 1, "another daemon with this vehicle_id is on the domain",                 \
    "stop one, or change its vehicle_id; lss-cli doctor names both")                              \
  X(71, drive_drops_out, 3, "a drive dropped out of operation enabled again and again",           \
    "check its supply, wiring and load, then: lss-cli solve")

// number, name, severity, text ({0}..{3}: arguments). Faults are events of the same number + 1000.
#define LSS_EVENTS(X)                                                                    \
  X(1, started, 0, "daemon started")                                                     \
  X(2, stopping, 0, "daemon stops")                                                      \
  X(3, state_changed, 0, "state {0} to {1}")                                             \
  X(4, mode_changed, 0, "mode {0} to {1}")                                               \
  X(5, authority_taken, 0, "authority taken")                                            \
  X(6, authority_released, 0, "authority released")                                      \
  X(7, lease_expired, 1, "heartbeat of the authority stopped for {0} ms: safe stop")     \
  X(8, command_rejected, 1, "command {0} rejected, reason {1}")                          \
  X(11, port_opened, 0, "bus port opened")                                               \
  X(12, port_closed, 1, "bus port closed")                                               \
  X(13, frame_late, 1, "a command was late, {0} so far")                                 \
  X(14, gate_closed, 1, "gate replaced a command, check {0}")                            \
  X(15, solve_ended, 0, "error solving ended, {0} faults left")                          \
  X(16, safe_command_sent, 2, "bus sent the safe command by itself")                     \
  X(18, fault_cleared, 0, "fault {0} cleared")                                           \
  X(19, module_was_reset, 1, "module was reset")                                         \
  X(20, timing_reset, 0, "timing statistics begin again")                                \
  X(21, clock_stepped, 1, "wall clock was set by {0} s: UTC stamps jump, frames do not") \
  X(22, frames_kept, 0, "the frames before a fault are kept in a file")                  \
  X(23, log_failed, 1, "the log or the frames before a fault could not be written")      \
  X(24, strategy_begun, 0, "error solving tries {0}")                                    \
  X(25, strategy_ended, 0, "{0} ended: {1}")                                             \
  X(26, module_isolated, 1, "module is out of service")                                  \
  X(27, modules_restored, 0, "module is in service again")                               \
  X(28, log_lost, 1, "frames are missing in the log")                                    \
  X(29, emergency_message, 1, "node sent emergency {0}")                                 \
  X(30, node_configured, 0, "node is configured and running")                            \
  X(33, calibration_refused, 1, "calibration failed, {0}: {1}, allowed {2}")             \
  X(34, planned, 0, "planned: {0}, {1} s, {2} of {3} thruster-seconds")                  \
  X(35, phase_changed, 0, "phase {0} to {1}")                                            \
  X(38, contingency, 2, "a fault in the air: {0}")                                       \
  X(49, recording_failed, 1, "frames cannot be recorded")                                \
  X(50, recording_cut, 1, "the last recording was not written to its end")               \
  X(51, parameter_changed, 0, "parameter {0}: {1} to {2}")                               \
  X(52, parameters_saved, 0, "{0} parameters saved, number {1}")                         \
  X(53, parameters_not_saved, 1, "parameters could not be saved in both copies: {0}")    \
  X(54, parameters_taken, 0, "{0} saved parameters taken, number {1}")                   \
  X(55, parameters_damaged, 1, "a copy of the saved parameters is damaged")              \
  X(56, parameters_refused, 1, "saved parameters are not taken")                         \
  X(57, reset_begun, 0, "module is being reset, it has to answer within {0} s")          \
  X(58, reset_ended, 0, "module answers again, {0} s after its reset was ordered")       \
  X(70, drive_dropped_out, 1, "drive dropped out of operation enabled, {0} so far")      \
  X(98, other_interface, 1,                                                              \
    "commands of a client do not arrive: it was built with another lss/command (lss.idl)")

enum class Reason : std::uint16_t {
#define LSS_ENUM(number, name, ...) name = number,
  LSS_REASONS(LSS_ENUM)
};
enum class FaultId : std::uint16_t { none = 0, LSS_FAULTS(LSS_ENUM) };
enum class EventId : std::uint16_t {
  none = 0,
  LSS_EVENTS(LSS_ENUM)
#undef LSS_ENUM
};

inline constexpr std::uint16_t kFaultEventBase = 1000;

struct CodeInfo {
  std::uint16_t number;
  const char* name;
  std::uint8_t severity;
  const char* text;
  const char* advice;
};

#define LSS_REASON_INFO(number, name, text, advice) {number, #name, 1, text, advice},
#define LSS_FAULT_INFO(number, name, severity, text, advice) \
  {number, #name, severity, text, advice},
#define LSS_EVENT_INFO(number, name, severity, text) {number, #name, severity, text, ""},
inline constexpr CodeInfo kReasons[] = {LSS_REASONS(LSS_REASON_INFO)};
inline constexpr CodeInfo kFaults[] = {LSS_FAULTS(LSS_FAULT_INFO)};
inline constexpr CodeInfo kEvents[] = {LSS_EVENTS(LSS_EVENT_INFO)};

// Codes of a vehicle itself. Those of a vehicle from outside have the numbers from kFirstOwnCode to
// 999: below, this file may take new ones.
inline constexpr std::uint16_t kFirstOwnCode = 500;
struct OwnCodes {
  std::span<const CodeInfo> faults{}, reasons{}, events{};
};
// Those of this process: set once at start-up, before there are other threads.
inline OwnCodes own_codes;

// In a vehicle's namespace: reasons::NAME, faults::NAME, events::NAME, and kOwnCodes.
#define LSS_OWN_REASON(number, name, ...) inline constexpr Reason name{number};
#define LSS_OWN_FAULT(number, name, ...) inline constexpr FaultId name{number};
#define LSS_OWN_EVENT(number, name, ...) inline constexpr EventId name{number};
#define LSS_OWN_CODES(REASONS, FAULTS, EVENTS)                          \
  namespace reasons {                                                   \
  REASONS(LSS_OWN_REASON)                                               \
  }                                                                     \
  namespace faults {                                                    \
  FAULTS(LSS_OWN_FAULT)                                                 \
  }                                                                     \
  namespace events {                                                    \
  EVENTS(LSS_OWN_EVENT)                                                 \
  }                                                                     \
  inline constexpr CodeInfo kOwnReasons[] = {REASONS(LSS_REASON_INFO)}; \
  inline constexpr CodeInfo kOwnFaults[] = {FAULTS(LSS_FAULT_INFO)};    \
  inline constexpr CodeInfo kOwnEvents[] = {EVENTS(LSS_EVENT_INFO)};    \
  inline constexpr OwnCodes kOwnCodes{                                  \
      .faults = kOwnFaults, .reasons = kOwnReasons, .events = kOwnEvents};

constexpr const CodeInfo* find_code(std::span<const CodeInfo> table, std::uint16_t number) {
  for (const CodeInfo& info : table) {
    if (info.number == number) return &info;
  }
  return nullptr;
}
constexpr const CodeInfo* find_code(std::span<const CodeInfo> own, std::span<const CodeInfo> shared,
                                    std::uint16_t number) {
  const CodeInfo* code = find_code(own, number);
  return code != nullptr ? code : find_code(shared, number);
}

// nullptr for a number that is not in the lists.
constexpr const CodeInfo* info(Reason r, const OwnCodes& own = own_codes) {
  return find_code(own.reasons, kReasons, static_cast<std::uint16_t>(r));
}
constexpr const CodeInfo* info(FaultId f, const OwnCodes& own = own_codes) {
  return find_code(own.faults, kFaults, static_cast<std::uint16_t>(f));
}
constexpr const CodeInfo* info(EventId e, const OwnCodes& own = own_codes) {
  return find_code(own.events, kEvents, static_cast<std::uint16_t>(e));
}

// Of an event, or of the fault that it is.
constexpr const CodeInfo* event_info(std::uint16_t id, const OwnCodes& own = own_codes) {
  return id < kFaultEventBase ? info(static_cast<EventId>(id), own)
                              : info(static_cast<FaultId>(id - kFaultEventBase), own);
}

}  // namespace lss
