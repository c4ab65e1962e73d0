#pragma once

// Verbs done one after the other under one heartbeat: the common part of `run` and `shell`. Main
// thread.

#include <string>
#include <string_view>
#include <vector>

#include "tools/lss-cli/verbs/grammar.h"
#include "tools/lss-cli/verbs/sequence.h"

namespace lss::cli {

struct Step {
  std::string where;  // "FILE:3: ", before the error text
  Parsed parsed;
};

// The content of a file; "-": stdin.
std::string read_input(const std::string& name);

// Parses all lines before the first is executed. `name` is the name of the text in errors; without
// it errors have no place.
std::vector<Step> parse_steps(Context& context, std::string_view text, const std::string& name);

// Executes all steps in order; then, unless the vehicle is to stay as it is, a safe stop.
ExitCode run_steps(Context& context, const std::vector<Step>& steps, bool stay);

// Throws a Failure with the place. Ctrl-C, in it or before it, brings the vehicle to a safe stop
// first.
void run_step(Context& context, const Step& step);

// Brings the vehicle to a safe stop when this session moved it.
void stop_attached(Context& context, const std::string& why);

}  // namespace lss::cli
