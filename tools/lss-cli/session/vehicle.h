#pragma once

// The vehicle's part of the command line: its commands, the steps from the present state to one
// where a command is allowed, and the display of its telemetry. One `kVehicle` in
// tools/lss-cli/NAME/vehicle.cpp; the roster is made from LSS_VEHICLES by CMake. Pure functions;
// `telemetry` is a sample of the vehicle's own topic or nullptr.

#include <dds/dds.h>

#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "daemon/cycle/allowed.h"
#include "daemon/cycle/tunables.h"
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

struct Vehicle {
  std::string_view name;
  std::span<const CommandInfo> commands;  // its own
  std::span<const char* const> subjects;  // names of modules, wheels or nodes 1..n
  std::span<const VerbHelp> help;
  const dds_topic_descriptor_t* telemetry;
  std::vector<lc::Allowed> (*allowed)(const CommandInfo& info);  // when it is allowed

  // The commands that must be completed before `wanted` is allowed; without `wanted`.
  std::vector<Invocation> (*prepare)(const lss_Status& status, const Invocation& wanted);
  // It is endless (walk, drive) and is ended by the command `rest`.
  bool (*endless)(const Invocation& command);
  std::uint16_t rest;

  std::vector<Problem> (*problems)(const lss_Status& status, const void* telemetry);
  nlohmann::json (*json)(const void* telemetry);                     // telemetry.h
  std::string (*screen)(const void* telemetry, const Style& style);  // lines, each ended
  std::string (*details)(const void* telemetry,
                         const Style& style);  // all other measurements
  std::string (*progress)(const lss_Status& status, const void* telemetry);  // a few words
  std::optional<double> (*distance_m)(const void* telemetry);

  // The time that a command may take by itself, when longer than usual.
  double (*takes_s)(const Invocation& command) = nullptr;

  // Verbs of more than one command, and the commands that only they send.
  void (*add_verbs)(Grammar& grammar) = nullptr;
  std::span<const std::string_view> composed = {};
  // Parameters that can be changed while the daemon runs.
  std::span<const TunableInfo> (*tunables)() = nullptr;
  // The commands that send a text of timed actuations and run it, one after the other.
  std::vector<Invocation> (*script)(std::string_view text) = nullptr;
};

std::span<const Vehicle* const> vehicles();
const Vehicle* find_vehicle(std::string_view name);

// "RM" for 4, "module 9" for a module without a name, empty for the whole vehicle.
std::string subject_name(const Vehicle& vehicle, std::uint16_t subject);

}  // namespace lss::cli
