#pragma once

// Ratio blocks: one PI controller for each wheel or steering motor, whose errors are limited so
// that all arrive at the same time (Ardito thesis 12.2, 12.3). Pure functions.

#include <array>
#include <cstddef>

#include "gnc/ardito/parameters.h"

namespace lss::gnc::ardito {

// The largest error is limited to `saturation`, the others in proportion; unchanged when all are
// smaller. Bit i of `skip`: this one is ignored.
template <std::size_t N>
std::array<double, N> equal_settling(const std::array<double, N>& errors, double saturation,
                                     std::uint32_t skip) noexcept {
  double largest = 0;
  for (std::size_t i = 0; i < N; ++i) {
    const double size = errors[i] < 0 ? -errors[i] : errors[i];
    if (!contains(skip, i) && size > largest) largest = size;
  }
  std::array<double, N> cut{};
  const double share = largest > saturation ? saturation / largest : 1;
  for (std::size_t i = 0; i < N; ++i) {
    if (!contains(skip, i)) cut[i] = errors[i] * share;
  }
  return cut;
}

// One step; the output stays within +-limit, and the integral with it.
double pi_step(double error, double limit, double& integral, const Parameters& parameters) noexcept;

}  // namespace lss::gnc::ardito
