#pragma once

// Max-plus linear algebra on the 12 events of a gait cycle: a (+) b = max(a, b), a (x) b = a + b,
// zero element eps = -infinity, unit 0. Eps is IEEE -infinity, whose sums and maxima are correct;
// there is no NaN as long as +infinity is never used. Fixed size, nothing allocates, pure
// functions; a product is 1728 additions. Baccelli, Cohen, Olsder, Quadrat: "Synchronization and
// Linearity" (1992), chapters 2 and 3.

#include <array>
#include <limits>
#include <optional>

#include "gnc/zebro/leg.h"

namespace lss::gnc::zebro::max_plus {

inline constexpr int kSize = 2 * kLegs;
inline constexpr double kEps = -std::numeric_limits<double>::infinity();

using Vector = std::array<double, kSize>;
using Matrix = std::array<Vector, kSize>;  // rows

Matrix null() noexcept;
Matrix identity() noexcept;
Matrix add(const Matrix& a, const Matrix& b) noexcept;
Matrix multiply(const Matrix& a, const Matrix& b) noexcept;
Vector multiply(const Matrix& a, const Vector& x) noexcept;

// Smallest p with A^p = eps, or 0: not nilpotent, the graph of A has a circuit.
int nilpotency_index(const Matrix& a) noexcept;

// A* = E (+) A (+) A^2 (+) ..., the least solution of X = A (x) X (+) E. Nothing when A is not
// nilpotent: then the events of one cycle wait for each other in a ring and no order of them
// exists.
std::optional<Matrix> star(const Matrix& a) noexcept;

// Largest mean weight of a circuit by Karp's algorithm; eps without a circuit. For an irreducible
// matrix the eigenvalue.
double cycle_mean(const Matrix& a) noexcept;

}  // namespace lss::gnc::zebro::max_plus
