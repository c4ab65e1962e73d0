#pragma once

// The report sections of each vehicle; made from LSS_VEHICLES by CMake. Pure.

#include <string_view>

#include "tools/lss-cli/recording/recording.h"
#include "tools/lss-cli/report/page.h"

namespace lss::cli::report {

// False when this build does not have the vehicle.
bool add_vehicle(std::string_view vehicle, const recording::Recording& recording, Page& page);

}  // namespace lss::cli::report
