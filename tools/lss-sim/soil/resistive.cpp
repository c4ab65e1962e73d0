#include "tools/lss-sim/soil/resistive.h"

#include <cmath>

namespace lss::sim::soil {
namespace {

// A for cosines and B for sines of the stress upwards, C and D of the one against the motion; the
// first index is that of beta (M: -1), the second that of gamma. Li, Zhang and Goldman, table S1.
constexpr double kA00 = 0.206, kA10 = 0.169, kB11 = 0.212, kB01 = 0.358, kBM11 = 0.055;
constexpr double kC11 = -0.124, kC01 = 0.253, kCM11 = 0.007, kD10 = 0.088;

// The series of the double tilt b and the angle of motion c, from their sines and cosines.
Resistance series(double sin_b, double cos_b, double sin_c, double cos_c) {
  const double ss = sin_b * sin_c, cc = cos_b * cos_c, sc = sin_b * cos_c, cs = cos_b * sin_c;
  return {.against = kC11 * (cc - ss) + kC01 * cos_c + kCM11 * (cc + ss) + kD10 * sin_b,
          .up = kA00 + kA10 * cos_b + kB11 * (sc + cs) + kB01 * sin_c + kBM11 * (cs - sc)};
}

}  // namespace

Resistance resistance(double tilt_rad, double down_rad) {
  return series(std::sin(2 * tilt_rad), std::cos(2 * tilt_rad), std::sin(down_rad),
                std::cos(down_rad));
}

// Measured for motions ahead; a motion back is the mirror image of one ahead. The double tilt of a
// normal needs no angle: sin 2 beta = -2 n_x n_z, cos 2 beta = n_z^2 - n_x^2.
Stress stress(double normal_ahead, double normal_up, double ahead_m_s, double up_m_s) {
  const double speed_m_s = std::sqrt(ahead_m_s * ahead_m_s + up_m_s * up_m_s);
  if (speed_m_s == 0) return {};
  const double side = ahead_m_s >= 0 ? 1 : -1;
  const Resistance r = series(-2 * side * normal_ahead * normal_up,
                              normal_up * normal_up - normal_ahead * normal_ahead,
                              -up_m_s / speed_m_s, std::abs(ahead_m_s) / speed_m_s);
  return {.ahead = -side * r.against, .up = r.up};
}

}  // namespace lss::sim::soil
