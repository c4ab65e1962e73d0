#pragma once

// Patches of another soil under Ardito's wheels, by the x of a wheel's axle.

#include "tools/lss-sim/soil/patch.h"

namespace lss::sim::ardito {

using soil::Patch;

inline constexpr double kPatchEdge_m = 0.3;  // ours

inline Patch parse_patch(const std::string& text) {
  return soil::parse_patch(text, "wheel", kPatchEdge_m);
}

}  // namespace lss::sim::ardito
