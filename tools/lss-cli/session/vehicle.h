#pragma once

// The vehicle's part of the command line: its commands, the steps from the present state to one
// where a command is allowed, and the display of its telemetry. One `kVehicle` in
// tools/lss-cli/NAME/vehicle.cpp; the roster is made from LSS_VEHICLES by CMake. Of a vehicle that
// is not on it: described_vehicle.h. Pure functions; `sample` is one of the vehicle's own topic.

#include <dds/dds.h>

#include <cstdint>
#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "daemon/cycle/allowed.h"
#include "daemon/cycle/tunables.h"
#include "idl/codes.h"
#include "lss.h"
#include "tools/lss-cli/session/commands.h"
#include "tools/lss-cli/show/output.h"

namespace lss::cli {

// Problems for a person, the worst first.
struct Problem {
  bool error = true;  // otherwise a warning: health stays good
  std::string text;
  std::string advice;
};

// A verb's help in addition to the command table.
struct VerbHelp {
  std::string_view verb;
  std::string_view examples;  // lines
};

class Grammar;
namespace recording {
class Recording;
}
namespace report {
class Page;
}

struct Vehicle {
  std::string_view name;
  std::span<const CommandInfo> commands;  // its own
  std::span<const char* const> subjects;  // names of modules, wheels or nodes 1..n
  std::span<const VerbHelp> help;
  const dds_topic_descriptor_t* telemetry;  // nullptr: its type is not known
  std::function<std::vector<lc::Allowed>(const CommandInfo& info)> allowed;  // when it is allowed

  // The commands that must be completed before `wanted` is allowed; without `wanted`.
  std::function<std::vector<Invocation>(const lss_Status& status, const Invocation& wanted)>
      prepare;
  // Ends an endless command (walk, drive) without switching off.
  std::uint16_t rest;

  std::function<std::vector<Problem>(const lss_Status& status, const void* sample)> problems;
  std::function<nlohmann::json(const void* sample)> json;                     // telemetry.h
  std::function<std::string(const void* sample, const Style& style)> screen;  // lines, each ended
  // All other measurements.
  std::function<std::string(const void* sample, const Style& style)> details = {};
  // A few words after the mode, with a blank before them.
  std::function<std::string(const void* sample)> progress = {};
  std::function<std::optional<double>(const void* sample)> distance_m;
  std::string_view at_rest = "motors off";  // outside Operational
  // Its own sections of a report.
  void (*add_report)(const recording::Recording& recording, report::Page& page) = nullptr;

  // Of an endless command: with these parameters it ends by itself.
  bool (*ends)(const Invocation& command) = nullptr;

  // The time that a command may take by itself, when longer than usual.
  double (*takes_s)(const Invocation& command) = nullptr;

  // Verbs of more than one command, and the commands that only they send.
  void (*add_verbs)(Grammar& grammar) = nullptr;
  std::span<const std::string_view> composed = {};
  // Parameters that can be changed while the daemon runs.
  std::function<std::span<const TunableInfo>()> tunables = nullptr;
  // The commands that send a text of timed actuations and run it, one after the other.
  std::vector<Invocation> (*script)(std::string_view text) = nullptr;

  OwnCodes codes = {};
  std::string_view idl = {};  // of a vehicle that is not on the roster
};

std::span<const Vehicle* const> vehicles();
const Vehicle* find_vehicle(std::string_view name);
// Those of the vehicle itself; none of one that is not on the roster.
OwnCodes codes_of(std::string_view vehicle);

// It goes on until another command.
bool is_endless(const Vehicle& vehicle, const Invocation& command);
// The text of the IDL of its telemetry.
std::string_view idl_of(const Vehicle& vehicle);

// A few words on its mode and motion. `telemetry`: a sample, or nullptr.
std::string progress(const Vehicle& vehicle, const lss_Status& status, const void* telemetry);
// The display of its telemetry; a sample, or nullptr.
std::string screen(const Vehicle& vehicle, const void* telemetry, const Style& style);

// "RM" for 4, "module 9" for a module without a name, empty for the whole vehicle.
std::string subject_name(const Vehicle& vehicle, std::uint16_t subject);

}  // namespace lss::cli
