#include "tools/lss-sim/soil/resistive.h"

#include <cmath>

namespace lss::sim::soil {
namespace {

// A for cosines and B for sines of the stress upwards, C and D of the one against the motion; the
// first index is that of beta (M: -1), the second that of gamma. Li, Zhang and Goldman, table S2.
constexpr double kA00 = 0.206, kA10 = 0.169, kB11 = 0.212, kB01 = 0.358, kBM11 = 0.055;
constexpr double kC11 = -0.124, kC01 = 0.253, kCM11 = 0.007, kD10 = 0.088;

}  // namespace

Resistance resistance(double tilt_rad, double down_rad) {
  const double b = 2 * tilt_rad, c = down_rad;
  return {.against = kC11 * std::cos(b + c) + kC01 * std::cos(c) + kCM11 * std::cos(c - b) +
                     kD10 * std::sin(b),
          .up = kA00 + kA10 * std::cos(b) + kB11 * std::sin(b + c) + kB01 * std::sin(c) +
                kBM11 * std::sin(c - b)};
}

// The series with the sums of angles resolved. A motion back is the mirror image of one ahead: the
// sign of the horizontal motion and that of the tilt against it cancel.
Plate::Plate(double normal_ahead, double normal_up) {
  const double sine = -2 * normal_ahead * normal_up;  // of twice the tilt against the axis ahead
  const double cosine = normal_up * normal_up - normal_ahead * normal_ahead;
  ahead_of_ahead = -(cosine * (kC11 + kCM11) + kC01);
  ahead_of_up = -sine * (kC11 - kCM11);
  ahead_of_speed = -sine * kD10;
  up_of_ahead = sine * (kB11 - kBM11);
  up_of_up = -(cosine * (kB11 + kBM11) + kB01);
  up_of_speed = kA00 + cosine * kA10;
}

Stress stress(const Plate& plate, double ahead_m_s, double up_m_s) {
  const double speed_m_s = std::sqrt(ahead_m_s * ahead_m_s + up_m_s * up_m_s);
  if (speed_m_s == 0) return {};
  const double ahead = ahead_m_s / speed_m_s, up = up_m_s / speed_m_s;
  return {.ahead = plate.ahead_of_ahead * ahead + plate.ahead_of_up * up + plate.ahead_of_speed,
          .up = plate.up_of_ahead * ahead + plate.up_of_up * up + plate.up_of_speed};
}

}  // namespace lss::sim::soil
