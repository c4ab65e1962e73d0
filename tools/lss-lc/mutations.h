#pragma once

// How well the properties watch the table: every transition of it is broken in turn (left out, led
// elsewhere, without a guard, without an action), and the exploration must notice each time.

#include <string>
#include <vector>

#include "tools/lss-lc/vehicle.h"

namespace lss::lc {

struct Mutations {
  std::size_t count = 0, caught = 0;
  std::size_t equivalent = 0;          // no reachable state behaves differently: nothing to notice
  std::vector<std::string> survivors;  // what was changed and nothing noticed
  double seconds = 0;
};

// With few modules, which is quick.
Mutations mutate(const Verified& vehicle);

}  // namespace lss::lc
