#pragma once

// Identifies this build, for recordings: build ID of the linker, compiler and its options. Start-up
// only.

#include <nlohmann/json.hpp>

namespace lss::record {

nlohmann::ordered_json this_build();

}  // namespace lss::record
