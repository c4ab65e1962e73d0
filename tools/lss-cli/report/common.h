#pragma once

// The sections that reports of all vehicles share. Each says so when the recording has nothing of
// its kind. One thread.

#include "tools/lss-cli/recording/recording.h"
#include "tools/lss-cli/report/page.h"
#include "tools/lss-cli/vehicle.h"

namespace lss::cli::report {

void add_states(const recording::Recording& recording, Page& page);
void add_timing(const recording::Recording& recording, Page& page);
void add_events(const recording::Recording& recording, Page& page);
// `vehicle` names its commands; nullptr: not of this build.
void add_commands(const recording::Recording& recording, const Vehicle* vehicle, Page& page);
void add_topics(const recording::Recording& recording, Page& page);

}  // namespace lss::cli::report
