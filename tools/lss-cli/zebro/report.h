#pragma once

// Sections of a report on Lunar Zebro: gait, modules, path. One thread.

#include "tools/lss-cli/recording/recording.h"
#include "tools/lss-cli/report/page.h"

namespace lss::cli::zebro {

void add_report(const recording::Recording& recording, report::Page& page);

}  // namespace lss::cli::zebro
