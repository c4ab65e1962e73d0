#pragma once

// A patch of another soil under some wheels and along a stretch of the way. Pure functions; any
// thread.

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>

#include "tools/lss-sim/soil/soil.h"

namespace lss::sim::ardito {

struct Patch {
  soil::Soil soil;                                           // as measured, not in this gravity
  std::array<bool, 6> wheels{};                              // only these meet it
  double from_m = -std::numeric_limits<double>::infinity();  // x of the wheel's axle
  double to_m = std::numeric_limits<double>::infinity();

  // Of this soil in what is under the wheel: it grows from the edges inward over kEdge_m.
  double share(std::size_t wheel, double x_m) const {
    if (!wheels[wheel]) return 0;
    return std::clamp(std::min(x_m - from_m, to_m - x_m) / kEdge_m, 0.0, 1.0);
  }
  static constexpr double kEdge_m = 0.3;  // ours
};

// Each constant in between, the factor in proportion.
soil::Soil mixed(const soil::Soil& one, const soil::Soil& other, double share_of_other);

// SOIL[:FACTOR]@WHEELS[@FROM..TO]: wheels as digits, m ahead of the start. Throws
// std::invalid_argument.
Patch parse_patch(const std::string& text);

}  // namespace lss::sim::ardito
