#pragma once

// A vehicle as the command line knows it: from the dictionary of its daemon, or, without a daemon,
// from that of this build (described_vehicle.h). What a dictionary cannot describe is an overlay in
// tools/lss-cli/NAME/vehicle.cpp; the roster is made from LSS_VEHICLES by CMake. Pure functions;
// `sample` is one of the vehicle's own topic.

#include <dds/dds.h>

#include <cstdint>
#include <functional>
#include <map>
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

namespace lss::config {
struct Config;
class Section;
}  // namespace lss::config

namespace lss::cli {

// Problems for a person, the worst first.
struct Problem {
  bool error = true;  // otherwise a warning: health stays good
  std::string text;
  std::string advice;
};

class Grammar;
namespace recording {
class Recording;
}
namespace report {
class Page;
}
namespace certify {
struct Wire;
}

struct Vehicle;

// Presentation of one type of telemetry (overlay.h). Used only while the daemon has the same IDL.
struct TelemetryView {
  std::string_view idl;
  const dds_topic_descriptor_t* type;
  nlohmann::ordered_json (*json)(const void* sample);
  std::string (*screen)(const Vehicle& vehicle, const void* sample, const Style& style);  // lines
  // A few words after the mode, with a blank before them.
  std::string (*progress)(const void* sample);
};

// Texts of timed actuations.
struct Scripts {
  // The commands that send a text and run it, one after the other; nullptr: it takes none.
  std::vector<Invocation> (*commands)(std::string_view text) = nullptr;
  std::span<const std::string_view> parts = {};  // commands that are useless alone
};

// Presentation of a vehicle that this program was built with, and its verbs of more than one
// command.
struct Overlay {
  TelemetryView telemetry;  // its type is named after the vehicle
  // Its own sections of a report.
  void (*add_report)(const recording::Recording& recording, report::Page& page);
  // Sets arguments of the start before a command.
  void (*start)(Invocation& start, const Invocation& wanted) = nullptr;
  // Verbs of more than one command, and the commands that only they send.
  void (*add_verbs)(Grammar& grammar) = nullptr;
  std::span<const std::string_view> composed = {};
  Scripts scripts = {};
  // Times on the wire with this configuration. `own`: the vehicle's table; bit_s: of its CAN.
  certify::Wire (*wire)(const config::Config& config, config::Section& own,
                        std::int64_t bit_s) = nullptr;
};
std::span<const Overlay* const> overlays();
// Of the vehicles of this build.
std::vector<std::string> built_dictionaries();

struct Vehicle {
  std::string_view name;
  std::span<const CommandInfo> commands;          // its own
  std::span<const char* const> subjects;          // names of modules, wheels or nodes 1..n
  std::map<std::uint16_t, std::string> examples;  // of the help of commands: lines
  const dds_topic_descriptor_t* telemetry;        // nullptr: its type is not known
  std::string_view idl;                           // of it
  std::function<std::vector<lc::Allowed>(const CommandInfo& info)> allowed;  // when it is allowed

  // The commands that must be completed before `wanted` is allowed; without `wanted`.
  std::function<std::vector<Invocation>(const lss_Status& status, const Invocation& wanted)>
      prepare;
  // Ends an endless command (walk, drive) without switching off.
  std::uint16_t rest;
  std::string_view at_rest;  // outside Operational

  std::function<std::vector<Problem>(const lss_Status& status, const void* sample)> problems;
  std::function<nlohmann::json(const void* sample)> json;
  std::function<std::string(const void* sample, const Style& style)> screen;  // lines, each ended
  // All other measurements.
  std::function<std::string(const void* sample, const Style& style)> details;
  std::function<std::string(const void* sample)> progress;  // may be empty
  std::function<std::optional<double>(const void* sample)> distance_m;

  // Of an endless command: with these parameters it ends by itself.
  std::function<bool(const Invocation& command)> ends;
  // The time that a command may take by itself; 0: the usual one.
  std::function<double(const Invocation& command)> takes_s;

  // Parameters that can be changed while the daemon runs.
  std::span<const TunableInfo> tunables;
  OwnCodes codes = {};
  const Overlay* overlay = nullptr;  // nullptr: none
  // Of its dictionary: of the telemetry, and how it is shown.
  const nlohmann::json *fields = nullptr, *presentation = nullptr;
};

// Those of this build.
std::span<const Vehicle* const> vehicles();
const Vehicle* find_vehicle(std::string_view name);
// Those of the vehicle itself; none of one that is not on the roster.
OwnCodes codes_of(std::string_view vehicle);

// It goes on until another command.
bool is_endless(const Vehicle& vehicle, const Invocation& command);

// The command is sent by its own verbs only.
bool is_composed(const Vehicle& vehicle, std::string_view command);

// A few words on its mode and motion. `telemetry`: a sample, or nullptr.
std::string progress(const Vehicle& vehicle, const lss_Status& status, const void* telemetry);
// The display of its telemetry; a sample, or nullptr.
std::string screen(const Vehicle& vehicle, const void* telemetry, const Style& style);

// "RM" for 4, "module 9" for a module without a name, empty for the whole vehicle.
std::string subject_name(const Vehicle& vehicle, std::uint16_t subject);

}  // namespace lss::cli
