#pragma once

// An angle by its sine and cosine, which most formulas need: computed once from the angle, composed
// from then on.

#include <cmath>

#include "gnc/math.h"

namespace lss::gnc::ardito {

// For a velocity sigma and sigma + pi are the same line.
struct Direction {
  double sin = 0;
  double cos = 1;
};

inline Direction direction(double angle_rad) noexcept {
  return {math::sin(angle_rad), math::cos(angle_rad)};
}
// Of the sum of both angles.
inline Direction turned(const Direction& a, const Direction& b) noexcept {
  return {a.sin * b.cos + a.cos * b.sin, a.cos * b.cos - a.sin * b.sin};
}
inline Direction opposite(const Direction& a) noexcept { return {-a.sin, a.cos}; }

}  // namespace lss::gnc::ardito
