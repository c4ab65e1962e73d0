#pragma once

// The parameters of D.I.A.N.A. Ardito that can change while the daemon runs (docs/parameters.md).
// Constant data; any thread.

#include "daemon/cycle/tunables.h"
#include "daemon/vehicles/ardito/config.h"

namespace lss::ardito {

const Tuning<Parameters>& tuning() noexcept;

}  // namespace lss::ardito
