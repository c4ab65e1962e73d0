#pragma once

// The command table: every command of the DDS face with its number, parameters, units and ranges.
// The daemon's armour validates with it; `lss-cli` parses, lists and describes with it; the
// documents are generated from it. Commands of all vehicles are here (1..99); a vehicle's own are
// in idl/NAME/commands.h. Pure data, callable from every thread.

#include <cstdint>
#include <limits>
#include <span>

namespace lss {

inline constexpr std::size_t kMaxParameters = 8;       // of lss::Command in lss.idl
inline constexpr std::size_t kNameSize = 48;           // of lss::Command.name, with its NUL
inline constexpr std::uint16_t kFlagDryRun = 1u << 0;  // evaluate the guards, do nothing

struct ParameterInfo {
  const char* name;
  // "rad", "s", ""; unit of a choice: "choice"; of a set of numbered things: "set", bit i is i + 1.
  const char* unit;
  double min;
  double max;
  double fallback;             // sent by the command line when not given; NaN: required
  const char* const* choices;  // choices[i] is the name of value min + i; nullptr for a number
  const char* help;
  bool whole = false;  // a number without a fraction; choices always are

  constexpr bool is_whole() const { return whole || choices != nullptr; }
};

// Allowed senders.
enum class Access : std::uint8_t {
  anyone,  // data, emergency stop, land
  holder,  // takes authority, or needs it
};

struct CommandInfo {
  std::uint16_t kind;
  const char* name;
  Access access;
  bool leased;  // has a motion lease
  const char* summary;
  std::span<const ParameterInfo> parameters = {};
  // Stops the vehicle: never waits behind other commands; earlier commands are not obeyed after it.
  bool ends_motion = false;
  // Goes on until another command: walk, drive.
  bool endless = false;
  // lss::Command.name says of which parameter of the vehicle; of all others it is empty.
  bool named = false;
};

inline constexpr std::span<const ParameterInfo> kNoParameters;

// age_ms of telemetry: no message came since the start.
inline constexpr std::uint64_t kNeverHeard_ms = std::numeric_limits<std::uint64_t>::max();

inline constexpr double kRequired = std::numeric_limits<double>::quiet_NaN();
inline constexpr const char* kNoYes[] = {"no", "yes"};
inline constexpr const char* kOffOn[] = {"off", "on"};

// Maximum number of parameters that can change while the daemon runs.
inline constexpr std::size_t kMaxTunables = 40;

// Commands of every vehicle. start, stop and reset have parameters of the vehicle and are in its
// list.
enum class CommandKind : std::uint16_t {
  none = 0,
  start = 1,
  stop = 2,
  emergency_stop = 3,
  solve = 4,
  reset = 5,
  request_data = 6,
  reset_timing = 7,
  restore = 8,
  set_parameter = 9,
  save_parameters = 10,
};

// Ranges and units of each: lss/parameters, or docs/parameters.md.
struct SetParameter {
  double value;
  static constexpr ParameterInfo kParameters[] = {
      {"value", "", -1e9, 1e9, kRequired, nullptr, "in its unit of the configuration"},
  };
};
// Its range and help are the vehicle's.
struct Reset {
  int module;  // 0: all of them; -1: the controller itself
};

inline constexpr CommandInfo kCommonCommands[] = {
    {3, "estop", Access::anyone, false, "emergency stop of everything, at once, from anyone",
     kNoParameters, true},
    {4, "solve", Access::holder, false, "leave FatalError: run the error-solving strategies"},
    {6, "data", Access::anyone, false, "ask for one telemetry sample"},
    {7, "reset-timing", Access::anyone, false, "restart the timing statistics"},
    {8, "restore", Access::holder, false,
     "put modules that error solving isolated into service again"},
    {.kind = 9,
     .name = "set-parameter",
     .access = Access::holder,
     .leased = false,
     .summary = "change a parameter; until the daemon ends",
     .parameters = SetParameter::kParameters,
     .named = true},
    {10, "save-parameters", Access::holder, false,
     "save the present parameters for the next start"},
};

}  // namespace lss
