#pragma once

// The interactive lss-cli: a prompt with history and completion, one heartbeat for all lines, also
// while the user types. Main thread.

#include "tools/lss-cli/session/context.h"

namespace lss::cli {

ExitCode run_shell(Context& context);

}  // namespace lss::cli
