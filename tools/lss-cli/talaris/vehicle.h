#pragma once

// TALARIS at the command line.

#include "tools/lss-cli/session/vehicle.h"

namespace lss::cli::talaris {

extern const Vehicle kVehicle;

}  // namespace lss::cli::talaris
