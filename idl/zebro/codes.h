#pragma once

// Reject reasons, faults and events of Lunar Zebro itself (codes.inc). Pure data.

#include "idl/codes.h"

namespace lss::zebro {
#define LSS_OWN_CODES "idl/zebro/codes.inc"
#include "idl/own_codes.inc"
}  // namespace lss::zebro
