#include "gnc/math.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <string>

namespace lss::gnc::math {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kPi = std::numbers::pi;

// From 0 to 1, the same on every machine (D. Knuth's MMIX generator).
class Draws {
 public:
  double operator()() noexcept {
    state_ = state_ * 6364136223846793005u + 1442695040888963407u;
    return static_cast<double>(state_ >> 11) * 0x1p-53;
  }

 private:
  std::uint64_t state_ = 1;
};

struct Function {
  const char* name;
  double (*ours)(double a, double b);
  long double (*exact)(long double a, long double b);  // of more bits than a double has
  double scale_a, scale_b;                             // arguments from -scale to scale
  double allowed_ulp;
  std::uint64_t bits;  // FNV-1a of the results
};

const std::array kFunctions = {
    Function{"sin", [](double a, double) { return sin(a); },
             [](long double a, long double) { return std::sin(a); }, 20, 0, 2, 0x3aeb3524ee5fcb57},
    Function{"cos", [](double a, double) { return cos(a); },
             [](long double a, long double) { return std::cos(a); }, 20, 0, 2, 0xff7c81685f930a27},
    Function{"sin of many turns", [](double a, double) { return sin(a); },
             [](long double a, long double) { return std::sin(a); }, 1.5e6, 0, 2,
             0x43ca55acbef13b68},
    Function{"tan", [](double a, double) { return tan(a); },
             [](long double a, long double) { return std::tan(a); }, 20, 0, 3, 0x7c09246cba16012b},
    Function{"asin", [](double a, double) { return asin(a); },
             [](long double a, long double) { return std::asin(a); }, 1, 0, 3, 0xc7827776020661c7},
    Function{"acos", [](double a, double) { return acos(a); },
             [](long double a, long double) { return std::acos(a); }, 1, 0, 3, 0x07276487c22b1f22},
    Function{"atan", [](double a, double) { return atan(a); },
             [](long double a, long double) { return std::atan(a); }, 8, 0, 3, 0xcfe87088781a458f},
    Function{"atan2", [](double a, double b) { return atan2(a, b); },
             [](long double a, long double b) { return std::atan2(a, b); }, 5, 3, 3,
             0x24f02c95c25b00f4},
    Function{"exp", [](double a, double) { return exp(a); },
             [](long double a, long double) { return std::exp(a); }, 700, 0, 2, 0xd832a18d889fddef},
    Function{"hypot", [](double a, double b) { return hypot(a, b); },
             [](long double a, long double b) { return std::hypot(a, b); }, 5, 3, 2,
             0x42b3c63b806cf353},
};

TEST(Math, results_have_these_bits_on_every_processor) {
  for (const Function& f : kFunctions) {
    Draws draw;
    std::uint64_t hash = 14695981039346656037u;
    for (int i = 0; i < 200000; ++i) {
      const double a = (2 * draw() - 1) * f.scale_a, b = (2 * draw() - 1) * f.scale_b;
      hash = (hash ^ std::bit_cast<std::uint64_t>(f.ours(a, b))) * 1099511628211u;
    }
    EXPECT_EQ(hash, f.bits) << f.name << std::hex << " 0x" << hash;
  }
}

TEST(Math, errors_are_below_those_that_the_header_states) {
  for (const Function& f : kFunctions) {
    Draws draw;
    double worst = 0;
    for (int i = 0; i < 200000; ++i) {
      const double a = (2 * draw() - 1) * f.scale_a, b = (2 * draw() - 1) * f.scale_b;
      const long double exact = f.exact(a, b);
      const double size = std::abs(static_cast<double>(exact));
      const double ulp = std::nextafter(size, kInfinity) - size;
      worst = std::max(worst, std::abs(static_cast<double>((f.ours(a, b) - exact) / ulp)));
    }
    EXPECT_LT(worst, f.allowed_ulp) << f.name;
    RecordProperty(f.name, std::to_string(worst));
  }
}

TEST(Math, limits_of_the_range) {
  EXPECT_EQ(sin(0.0), 0);
  EXPECT_TRUE(std::signbit(sin(-0.0)));
  EXPECT_EQ(cos(0), 1);
  EXPECT_EQ(sin(kPi / 2), 1);
  EXPECT_EQ(acos(1), 0);
  EXPECT_EQ(acos(-1), kPi);
  EXPECT_EQ(asin(1), kPi / 2);
  EXPECT_EQ(asin(-1), -kPi / 2);
  EXPECT_EQ(atan(1), kPi / 4);
  EXPECT_EQ(atan(kInfinity), kPi / 2);
  EXPECT_EQ(atan2(0, -1), kPi);
  EXPECT_EQ(atan2(-0.0, -1), -kPi);
  EXPECT_EQ(atan2(0.0, -0.0), kPi);
  EXPECT_TRUE(std::signbit(atan2(-0.0, 0)));
  EXPECT_EQ(atan2(-1, 0), -kPi / 2);
  EXPECT_EQ(atan2(kInfinity, -kInfinity), std::atan2(kInfinity, -kInfinity));
  EXPECT_EQ(exp(0), 1);
  EXPECT_EQ(exp(-kInfinity), 0);
  EXPECT_EQ(exp(kInfinity), kInfinity);
  EXPECT_EQ(exp(710), kInfinity);
  EXPECT_GT(exp(-745), 0);
  EXPECT_EQ(hypot(3, -4), 5);
  EXPECT_EQ(hypot(0, 0), 0);
  EXPECT_EQ(hypot(1e200, 1e200), std::sqrt(2.0) * 1e200);
  EXPECT_EQ(hypot(kNaN, kInfinity), kInfinity);
  EXPECT_NEAR(sin(1e9), std::sin(1e9), 1e-6);
}

TEST(Math, what_has_no_result_is_the_positive_nan) {
  for (const double none : {sin(kInfinity), cos(-kInfinity), tan(kNaN), asin(1.1), acos(-1.1),
                            atan(kNaN), atan2(kNaN, 1), exp(-kNaN), hypot(kNaN, 1)}) {
    EXPECT_EQ(std::bit_cast<std::uint64_t>(none), std::bit_cast<std::uint64_t>(kNaN));
  }
}

}  // namespace
}  // namespace lss::gnc::math
