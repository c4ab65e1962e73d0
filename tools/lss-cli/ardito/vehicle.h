#pragma once

// D.I.A.N.A. Ardito at the command line.

#include "tools/lss-cli/session/vehicle.h"

namespace lss::cli::ardito {

extern const Vehicle kVehicle;

}  // namespace lss::cli::ardito
