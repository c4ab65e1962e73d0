#pragma once

// Reject reasons, faults and events of D.I.A.N.A. Ardito itself (codes.inc). Pure data.

#include "idl/codes.h"

namespace lss::ardito {
#define LSS_OWN_CODES "idl/ardito/codes.inc"
#include "idl/own_codes.inc"
}  // namespace lss::ardito
