#pragma once

// Which build this is, for recordings: what the linker numbered it, the compiler and how it was
// asked to compile. Start-up only.

#include <nlohmann/json.hpp>

namespace lss::record {

nlohmann::ordered_json this_build();

}  // namespace lss::record
