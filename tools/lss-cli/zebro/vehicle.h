#pragma once

// Lunar Zebro on the command line: the table of its legs. See session/vehicle.h.

#include "tools/lss-cli/session/vehicle.h"

namespace lss::cli::zebro {

extern const Overlay kOverlay;

// Its sections of a report; report.cpp.
void add_report(const recording::Recording& recording, report::Page& page);

}  // namespace lss::cli::zebro
