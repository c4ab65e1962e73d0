#pragma once

// D.I.A.N.A. Ardito at the command line.

#include "tools/lss-cli/session/vehicle.h"

namespace lss::cli::ardito {

extern const Overlay kOverlay;

// Its sections of a report; report.cpp.
void add_report(const recording::Recording& recording, report::Page& page);

}  // namespace lss::cli::ardito
