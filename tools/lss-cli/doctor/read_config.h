#pragma once

// Reads the part of a configuration that the checks of lss-cli doctor need. Lenient: lssd itself
// checks everything else, types, ranges and unknown keys.

#include <filesystem>
#include <string>
#include <tl/expected.hpp>
#include <vector>

#include "daemon/config/config.h"
#include "tools/lss-cli/doctor/system.h"

namespace lss::cli::doctor {

// Identity, ports, threads and DDS; a missing value or one of another type has its default. Only
// the threads that the file names. The error is FILE:LINE:COLUMN: what.
tl::expected<config::Config, std::string> read_config(const std::filesystem::path& file);

// The configurations of all vehicles of the machine, from System::configurations.
std::vector<std::filesystem::path> configurations(const System& system);

}  // namespace lss::cli::doctor
