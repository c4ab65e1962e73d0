#pragma once

// Many missions as a document: quantiles, faults by type, and a histogram in text.

#include <span>
#include <string>

#include "tests/zebro/mission/mission.h"

namespace lss::zebro::mission {

// One line for a person who waits.
std::string line(const Result& result);

// `command`: that made it; `stamp`: when, and of which commit.
std::string document(std::span<const Result> results, const Options& options,
                     const std::string& command, const std::string& stamp);

}  // namespace lss::zebro::mission
