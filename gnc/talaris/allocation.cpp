#include "gnc/talaris/allocation.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "gnc/talaris/pwm.h"

namespace lss::gnc::talaris {
namespace {

// Of the gradient, relative to its terms: rounding.
constexpr double kOptimal = 1e-9;

enum class At : std::int8_t { least = -1, between = 0, most = 1, fixed = 2 };

// Lift valves and fans make lift, pitch and yaw, side valves push and roll: two problems that have
// nothing in common.
constexpr std::array<int, 8> kLifts = {0, 2, 4, 6, 8, 9, 10, 11};
constexpr std::array<int, 3> kLiftRows = {kLiftRow, kPitchRow, kYawRow};
constexpr std::array<int, 4> kSides = {1, 3, 5, 7};
constexpr std::array<int, 2> kSideRows = {kSideRow, kRollRow};

// Half the cost is |a u - b|^2 / 2 + sum of c (u - preferred)^2 / 2, with rows times the roots of
// their weights. Over the free actuators, those between their limits, its minimum is at
// u = preferred + a^T y / c with (1 + a a^T / c of the free) y = b - a (preferred of the free, u of
// the others): as many unknowns as rows, however many are free (Woodbury).
template <std::size_t kN, std::size_t kK>
class Part {
 public:
  Part(const AllocationProblem& p, const std::array<int, kN>& actuators,
       const std::array<int, kK>& rows) noexcept {
    double root[kK];
    for (std::size_t k = 0; k < kK; ++k) {
      root[k] = std::sqrt(p.weight[rows[k]]);
      b_[k] = root[k] * p.wanted[rows[k]];
    }
    for (std::size_t i = 0; i < kN; ++i) {
      const int actuator = actuators[i];
      for (std::size_t k = 0; k < kK; ++k) a_[i][k] = root[k] * p.effect(rows[k], actuator);
      cost_[i] = p.cost[actuator];
      slack_[i] = 1 / cost_[i];
      preferred_[i] = p.preferred[actuator];
      least_[i] = p.least[actuator];
      most_[i] = p.most[actuator];
      u[i] = std::clamp(preferred_[i], least_[i], most_[i]);
      at_[i] = least_[i] >= most_[i] ? At::fixed : At::between;
    }
  }

  void minimise() noexcept {
    hold_all_that_exceed();
    while (true) {
      const std::size_t release = costs_most();
      optimal = release == kN;
      if (optimal || iterations >= kMost) return;
      at_[release] = At::between;
      while (iterations < kMost && blocked()) {
      }
    }
  }

  std::array<double, kN> u;
  int iterations = 0;
  bool optimal = false;

 private:
  static constexpr int kMost = kMostIterations / 2;

  // At the minimum over the free ones, for all: the pull of the rows on each, and where it wants
  // to.
  void solve() noexcept {
    ++iterations;
    double m[kK][kK] = {}, y[kK];
    for (std::size_t k = 0; k < kK; ++k) {
      m[k][k] = 1;
      y[k] = b_[k];
    }
    for (std::size_t i = 0; i < kN; ++i) {
      const bool moves = at_[i] == At::between;
      const double force = moves ? preferred_[i] : u[i];
#pragma GCC unroll 3
      for (std::size_t k = 0; k < kK; ++k) y[k] -= a_[i][k] * force;
      if (!moves) continue;
#pragma GCC unroll 3
      for (std::size_t k = 0; k < kK; ++k) {
        const double each = a_[i][k] * slack_[i];
#pragma GCC unroll 3
        for (std::size_t c = 0; c <= k; ++c) m[k][c] += each * a_[i][c];
      }
    }
    // Cholesky's factorisation, in place; its diagonal inverse.
#pragma GCC unroll 3
    for (std::size_t r = 0; r < kK; ++r) {
#pragma GCC unroll 3
      for (std::size_t c = 0; c <= r; ++c) {
        double value = m[r][c];
#pragma GCC unroll 3
        for (std::size_t k = 0; k < c; ++k) value -= m[r][k] * m[c][k];
        m[r][c] = c == r ? 1 / std::sqrt(value) : value * m[c][c];
      }
#pragma GCC unroll 3
      for (std::size_t k = 0; k < r; ++k) y[r] -= m[r][k] * y[k];
      y[r] *= m[r][r];
    }
#pragma GCC unroll 3
    for (std::size_t n = 1; n <= kK; ++n) {
      const std::size_t r = kK - n;
#pragma GCC unroll 3
      for (std::size_t k = r + 1; k < kK; ++k) y[r] -= m[k][r] * y[k];
      y[r] *= m[r][r];
    }
    for (std::size_t i = 0; i < kN; ++i) {
      double pull = 0;
#pragma GCC unroll 3
      for (std::size_t k = 0; k < kK; ++k) pull += a_[i][k] * y[k];
      pull_[i] = pull;
      wanted_[i] = preferred_[i] + pull * slack_[i];
    }
  }

  bool exceeds(std::size_t i) const noexcept {
    return at_[i] == At::between && (wanted_[i] < least_[i] || wanted_[i] > most_[i]);
  }
  void hold(std::size_t i, bool most) noexcept {
    u[i] = most ? most_[i] : least_[i];
    at_[i] = most ? At::most : At::least;
  }

  // To begin with, all at once; each once at most.
  void hold_all_that_exceed() noexcept {
    for (bool more = true; more;) {
      solve();
      more = false;
      for (std::size_t i = 0; i < kN; ++i) {
        if (!exceeds(i)) continue;
        hold(i, wanted_[i] > most_[i]);
        more = true;
      }
    }
    for (std::size_t i = 0; i < kN; ++i) {
      if (at_[i] == At::between) u[i] = wanted_[i];
    }
  }

  // To the minimum over the free ones, or as far as the first limit on the way: then true.
  bool blocked() noexcept {
    solve();
    double share = 1;
    std::size_t first = kN;
    for (std::size_t i = 0; i < kN; ++i) {
      if (!exceeds(i)) continue;
      const double limit = wanted_[i] > most_[i] ? most_[i] : least_[i];
      const double room = std::max((limit - u[i]) / (wanted_[i] - u[i]), 0.0);
      if (first == kN || room < share) {
        share = room;
        first = i;
      }
    }
    for (std::size_t i = 0; i < kN; ++i) {
      if (at_[i] == At::between)
        u[i] = first == kN ? wanted_[i] : u[i] + share * (wanted_[i] - u[i]);
    }
    if (first == kN) return false;
    hold(first, wanted_[first] > most_[first]);
    return true;
  }

  // With all free ones at their minimum: the one at a limit without which the cost falls most. kN:
  // there is none, but for rounding.
  std::size_t costs_most() const noexcept {
    double size[kK], most = 0;  // of the terms of each row
    std::size_t worst = kN;
    bool sized = false;
    for (std::size_t i = 0; i < kN; ++i) {
      if (at_[i] != At::least && at_[i] != At::most) continue;
      const double gradient = cost_[i] * (u[i] - preferred_[i]) - pull_[i];
      const double falls = at_[i] == At::least ? -gradient : gradient;
      if (!(falls > 0)) continue;
      if (!std::exchange(sized, true)) {
        for (std::size_t k = 0; k < kK; ++k) {
          size[k] = std::abs(b_[k]);
          for (std::size_t j = 0; j < kN; ++j) size[k] += std::abs(a_[j][k] * u[j]);
        }
      }
      double terms = cost_[i] * (std::abs(u[i]) + std::abs(preferred_[i])), bend = cost_[i];
      for (std::size_t k = 0; k < kK; ++k) {
        terms += std::abs(a_[i][k]) * size[k];
        bend += a_[i][k] * a_[i][k];
      }
      if (falls > kOptimal * terms && falls * falls > most * bend) {
        most = falls * falls / bend;
        worst = i;
      }
    }
    return worst;
  }

  double a_[kN][kK], b_[kK];
  double cost_[kN], slack_[kN], preferred_[kN], least_[kN], most_[kN], pull_[kN], wanted_[kN];
  At at_[kN];
};

template <std::size_t kN, std::size_t kK>
void allocate_part(const AllocationProblem& p, const std::array<int, kN>& actuators,
                   const std::array<int, kK>& rows, Allocation& out) noexcept {
  Part part(p, actuators, rows);
  part.minimise();
  out.iterations += part.iterations;
  out.optimal = out.optimal && part.optimal;
  for (std::size_t i = 0; i < kN; ++i) {
    const int actuator = actuators[i];
    out.force_N[actuator] = std::clamp(part.u[i], p.least[actuator], p.most[actuator]);
  }
}

}  // namespace

Allocation allocate(const AllocationProblem& p) noexcept {
  Allocation out;
  out.optimal = true;
  allocate_part(p, kLifts, kLiftRows, out);
  allocate_part(p, kSides, kSideRows, out);
  return out;
}

Effect effect_of(const Thrusters& t, const Fans& fans) noexcept {
  Effect effect = Effect::Zero();
  for (std::size_t i = 0; i < 4; ++i) {
    const auto lift = static_cast<Eigen::Index>(2 * i), side = lift + 1;
    const auto fan = static_cast<Eigen::Index>(kValves + i);
    effect(kLiftRow, lift) = 1;
    effect(kPitchRow, lift) = kLiftZ[i] * t.lift_z_m;
    effect(kYawRow, lift) = -kLiftY[i] * t.lift_y_m;
    effect(kSideRow, side) = kSidePush[i];
    effect(kRollRow, side) = kSideY[i] * kSidePush[i] * t.side_y_m;
    effect(kLiftRow, fan) = 1;
    effect(kPitchRow, fan) = kLiftZ[i] * fans.z_m;
    effect(kYawRow, fan) = -kLiftY[i] * fans.y_m;
  }
  return effect;
}

bool all_good(const Healths& health) noexcept {
  return std::ranges::all_of(health, [](Health each) { return each == Health::good; });
}

}  // namespace lss::gnc::talaris
