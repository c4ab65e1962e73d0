#pragma once

// Units of the IMUs' data sheets.

#include <numbers>

namespace lss::talaris {

inline constexpr double kDegree = std::numbers::pi / 180;  // rad
inline constexpr double kG_m_s2 = 9.80665;                 // standard gravity

}  // namespace lss::talaris
