#pragma once

// Measures how well the properties cover the table: every transition is changed in turn (removed,
// redirected, without a guard, without an action), and the exploration must detect each change.

#include <string>
#include <vector>

#include "tools/lss-lc/vehicle.h"

namespace lss::lc {

struct Mutations {
  std::size_t count = 0, caught = 0;
  std::size_t equivalent = 0;          // no reachable state behaves differently: nothing to detect
  std::vector<std::string> survivors;  // undetected changes
  double seconds = 0;
};

// With few modules, for speed.
Mutations mutate(const Verified& vehicle);

}  // namespace lss::lc
