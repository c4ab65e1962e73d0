// The filters against printed coefficients and against their specification.

#include "gnc/talaris/filters.h"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <limits>

namespace lss::gnc::talaris::test {
namespace {

constexpr double kPi = 3.14159265358979323846;

double gain(const FilterCoefficients& c, double hz, double fs) {
  const std::complex<double> z = std::polar(1.0, -2 * kPi * hz / fs);
  return std::abs((c.b0 + c.b1 * z + c.b2 * z * z) / (1.0 + c.a1 * z + c.a2 * z * z));
}

// Output amplitude for a sine of amplitude 1, once settled.
double measured_gain(const FilterCoefficients& c, double hz, double fs) {
  Filter filter(c);
  double largest = 0;
  const int count = static_cast<int>(fs * 20);
  for (int i = 0; i < count; ++i) {
    const double y = filter.step(std::sin(2 * kPi * hz * i / fs));
    if (i > count * 3 / 4) largest = std::max(largest, std::abs(y));
  }
  return largest;
}

// Pressures: 5 Hz, corner at 0.5 Hz.
TEST(Filters, ButterworthHasItsPrintedCoefficients) {
  const FilterCoefficients c = butterworth(0.5, 5);
  EXPECT_NEAR(c.b0, 0.0674553, 5e-8);
  EXPECT_NEAR(c.b1, 0.1349105, 5e-8);
  EXPECT_NEAR(c.b2, 0.0674553, 5e-8);
  EXPECT_NEAR(c.a1, -1.1429805, 5e-8);
  EXPECT_NEAR(c.a2, 0.4128016, 5e-8);
}

// Load cell: 500 Hz, notch at 7 Hz with Q = 2.
TEST(Filters, NotchHasItsPrintedCoefficients) {
  const FilterCoefficients c = notch(7, 500, 2);
  EXPECT_NEAR(c.b0, 0.9785092, 5e-8);
  EXPECT_NEAR(c.b1, -1.9494518, 5e-8);
  EXPECT_NEAR(c.b2, 0.9785092, 5e-8);
  EXPECT_NEAR(c.a1, -1.9494518, 5e-8);
  EXPECT_NEAR(c.a2, 0.9570184, 5e-8);
}

TEST(Filters, ButterworthPassesBelowAndDampsAboveItsCorner) {
  const FilterCoefficients c = butterworth(0.5, 5);
  EXPECT_NEAR(gain(c, 0, 5), 1, 1e-15);
  EXPECT_NEAR(gain(c, 0.5, 5), std::sqrt(0.5), 1e-12);
  EXPECT_NEAR(gain(c, 2.5, 5), 0, 1e-12);
  EXPECT_NEAR(measured_gain(c, 0.05, 5), 1, 0.002);
  EXPECT_LT(measured_gain(c, 1.5, 5), 0.06);
}

TEST(Filters, NotchTakesOutItsFrequencyOnly) {
  const FilterCoefficients c = notch(7, 500, 2);
  EXPECT_LT(gain(c, 7, 500), 1e-12);
  EXPECT_NEAR(gain(c, 5, 500), 0.81, 0.005);
  EXPECT_NEAR(gain(c, 9, 500), 0.71, 0.005);
  EXPECT_NEAR(gain(c, 0, 500), 1, 1e-12);
  EXPECT_LT(measured_gain(c, 7, 500), 1e-9);
  EXPECT_NEAR(measured_gain(c, 5, 500), 0.81, 0.01);
}

TEST(Filters, BeginSettledAtTheFirstSample) {
  Filter filter(butterworth(0.5, 5));
  EXPECT_EQ(filter.value(), 0);
  for (int i = 0; i < 50; ++i) EXPECT_NEAR(filter.step(31000), 31000, 1e-8);
  filter.reset();
  EXPECT_NEAR(filter.step(-5), -5, 1e-14);
}

// One reading that is no number must not stay in the filter for ever.
TEST(Filters, IgnoreWhatIsNoNumber) {
  Filter filter(butterworth(0.5, 5)), other = filter;
  for (int i = 0; i < 20; ++i) {
    const double x = std::sin(i);
    filter.step(x);
    EXPECT_EQ(filter.step(std::numeric_limits<double>::quiet_NaN()), filter.value());
    filter.step(std::numeric_limits<double>::infinity());
    EXPECT_EQ(other.step(x), filter.value());
  }
}

TEST(Filters, WhatCannotBeChangesNothing) {
  for (const FilterCoefficients& c :
       {butterworth(0, 5), butterworth(2.5, 5), butterworth(-1, 5), butterworth(NAN, 5),
        notch(7, 27, 2), notch(0, 500, 2), notch(7, 500, 0), notch(7, NAN, 2)}) {
    Filter filter(c);
    for (int i = 0; i < 10; ++i) EXPECT_EQ(filter.step(i * 0.3), i * 0.3);
  }
}

}  // namespace
}  // namespace lss::gnc::talaris::test
