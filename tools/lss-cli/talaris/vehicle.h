#pragma once

// TALARIS at the command line.

#include "tools/lss-cli/session/vehicle.h"

namespace lss::cli::talaris {

extern const Overlay kOverlay;

// The vehicle of this build.
const Vehicle& vehicle();

// Its sections of a report; report.cpp.
void add_report(const recording::Recording& recording, report::Page& page);

}  // namespace lss::cli::talaris
