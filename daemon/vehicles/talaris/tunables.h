#pragma once

// The parameters of TALARIS that can change while the daemon runs (docs/parameters.md). Constant
// data; any thread.

#include "daemon/cycle/tunables.h"
#include "daemon/vehicles/talaris/config.h"

namespace lss::talaris {

const Tuning<Parameters>& tuning() noexcept;

}  // namespace lss::talaris
