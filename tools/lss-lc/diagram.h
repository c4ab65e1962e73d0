#pragma once

// The locomotion controller as a picture, drawn by Graphviz from the exploration: states and modes
// as boxes, an arrow for every transition between them with its events. Made from the reachable
// transitions, so it shows exactly what can happen.

#include <string>

#include "tools/lss-lc/vehicle.h"

namespace lss::lc {

// Events that do not change the box are left out.
std::string diagram(const Verified& vehicle);

}  // namespace lss::lc
