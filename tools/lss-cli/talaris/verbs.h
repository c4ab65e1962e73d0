#pragma once

// The verbs of TALARIS that are more than one command: hop, edf, script. Main thread.

#include <string_view>

#include "tools/lss-cli/verbs/grammar.h"

namespace lss::cli::talaris {

void add_verbs(Grammar& grammar);

// Sends a script (script.h) under an id of its own, and runs it.
std::vector<Invocation> script_commands(std::string_view text);

// Commands that only these verbs send.
inline constexpr std::string_view kComposed[] = {"edf-arm",      "edf-throttle", "edf-rpm",
                                                 "script-begin", "script-step",  "script-run",
                                                 "script-abort"};
inline constexpr std::string_view kScriptParts[] = {"script-begin", "script-step", "script-run"};

}  // namespace lss::cli::talaris
