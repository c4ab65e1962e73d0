#pragma once

// Units of the IMUs' data sheets.

#include "idl/angles.h"

namespace lss::talaris {

inline constexpr double kG_m_s2 = 9.80665;  // standard gravity

}  // namespace lss::talaris
