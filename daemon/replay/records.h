#pragma once

// What the daemon's replay and programs that read recordings need to know about the vehicles of
// this build. daemon/vehicles/NAME/records.cpp defines NAME_records(). CMake makes the list from
// LSS_ROSTER in the top CMakeLists.txt. No DDS.

#include <optional>
#include <string>

#include "daemon/record/vehicle_records.h"

namespace lss {

// Empty if the vehicle is not in this build.
std::optional<record::VehicleRecords> vehicle_records(const std::string& vehicle);

}  // namespace lss
