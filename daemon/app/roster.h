#pragma once

// The vehicles of this build. Each vehicle's wiring defines NAME_port(); the roster in the top
// CMakeLists.txt makes the list (generated roster.inc). Start-up only.

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "daemon/app/app.h"
#include "daemon/config/config.h"

namespace lss {

// Makes the daemon of a vehicle whose own table of the configuration has been read.
using Maker = std::function<std::unique_ptr<App>(const config::Config& config)>;

struct Port {
  std::function<Maker(config::Section& section)> read;  // reads [NAME]; errors go to the section
};

std::vector<std::string> vehicle_names();
Port vehicle_port(const std::string& name);

}  // namespace lss
