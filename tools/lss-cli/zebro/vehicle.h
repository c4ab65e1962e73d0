#pragma once

// Lunar Zebro on the command line: its commands, the steps from standing, lying or walking to a
// state where a command is allowed, and the table of its legs. See vehicle.h.

#include "tools/lss-cli/session/vehicle.h"

namespace lss::cli::zebro {

extern const Vehicle kVehicle;

// Its sections of a report; report.cpp.
void add_report(const recording::Recording& recording, report::Page& page);

}  // namespace lss::cli::zebro
