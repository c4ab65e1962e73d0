#pragma once

// What all nodes of D.I.A.N.A. Ardito are: CANopen nodes, as docs/icd-ardito.md has them.

#include "tools/lss-sim/canopen_node.h"

namespace lss::sim::ardito {

using namespace nodes;  // its drives and devices are nodes with more on them

inline constexpr std::uint32_t kProduct = 0x0A12D170;

}  // namespace lss::sim::ardito
