#pragma once

// A patch of another soil under some of six wheels or legs, along a stretch of the way. Pure
// functions; any thread.

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>

#include "tools/lss-sim/soil/soil.h"

namespace lss::sim::soil {

struct Patch {
  Soil soil;                    // as measured, not in this gravity
  std::array<bool, 6> parts{};  // only these wheels or legs meet it
  double edge_m = 0;
  double from_m = -std::numeric_limits<double>::infinity();  // ahead of the start
  double to_m = std::numeric_limits<double>::infinity();

  // Of this soil in what is under the part at this x: it grows from the edges inward over edge_m.
  double share(std::size_t part, double x_m) const {
    if (!parts[part]) return 0;
    return std::clamp(std::min(x_m - from_m, to_m - x_m) / edge_m, 0.0, 1.0);
  }
};

// Each constant in between, the factor in proportion.
Soil mixed(const Soil& one, const Soil& other, double share_of_other);

// SOIL[:FACTOR]@PARTS[@FROM..TO]: parts as digits, m ahead of the start; `part`: "wheel" or "leg".
// Throws std::invalid_argument.
Patch parse_patch(const std::string& text, const std::string& part, double edge_m);

}  // namespace lss::sim::soil
