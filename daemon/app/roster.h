#pragma once

// The vehicles of this build. The wiring of each vehicle defines NAME_port(). CMake generates the
// list roster.inc from LSS_ROSTER in the top CMakeLists.txt. Start-up only.

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "daemon/app/app.h"
#include "daemon/config/config.h"

namespace lss {

// Makes the daemon of a vehicle after its own table of the configuration was read.
using Maker = std::function<std::unique_ptr<App>(const config::Config& config)>;

struct Port {
  std::function<Maker(config::Section& section)> read;  // reads [NAME]; errors go to the section
};

std::vector<std::string> vehicle_names();
Port vehicle_port(const std::string& name);

}  // namespace lss
