#include "gnc/math.h"

#include <array>
#include <cmath>
#include <limits>
#include <numbers>

namespace lss::gnc::math {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

// pi / 2 in parts of 33, 33 and 53 bits: a whole number below 2^20 times one of the first two is
// exact (W. Cody, W. Waite, Software Manual for the Elementary Functions, 1980).
constexpr double kHalfPi1 = 0x1.921fb544p+0, kHalfPi2 = 0x1.0b4611a6p-34,
                 kHalfPi3 = 0x1.3198a2e037073p-69;
constexpr double kLargest_rad = 1.6e6;

constexpr double kHalfPi = std::numbers::pi / 2;
constexpr double kHalfPiRest = 0x1.1a62633145c07p-54;  // pi / 2 - kHalfPi

// ln 2 in parts of 32 and 53 bits.
constexpr double kLn2_1 = 0x1.62e42feep-1, kLn2_2 = 0x1.a39ef35793c76p-33;

// An angle less whole quarters of a turn: `high + low` from -pi/4 to pi/4.
struct Reduced {
  int quarter = 0;  // 0..3
  double high = 0, low = 0;
};

Reduced reduce(double x_rad) noexcept {
  if (std::abs(x_rad) > kLargest_rad) x_rad = std::remainder(x_rad, 2 * std::numbers::pi);
  const double quarters = std::round(x_rad * (2 / std::numbers::pi));
  const double exact = x_rad - quarters * kHalfPi1;
  const double second = quarters * kHalfPi2;
  const double first = exact - second;
  const double back = first - exact;
  const double lost = (exact - (first - back)) - (second + back);  // Knuth's sum of two
  const double low = lost - quarters * kHalfPi3;
  const double high = first + low;
  return {static_cast<int>(quarters) & 3, high, (first - high) + low};
}

// Taylor's series; the first omitted term is below 1e-19 of the result.
double sine(double r, double low) noexcept {
  const double z = r * r;
  const double s =
      -1.0 / 6 +
      z * (1.0 / 120 +
           z * (-1.0 / 5040 + z * (1.0 / 362880 + z * (-1.0 / 39916800 +
                                                       z * (1.0 / 6227020800 +
                                                            z * (-1.0 / 1307674368000 +
                                                                 z * (1.0 / 355687428096000)))))));
  return r + (r * z * s + low * (1 - z / 2));
}

double cosine(double r, double low) noexcept {
  const double z = r * r;
  const double c =
      1.0 / 24 +
      z * (-1.0 / 720 +
           z * (1.0 / 40320 +
                z * (-1.0 / 3628800 + z * (1.0 / 479001600 + z * (-1.0 / 87178291200 +
                                                                  z * (1.0 / 20922789888000))))));
  const double one = 1 - z / 2;
  return one + (((1 - one) - z / 2) + (z * z * c - r * low));
}

// atan(x) for 0 <= x <= 1: atan(i / 16) from a table, and the series of the rest, at most 1 / 32.
constexpr std::array<double, 17> kAtan = {
    0x0p+0,
    0x1.ff55bb72cfdeap-5,
    0x1.fd5ba9aac2f6ep-4,
    0x1.7b97b4bce5b02p-3,
    0x1.f5b75f92c80ddp-3,
    0x1.362773707ebccp-2,
    0x1.6f61941e4def1p-2,
    0x1.a64eec3cc23fdp-2,
    0x1.dac670561bb4fp-2,
    0x1.0657e94db30dp-1,
    0x1.1e00babdefeb4p-1,
    0x1.345f01cce37bbp-1,
    0x1.4978fa3269ee1p-1,
    0x1.5d58987169b18p-1,
    0x1.700a7c5784634p-1,
    0x1.819d0b7158a4dp-1,
    0x1.921fb54442d18p-1,
};

double atan_to_one(double x) noexcept {
  const double i = std::round(16 * x);
  const double t = (x - i / 16) / (1 + x * (i / 16));
  const double z = t * t;
  const double s =
      z * (-1.0 / 3 + z * (1.0 / 5 + z * (-1.0 / 7 + z * (1.0 / 9 + z * (-1.0 / 11)))));
  return kAtan[static_cast<std::size_t>(i)] + (t + t * s);
}

}  // namespace

double sin(double x_rad) noexcept {
  if (!std::isfinite(x_rad)) return kNaN;
  if (x_rad == 0) return x_rad;
  const Reduced a = reduce(x_rad);
  switch (a.quarter) {
    case 0: return sine(a.high, a.low);
    case 1: return cosine(a.high, a.low);
    case 2: return -sine(a.high, a.low);
    default: return -cosine(a.high, a.low);
  }
}

double cos(double x_rad) noexcept {
  if (!std::isfinite(x_rad)) return kNaN;
  const Reduced a = reduce(x_rad);
  switch (a.quarter) {
    case 0: return cosine(a.high, a.low);
    case 1: return -sine(a.high, a.low);
    case 2: return -cosine(a.high, a.low);
    default: return sine(a.high, a.low);
  }
}

double tan(double x_rad) noexcept {
  if (!std::isfinite(x_rad)) return kNaN;
  if (x_rad == 0) return x_rad;
  const Reduced a = reduce(x_rad);
  const double s = sine(a.high, a.low), c = cosine(a.high, a.low);
  return a.quarter % 2 == 0 ? s / c : -c / s;
}

double atan2(double y, double x) noexcept {
  if (std::isnan(x) || std::isnan(y)) return kNaN;
  const double up = std::abs(y), along = std::abs(x);
  double angle_rad = 0;
  if (up == along && (up == 0 || std::isinf(up))) {
    angle_rad = up == 0 ? 0 : kHalfPi / 2;
  } else if (up <= along) {
    angle_rad = atan_to_one(up / along);
  } else {
    angle_rad = (kHalfPi - atan_to_one(along / up)) + kHalfPiRest;
  }
  if (std::signbit(x)) angle_rad = (2 * kHalfPi - angle_rad) + 2 * kHalfPiRest;
  return std::copysign(angle_rad, y);
}

double atan(double x) noexcept { return atan2(x, 1); }

double asin(double x) noexcept {
  if (!(std::abs(x) <= 1)) return kNaN;
  return atan2(x, std::sqrt((1 - x) * (1 + x)));
}

double acos(double x) noexcept {
  if (!(std::abs(x) <= 1)) return kNaN;
  return atan2(std::sqrt((1 - x) * (1 + x)), x);
}

double exp(double x) noexcept {
  if (std::isnan(x)) return kNaN;
  if (x > 709.79) return kInfinity;
  if (x < -745.2) return 0;
  const double halvings = std::round(x * std::numbers::log2e);
  const double exact = x - halvings * kLn2_1, second = halvings * kLn2_2;
  const double r = exact - second, lost = (exact - r) - second;
  double series = 0;  // Taylor's, to r^13: the next term is below 1e-17
  for (int n = 13; n >= 2; --n) series = (1 + series * r) / n;
  return std::ldexp(1 + (r + (lost + r * (r * series))), static_cast<int>(halvings));
}

double hypot(double x, double y) noexcept {
  const double a = std::abs(x), b = std::abs(y);
  if (std::isinf(a) || std::isinf(b)) return kInfinity;
  if (std::isnan(a) || std::isnan(b)) return kNaN;
  const double longer = a > b ? a : b, shorter = a > b ? b : a;
  if (longer == 0) return 0;
  const double ratio = shorter / longer;
  return longer * std::sqrt(1 + ratio * ratio);
}

}  // namespace lss::gnc::math
