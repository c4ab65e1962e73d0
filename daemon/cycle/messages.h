#pragma once

// Messages between the threads of the daemon, and between the cycle and the DDS code
// (daemon/publish). They are trivially copyable and contain no DDS type. Strings are
// NUL-terminated.

#include <array>
#include <cstdint>
#include <iterator>
#include <tuple>
#include <type_traits>

#include "daemon/cycle/members.h"
#include "daemon/cycle/tunables.h"
#include "drivers/time.h"
#include "idl/codes.h"
#include "idl/commands.h"
#include "idl/timing_statistics.h"

namespace lss {

enum class State : std::uint8_t { idle, operational, fatal_error, solve_errors };
inline constexpr const char* kStateNames[] = {"Idle", "Operational", "FatalError", "SolveErrors"};

enum class Phase : std::uint8_t { accepted, rejected, executing, completed, failed, superseded };
enum class Severity : std::uint8_t { info, warning, error, fatal };
enum class SharedMemory : std::uint8_t { off, active, absent, lost };

// Result of the comparison of the cycle's state with its second copy before a frame
// (daemon/cycle/twins.h).
enum class MemoryCheck : std::uint8_t {
  good,
  corrected,  // the state of the last frame was restored
  lost,       // both copies are damaged: the state of the last frame is unknown
};

using Name = std::array<char, 32>;                  // a source
using ParameterName = std::array<char, kNameSize>;  // of a parameter of the vehicle

// Internal flags, in addition to those of idl/commands.h. The heartbeat comes from another daemon
// with our vehicle_id.
inline constexpr std::uint16_t kFlagAnotherDaemon = 1u << 15;
// The daemon itself makes the request from saved data; it does not count as contact with the OBC.
inline constexpr std::uint16_t kFlagSaved = 1u << 14;

// A received command or heartbeat, before and after the armour. kind 0 is a heartbeat.
struct Request {
  Name source{};
  std::uint64_t sequence = 0;
  std::uint16_t kind = 0;
  std::uint16_t flags = 0;
  std::uint32_t lease_ms = 0;
  std::array<double, kMaxParameters> parameter{};
  ParameterName name{};
  TimeNs arrival_ns = 0;
  bool acknowledged = false;  // the acknowledgement "accepted" was sent
  bool answered = false;      // of an emergency stop: "completed" was sent, too
};

// Gives the parameters of a command names: Arguments is a struct with a member for each parameter,
// in the order of its kParameters, as in `struct Drive { double speed_m_s; bool autonomous; ... }`.
// The request must have passed the armour: values are in range, and whole for integer members.
template <class Arguments>
Arguments arguments(const Request& request) noexcept {
  if constexpr (requires { Arguments::kParameters; })
    static_assert(kMembers<Arguments> == std::size(Arguments::kParameters));
  static_assert(kMembers<Arguments> <= kMaxParameters);
  Arguments all{};
  const double* value = request.parameter.data();
  const auto take = [&]<class T>(T& member) {
    if constexpr (std::is_same_v<T, bool>) {
      member = *value++ > 0.5;
    } else {
      member = static_cast<T>(*value++);
    }
  };
  std::apply([&](auto&... member) { (take(member), ...); }, members::tie(all));
  return all;
}

template <class Kind>
constexpr std::uint16_t kind_of(Kind kind) noexcept {
  return static_cast<std::uint16_t>(kind);
}

inline bool is_emergency_stop(const Request& request) noexcept {
  return request.kind == kind_of(CommandKind::emergency_stop);
}

// Result of the guards: the guard that rejects the command, measured value, limit. Reason::none:
// the command is accepted.
struct Verdict {
  Reason reason = Reason::none;
  double measured = kRequired;  // NaN: the guard has no number
  double limit = kRequired;
  std::uint16_t subject = 0;  // module of the guard; 0: none
};

struct Ack {
  Name source{};
  std::uint64_t sequence = 0;
  std::uint16_t kind = 0;
  Phase phase = Phase::rejected;
  Verdict verdict{};
  TimeNs time_ns = 0;
};

struct EventRecord {
  TimeNs time_ns = 0;
  Severity severity = Severity::info;
  std::uint16_t id = 0;  // EventId, or FaultId + kFaultEventBase
  std::uint16_t subject = 0;
  std::uint32_t count = 1;  // events of its series so far (daemon/cycle/event_series.h)
  TimeNs first_ns = 0;      // time of the first one; `time_ns` is that of the newest
  std::array<double, 4> argument{};
};

struct FaultRecord {
  FaultId id = FaultId::none;
  std::uint16_t subject = 0;
  std::uint32_t count = 0;
  TimeNs since_ns = 0;
  bool operator==(const FaultRecord&) const = default;
};
inline constexpr std::size_t kMaxFaults = 16;

// The points in time of one frame (TALARIS thesis table 1).
struct TimingPoints {
  std::uint64_t frame = 0;
  TimeNs boundary_ns = 0;
  TimeNs woken_ns = 0;
  TimeNs read_ns = 0;
  TimeNs navigated_ns = 0;
  TimeNs ready_ns = 0;
  TimeNs released_ns = 0;  // of the previous frame
  TimeNs margin_ns = 0;
  TimeNs offset_ns = 0;
  std::uint64_t overruns = 0;
  std::uint64_t frames_skipped = 0;
  std::uint64_t frames_held = 0;  // begun by the clock because the sensor was silent
  std::uint64_t commands_repeated = 0;
  std::uint32_t samples = 0;
};

inline constexpr std::size_t kMaxThreads = 12;  // TALARIS with all of its ports has 11
struct ThreadStatus {
  std::array<char, 16> name{};
  int policy = 0;
  int priority = 0;
  int cpu = -1;
  bool granted = false;
  std::uint64_t page_faults = 0;  // since start
  std::uint64_t mallocs = 0;      // since start
  bool operator==(const ThreadStatus&) const = default;
};

// The contents of lss/status that are not in the configuration.
struct StatusReport {
  State state = State::idle;
  std::uint8_t mode = 0;
  const char* mode_name = "";
  Name authority{};
  std::array<FaultRecord, kMaxFaults> faults{};
  std::uint32_t fault_count = 0;
  TimeNs time_ns = 0;
  std::int64_t obc_age_ms = -1;
  std::uint64_t frame_index = 0;
  TimeNs period_ns = 0;
  TimeNs offset_ns = 0;
  std::uint64_t overruns = 0;
  std::uint64_t commands_rejected = 0;
  std::uint64_t safe_commands = 0;
  std::uint64_t telemetry_dropped = 0;
  bool recording = false;
  bool realtime_enforced = false;
  bool realtime_granted = false;
  bool memory_locked = false;
  std::uint64_t page_faults = 0;
  std::uint64_t mallocs = 0;
  std::array<ThreadStatus, kMaxThreads> threads{};
  std::uint32_t thread_count = 0;
  SavedState saved_parameters = SavedState::none;
  bool airborne = false;
  bool simulated_time = false;
  bool stop_falls = false;  // a pilot's STOP in the air is the emergency stop; false: land
  // (daemon/publish adds the state of shared memory)
  bool operator==(const StatusReport&) const = default;
};

}  // namespace lss
