#pragma once

// Lunar Zebro on the command line: its commands, how to get from where it stands, lies or walks to
// where a command may be given, and the table of its legs. See vehicle.h.

#include "tools/lss-cli/vehicle.h"

namespace lss::cli::zebro {

extern const Vehicle kVehicle;

}  // namespace lss::cli::zebro
