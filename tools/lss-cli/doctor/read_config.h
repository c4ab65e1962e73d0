#pragma once

// What the checks of lss-cli doctor need of a configuration. Lenient: lssd itself is the judge of
// the rest, of types, ranges and unknown keys.

#include <filesystem>
#include <string>
#include <tl/expected.hpp>
#include <vector>

#include "daemon/config/config.h"
#include "tools/lss-cli/doctor/system.h"

namespace lss::cli::doctor {

// Identity, ports, threads and DDS; what is missing or of another type has its default. Threads are
// those that the file names. The error is FILE:LINE:COLUMN: what.
tl::expected<config::Config, std::string> read_config(const std::filesystem::path& file);

// Those of all vehicles of the machine, in System::configurations.
std::vector<std::filesystem::path> configurations(const System& system);

}  // namespace lss::cli::doctor
