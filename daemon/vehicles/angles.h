#pragma once

// Degrees, used in configurations, in radians, used everywhere else.

#include <numbers>

namespace lss {

inline constexpr double kDegree = std::numbers::pi / 180;  // rad

}  // namespace lss
