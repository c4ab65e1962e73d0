#pragma once

// The command table (idl/commands.h and the vehicle's own) as the command line uses it: finds a
// command, reads its parameters from the arguments, describes it. Pure functions. Errors are thrown
// as a Failure.

#include <array>
#include <map>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "idl/commands.h"

namespace lss::cli {

struct Vehicle;

// A command with its parameters, ready to be sent.
struct Invocation {
  const CommandInfo* info = nullptr;
  std::array<double, kMaxParameters> parameter{};
  std::string name = {};  // of a parameter, of a command that is `named`
};

// The commands of the vehicle, in the order of their numbers.
std::vector<const CommandInfo*> commands_of(const Vehicle& vehicle);
std::vector<std::string> command_names(const Vehicle& vehicle);
// ExitCode::unknown_name with the nearest name when there is none.
const CommandInfo& find_command(const Vehicle& vehicle, std::string_view name);
const CommandInfo& find_command(const Vehicle& vehicle, std::uint16_t kind);

// One of the commands that every vehicle has.
const CommandInfo& common_command(CommandKind kind);

// With every parameter at its default; none may be required.
Invocation with_defaults(const CommandInfo& info);

// `named` are the --NAME VALUE. A bare word (never empty) is the next required parameter, else one
// that knows the word, else the first number not yet given: "walk backward 30", "leg RM 90", "panel
// deploy".
Invocation read_invocation(const CommandInfo& info, const Vehicle& vehicle,
                           std::span<const std::string> words,
                           const std::map<std::string, std::string>& named);

// "walk forward heading 30 deg speed high".
std::string describe(const Invocation& invocation);
// The whole entry of the table, several lines.
std::string describe(const CommandInfo& info, const Vehicle& vehicle);
nlohmann::json to_json(const CommandInfo& info, const Vehicle& vehicle);

// The possible values of a parameter: its choices, or the names of modules; empty for a number.
std::vector<std::string> value_names(const ParameterInfo& parameter, const Vehicle& vehicle);

}  // namespace lss::cli
