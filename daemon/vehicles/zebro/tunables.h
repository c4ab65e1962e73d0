#pragma once

// The parameters of Lunar Zebro that can change while the daemon runs (docs/parameters.md).
// Constant data; any thread.

#include "daemon/cycle/tunables.h"
#include "daemon/vehicles/zebro/config.h"

namespace lss::zebro {

const Tuning<Parameters>& tuning() noexcept;

}  // namespace lss::zebro
