#pragma once

// Identifies this build, for recordings: build ID of the linker, compiler and its options. Start-up
// only.

#include <nlohmann/json.hpp>
#include <string>

namespace lss::record {

nlohmann::ordered_json this_build();
// "0.1.0, build 09561392...": the version with the build ID.
std::string program_version(const std::string& version);

}  // namespace lss::record
