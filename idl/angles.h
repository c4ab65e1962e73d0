#pragma once

// Angles are in radians everywhere; degrees are for people: configurations, messages, tests.

#include <numbers>

namespace lss {

inline constexpr double kDegree = std::numbers::pi / 180;  // rad

}  // namespace lss
