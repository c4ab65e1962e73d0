#pragma once

// The sections that reports of all vehicles share. Each states when the recording has no data for
// it. One thread.

#include "tools/lss-cli/recording/recording.h"
#include "tools/lss-cli/report/page.h"
#include "tools/lss-cli/session/vehicle.h"

namespace lss::cli::report {

void add_states(const recording::Recording& recording, Page& page);
void add_timing(const recording::Recording& recording, Page& page);
void add_events(const recording::Recording& recording, Page& page);
// `vehicle` names its commands; nullptr: not of this build.
void add_commands(const recording::Recording& recording, const Vehicle* vehicle, Page& page);
void add_topics(const recording::Recording& recording, Page& page);

}  // namespace lss::cli::report
