#include "gnc/talaris/filters.h"

#include <cmath>

#include "gnc/math.h"

namespace lss::gnc::talaris {
namespace {
constexpr double kPi = 3.14159265358979323846;
constexpr double kSqrt2 = 1.41421356237309504880;
}  // namespace

FilterCoefficients butterworth(double corner_hz, double fs_hz) noexcept {
  if (!(corner_hz > 0) || !(corner_hz < fs_hz / 2)) return {};
  const double k = math::tan(kPi * corner_hz / fs_hz);
  const double n = 1 / (1 + kSqrt2 * k + k * k);
  return {n * k * k, 2 * n * k * k, n * k * k, 2 * (k * k - 1) * n, (1 - kSqrt2 * k + k * k) * n};
}

FilterCoefficients notch(double notch_hz, double fs_hz, double quality) noexcept {
  if (!(notch_hz > 0) || !(notch_hz <= fs_hz / 4) || !(quality > 0)) return {};
  const double w = 2 * kPi * notch_hz / fs_hz;
  const double alpha = math::sin(w) / (2 * quality);
  const double n = 1 / (1 + alpha);
  return {n, -2 * math::cos(w) * n, n, -2 * math::cos(w) * n, (1 - alpha) * n};
}

double Filter::step(double x) noexcept {
  if (!std::isfinite(x)) return y_;
  if (!begun_) {
    // the states after a signal that was always x
    const double gain = (c_.b0 + c_.b1 + c_.b2) / (1 + c_.a1 + c_.a2);
    y_ = gain * x;
    s2_ = c_.b2 * x - c_.a2 * y_;
    s1_ = c_.b1 * x - c_.a1 * y_ + s2_;
    begun_ = true;
    return y_;
  }
  y_ = c_.b0 * x + s1_;
  s1_ = c_.b1 * x - c_.a1 * y_ + s2_;
  s2_ = c_.b2 * x - c_.a2 * y_;
  return y_;
}

}  // namespace lss::gnc::talaris
