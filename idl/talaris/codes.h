#pragma once

// Reject reasons, faults and events of TALARIS itself (codes.inc). Pure data.

#include "idl/codes.h"

namespace lss::talaris {
#define LSS_OWN_CODES "idl/talaris/codes.inc"
#include "idl/own_codes.inc"
}  // namespace lss::talaris
