#pragma once

// Verbs done one after the other under one heartbeat: what `run` and `shell` have in common. Main
// thread.

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "tools/lss-cli/grammar.h"
#include "tools/lss-cli/sequence.h"

namespace lss::cli {

struct Step {
  std::string where;                 // "FILE:3: ", before the text of what goes wrong
  std::unique_ptr<Grammar> grammar;  // holds what the action refers to
  Action action;
};

// What a file holds; "-": stdin.
std::string read_input(const std::string& name);

// All lines of the text are understood before the first is done; `name` names the text in errors,
// and without it there is no place to tell.
std::vector<Step> parse_steps(std::string_view text, const std::string& name);

// All of them, one after the other; then, unless it is to stay as it is, to a safe stop.
ExitCode run_steps(Context& context, const std::vector<Step>& steps, bool stay);

// Throws a Failure that says where. Ctrl-C brings the vehicle to a safe stop first.
void run_step(Context& context, const Step& step);

// Brings the vehicle to a safe stop when this session moved it.
void stop_attached(Context& context, const std::string& why);

}  // namespace lss::cli
