#pragma once

// The parameters of TALARIS that can change while the daemon runs (docs/parameters.md). Constant
// data; any thread.

#include "daemon/core/tunables.h"
#include "daemon/vehicles/talaris_config.h"

namespace lss::talaris {

const Tuning<Parameters>& tuning() noexcept;

}  // namespace lss::talaris
