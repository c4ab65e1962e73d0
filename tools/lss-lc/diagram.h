#pragma once

// The locomotion controller as a picture, drawn by Graphviz from what was explored: states and
// modes as boxes, an arrow for every way from one to another with the events that take it. Made
// from the reachable transitions, so it shows what can happen and nothing else.

#include <string>

#include "tools/lss-lc/vehicle.h"

namespace lss::lc {

// Events without a change of box are left out.
std::string diagram(const Verified& vehicle);

}  // namespace lss::lc
