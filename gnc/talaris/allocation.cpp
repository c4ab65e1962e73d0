#include "gnc/talaris/allocation.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "gnc/talaris/pwm.h"

namespace lss::gnc::talaris {
namespace {

using Hessian = Eigen::Matrix<double, kActuators, kActuators>;
using Vector = Eigen::Matrix<double, kActuators, 1>;

// Of the gradient, relative to its terms: rounding.
constexpr double kOptimal = 1e-9;

enum class At : std::int8_t { least = -1, between = 0, most = 1, fixed = 2 };
using Active = std::array<At, kActuators>;

// The step of the free ones to the minimum over them; 0 for all others. Cholesky's factorisation of
// the free rows and columns.
Vector newton_step(const Hessian& hessian, const Vector& gradient, const Active& active) noexcept {
  std::array<int, kActuators> moves{};
  int n = 0;
  for (int i = 0; i < kActuators; ++i) {
    if (active[static_cast<std::size_t>(i)] == At::between)
      moves[static_cast<std::size_t>(n++)] = i;
  }
  double l[kActuators][kActuators];
  double y[kActuators];
  for (int r = 0; r < n; ++r) {
    const int row = moves[static_cast<std::size_t>(r)];
    double sum = -gradient[row];
    for (int c = 0; c <= r; ++c) {
      double value = hessian(row, moves[static_cast<std::size_t>(c)]);
      for (int k = 0; k < c; ++k) value -= l[r][k] * l[c][k];
      l[r][c] = c == r ? std::sqrt(value) : value / l[c][c];
    }
    for (int k = 0; k < r; ++k) sum -= l[r][k] * y[k];
    y[r] = sum / l[r][r];
  }
  Vector step = Vector::Zero();
  for (int r = n - 1; r >= 0; --r) {
    double sum = y[r];
    for (int k = r + 1; k < n; ++k) sum -= l[k][r] * step[moves[static_cast<std::size_t>(k)]];
    step[moves[static_cast<std::size_t>(r)]] = sum / l[r][r];
  }
  return step;
}

}  // namespace

Allocation allocate(const AllocationProblem& p) noexcept {
  const Eigen::Matrix<double, kWrench, kActuators> effect = p.effect;
  const Eigen::Matrix<double, kActuators, kWrench> weighted =
      effect.transpose() * p.weight.asDiagonal();
  Hessian hessian = weighted * effect;
  hessian.diagonal() += p.cost;
  const Vector linear = -(weighted * p.wanted) - p.cost.cwiseProduct(p.preferred);

  Allocation out;
  Vector u = p.preferred;
  Active active{};
  for (int i = 0; i < kActuators; ++i) {
    u[i] = std::clamp(u[i], p.least[i], p.most[i]);
    At& at = active[static_cast<std::size_t>(i)];
    at = p.least[i] >= p.most[i] ? At::fixed
         : u[i] <= p.least[i]    ? At::least
         : u[i] >= p.most[i]     ? At::most
                                 : At::between;
  }
  while (out.iterations < kMostIterations) {
    ++out.iterations;
    Vector gradient = hessian * u + linear;
    const Vector step = newton_step(hessian, gradient, active);
    double share = 1;
    int blocks = -1;
    for (int i = 0; i < kActuators; ++i) {
      if (active[static_cast<std::size_t>(i)] != At::between || step[i] == 0) continue;
      const double room = (step[i] > 0 ? p.most[i] : p.least[i]) - u[i];
      if (room / step[i] < share) {
        share = std::max(room / step[i], 0.0);
        blocks = i;
      }
    }
    u += share * step;
    if (blocks >= 0) {
      const bool up = step[blocks] > 0;
      u[blocks] = up ? p.most[blocks] : p.least[blocks];
      active[static_cast<std::size_t>(blocks)] = up ? At::most : At::least;
      continue;
    }
    // The limit that costs most is given up.
    gradient = hessian * u + linear;
    const Vector terms = hessian.cwiseAbs() * u.cwiseAbs() + linear.cwiseAbs();
    double worst = 0;
    int release = -1;
    for (int i = 0; i < kActuators; ++i) {
      const At at = active[static_cast<std::size_t>(i)];
      if (at != At::least && at != At::most) continue;
      const double wants = at == At::least ? -gradient[i] : gradient[i];
      if (wants > kOptimal * terms[i] && wants / std::sqrt(hessian(i, i)) > worst) {
        worst = wants / std::sqrt(hessian(i, i));
        release = i;
      }
    }
    if (release < 0) {
      out.optimal = true;
      break;
    }
    active[static_cast<std::size_t>(release)] = At::between;
  }
  for (int i = 0; i < kActuators; ++i) out.force_N[i] = std::clamp(u[i], p.least[i], p.most[i]);
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
