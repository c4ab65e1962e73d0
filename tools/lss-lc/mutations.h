#pragma once

// How well the properties watch the table: every transition of it is broken in turn (left out, led
// elsewhere, without a guard, without an action), and the exploration must notice each time.

#include <string>
#include <vector>

#include "tools/lss-lc/explorer.h"

namespace lss::lc {

struct Mutations {
  std::size_t count = 0, caught = 0;
  std::size_t equivalent = 0;          // no reachable state behaves differently: nothing to notice
  std::vector<std::string> survivors;  // what was changed and nothing noticed
  double seconds = 0;
};

// `model_of` makes the model of a changed table; few modules are enough and quick. `modes`: how
// many the vehicle has, with none; `goals` likewise.
Mutations mutate(const Table& table, Model (*model_of)(const Table& table), std::uint8_t modes,
                 std::uint8_t goals);

}  // namespace lss::lc
