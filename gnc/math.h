#pragma once

// Functions of <cmath> whose last bit depends on the machine, written with + - * / sqrt, round and
// remainder alone, which IEEE 754 defines to the bit: a recording replays equal on every processor
// and with every libc (docs/recording.md). Angles in radians. Errors: below 2 units in the last
// place, of tan, asin, acos and atan2 below 3 (tests/core/math_test.cpp). Arguments without a
// result give the positive quiet NaN. Nothing sets errno. Any thread.
//
// Code of the cycle uses them instead of those of std; check_sources.sh finds the others.

namespace lss::gnc::math {

// Beyond 1.6e6 rad the angle is taken modulo the double next to 2 pi.
double sin(double x_rad) noexcept;
double cos(double x_rad) noexcept;
double tan(double x_rad) noexcept;

double asin(double x) noexcept;
double acos(double x) noexcept;
double atan(double x) noexcept;
double atan2(double y, double x) noexcept;  // signed zeros and infinities as ISO C, F.10.1.4

double exp(double x) noexcept;
double hypot(double x, double y) noexcept;  // inf beyond the largest double only

}  // namespace lss::gnc::math
