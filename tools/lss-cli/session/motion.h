#pragma once

// The sequence of a commanding verb: from the present state of the vehicle, through all necessary
// steps, to the end of the request, with a heartbeat all the time. Main thread; every wait is
// bounded or ends with Ctrl-C.

#include <optional>

#include "tools/lss-cli/session/context.h"

namespace lss::cli {

struct Motion {
  Invocation command;
  std::optional<double>
      for_s;           // of an endless one; without: until Ctrl-C, or in a sequence until the next
  bool stay = false;   // after for_s: standstill, but no stop
  bool hold = false;   // then keep up the heartbeat until Ctrl-C
  double takes_s = 0;  // by itself, when that is known
  std::optional<Invocation> ending = std::nullopt;  // the command of Ctrl-C instead of a safe stop
};

ExitCode run_motion(Context& context, const Motion& motion);

}  // namespace lss::cli
