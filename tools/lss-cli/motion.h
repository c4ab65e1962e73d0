#pragma once

// What a commanding verb does: from where the vehicle is, through whatever must come first, to the
// end of what was asked, attached with a heartbeat all the while. Main thread; every wait is
// bounded or ends with Ctrl-C.

#include <optional>

#include "tools/lss-cli/context.h"

namespace lss::cli {

struct Motion {
  Invocation command;
  std::optional<double>
      for_s;           // of an endless one; without: until Ctrl-C, or in a sequence until the next
  bool stay = false;   // after for_s: rest, but do not stop
  bool hold = false;   // then keep up the heartbeat until Ctrl-C
  double takes_s = 0;  // by itself, when that is known
  std::optional<Invocation> ending = std::nullopt;  // what Ctrl-C does instead of a safe stop
};

ExitCode run_motion(Context& context, const Motion& motion);

}  // namespace lss::cli
