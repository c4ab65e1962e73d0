#pragma once

// Record operations of the vehicles of this build: daemon/vehicles/NAME/records.cpp defines
// NAME_records(), the roster in the top CMakeLists.txt makes the list. For the daemon's replay and
// for programs that read recordings; no DDS.

#include <optional>
#include <string>

#include "daemon/record/vehicle_records.h"

namespace lss {

// Nothing: the vehicle is not in this build.
std::optional<record::VehicleRecords> vehicle_records(const std::string& vehicle);

}  // namespace lss
