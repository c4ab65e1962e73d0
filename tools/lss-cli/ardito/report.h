#pragma once

// Sections of a report on D.I.A.N.A. Ardito: wheels, steering, failures, path. One thread.

#include "tools/lss-cli/recording/recording.h"
#include "tools/lss-cli/report/page.h"

namespace lss::cli::ardito {

void add_report(const recording::Recording& recording, report::Page& page);

}  // namespace lss::cli::ardito
