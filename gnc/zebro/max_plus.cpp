#include "gnc/zebro/max_plus.h"

#include <algorithm>
#include <cstddef>

namespace lss::gnc::zebro::max_plus {

namespace {
constexpr std::size_t kN = kSize;
}

Matrix null() noexcept {
  Matrix a;
  for (Vector& row : a) row.fill(kEps);
  return a;
}

Matrix identity() noexcept {
  Matrix a = null();
  for (std::size_t i = 0; i < kN; ++i) a[i][i] = 0;
  return a;
}

Matrix add(const Matrix& a, const Matrix& b) noexcept {
  Matrix sum = a;
  for (std::size_t i = 0; i < kN; ++i) {
    for (std::size_t j = 0; j < kN; ++j) sum[i][j] = std::max(a[i][j], b[i][j]);
  }
  return sum;
}

Matrix multiply(const Matrix& a, const Matrix& b) noexcept {
  Matrix product = null();
  for (std::size_t i = 0; i < kN; ++i) {
    for (std::size_t k = 0; k < kN; ++k) {
      for (std::size_t j = 0; j < kN; ++j) {
        product[i][j] = std::max(product[i][j], a[i][k] + b[k][j]);
      }
    }
  }
  return product;
}

Vector multiply(const Matrix& a, const Vector& x) noexcept {
  Vector product;
  for (std::size_t i = 0; i < kN; ++i) {
    product[i] = kEps;
    for (std::size_t k = 0; k < kN; ++k) product[i] = std::max(product[i], a[i][k] + x[k]);
  }
  return product;
}

int nilpotency_index(const Matrix& a) noexcept {
  // A path without a circuit visits each node once, so A^N = eps or never.
  const Matrix zero = null();
  Matrix power = a;
  for (int p = 1; p <= kSize; ++p) {
    if (power == zero) return p;
    power = multiply(power, a);
  }
  return 0;
}

std::optional<Matrix> star(const Matrix& a) noexcept {
  const int index = nilpotency_index(a);
  if (index == 0) return std::nullopt;
  // (E (+) A)^(p-1) includes all powers below p, since (+) is idempotent.
  const Matrix step = add(identity(), a);
  Matrix sum = identity();
  for (int p = 1; p < index; ++p) sum = multiply(sum, step);
  return sum;
}

double cycle_mean(const Matrix& a) noexcept {
  // heaviest[k][v]: weight of the heaviest walk of k steps that ends in v, from anywhere.
  std::array<Vector, kN + 1> heaviest;
  heaviest[0].fill(0);
  for (std::size_t k = 1; k <= kN; ++k) heaviest[k] = multiply(a, heaviest[k - 1]);
  double mean = kEps;
  for (std::size_t v = 0; v < kN; ++v) {
    if (heaviest[kN][v] == kEps) continue;
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t k = 0; k < kN; ++k) {
      if (heaviest[k][v] == kEps) continue;
      least = std::min(least, (heaviest[kN][v] - heaviest[k][v]) / static_cast<double>(kN - k));
    }
    mean = std::max(mean, least);
  }
  return mean;
}

}  // namespace lss::gnc::zebro::max_plus
