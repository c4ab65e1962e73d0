#pragma once

// The parameters of D.I.A.N.A. Ardito that can change while the daemon runs (docs/parameters.md).
// Constant data; any thread.

#include "daemon/cycle/tunables.h"
#include "daemon/vehicles/ardito/config.h"

namespace lss::ardito {

const Tuning<Parameters>& tuning() noexcept;

// nullptr, or that the wheel drives' ramp, which is also that of a quick stop, is too flat.
const char* check_ramp(const Parameters& parameters) noexcept;

}  // namespace lss::ardito
