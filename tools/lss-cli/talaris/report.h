#pragma once

// Sections of a report on TALARIS: the hop, attitude, valves, fans, gas. One thread.

#include "tools/lss-cli/recording/recording.h"
#include "tools/lss-cli/report/page.h"

namespace lss::cli::talaris {

void add_report(const recording::Recording& recording, report::Page& page);

}  // namespace lss::cli::talaris
