#pragma once

// The dictionary of a daemon of Lunar Zebro, for tests that change it. Pure.

#include <string>

#include "daemon/publish/dictionary.h"
#include "daemon/vehicles/zebro/modes.h"
#include "daemon/vehicles/zebro/words.h"
#include "idl/idl_text.h"

namespace lss::cli::test {

inline std::string zebro_dictionary() {
  return dictionary("zebro", lss::zebro::logic(), lss::zebro::vocabulary(), "time_ns:i8;",
                    idl_text("zebro"));
}

}  // namespace lss::cli::test
