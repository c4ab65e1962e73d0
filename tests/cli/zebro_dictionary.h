#pragma once

// The dictionary of a daemon of Lunar Zebro, for tests that change it. Pure.

#include <string>

#include "daemon/publish/dictionary.h"
#include "daemon/vehicles/zebro/modes.h"
#include "daemon/vehicles/zebro/tunables.h"
#include "idl/idl_text.h"
#include "idl/zebro/commands.h"

namespace lss::cli::test {

inline std::string zebro_dictionary() {
  const Vocabulary vocabulary{.modes = lss::zebro::kModeNames,
                              .modules = lss::zebro::kModuleNames,
                              .strategies = lss::zebro::kStrategyNames,
                              .commands = lss::zebro::kCommands,
                              .tunables = lss::zebro::tuning().infos};
  return dictionary("zebro", lss::zebro::logic(), vocabulary, "time_ns:i8;", idl_text("zebro"));
}

}  // namespace lss::cli::test
