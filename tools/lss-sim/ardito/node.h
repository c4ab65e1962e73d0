#pragma once

// The base of all nodes of D.I.A.N.A. Ardito: CANopen nodes of docs/icd-ardito.md.

#include "tools/lss-sim/canopen/node.h"

namespace lss::sim::ardito {

using namespace nodes;  // the base class of its drives and devices

inline constexpr std::uint32_t kProduct = 0x0A12D170;

}  // namespace lss::sim::ardito
