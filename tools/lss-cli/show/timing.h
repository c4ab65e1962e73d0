#pragma once

// The timing statistics of the daemon as received over DDS, and as a document for programs. Pure
// functions.

#include <nlohmann/json.hpp>

#include "idl/timing_statistics.h"
#include "lss.h"

namespace lss::cli {

constexpr double us(double ns) { return ns / 1000; }

TimingStatistics to_statistics(const lss_TimingStatistics& from);

// As `lss-cli timing --json` prints them.
nlohmann::json timing_json(const TimingStatistics& all);

}  // namespace lss::cli
