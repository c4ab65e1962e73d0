#pragma once

// What is left to hover with when actuators have failed: lift, moments and gas.

#include <algorithm>
#include <limits>

#include "gnc/talaris/allocation.h"

namespace lss::gnc::talaris {

// Hover with these actuators, at rest: is there an equilibrium, and what does it cost?
struct HoverBudget {
  double lift_N = 0;              // most lift without any moment or force sideways
  double weight_N = 0;            // what it has to carry
  double gas_s_per_s = 0;         // thruster-seconds a second in the equilibrium, or at most lift
  double gas_time_s = 0;          // so long `gas_s` lasts
  double moment_left_Nm[2] = {};  // pitch, yaw: what is left to correct with, the smaller side
  bool hovers = false;
  Forces force_N = Forces::Zero();
};
inline HoverBudget hover_budget(const Parameters& parameters, const Healths& health, double mass_kg,
                                double gas_s) noexcept {
  constexpr double kHeavy = 1e3, kCost = 1e-6, kMoreThanAny = 1000;
  const double full_N = parameters.thrusters.force_N;
  const double fan_N = fan_thrust_N(parameters.fans.max_rpm, parameters.fans);
  AllocationProblem p;
  p.effect = effect_of(parameters.thrusters, parameters.fans);
  p.cost.setConstant(kCost);
  for (int i = 0; i < kActuators; ++i) {
    const Health is = health[static_cast<std::size_t>(i)];
    const double most = i < static_cast<int>(kValves) ? full_N : fan_N;
    p.most[i] = is == Health::good || is == Health::open ? most : 0;
    p.least[i] = is == Health::open ? most : 0;
    p.preferred[i] = i < static_cast<int>(kValves) ? 0 : p.most[i];
  }
  HoverBudget budget;
  budget.weight_N = mass_kg * kGravity_m_s2;
  // as much lift as there is without moments
  p.weight << 1, kHeavy, kHeavy, kHeavy, kHeavy;
  p.weight[kLiftRow] = 1e-3;
  p.wanted << kMoreThanAny, 0, 0, 0, 0;
  budget.lift_N = (p.effect * allocate(p).force_N)[kLiftRow];
  budget.hovers = budget.lift_N >= budget.weight_N;
  // the equilibrium, or what is nearest to it, with little gas
  p.weight.setConstant(kHeavy);
  p.wanted[kLiftRow] = std::min(budget.weight_N, budget.lift_N);
  for (int i = 0; i < static_cast<int>(kValves); ++i) p.cost[i] = 100 * kCost;
  budget.force_N = allocate(p).force_N;
  budget.gas_s_per_s = budget.force_N.head<static_cast<int>(kValves)>().sum() / full_N;
  budget.gas_time_s =
      budget.gas_s_per_s > 0 ? gas_s / budget.gas_s_per_s : std::numeric_limits<double>::infinity();
  // with the same lift: what is left to turn it one way and the other
  for (int axis = 0; axis < 2; ++axis) {
    const int row = kPitchRow + axis;
    double least = std::numeric_limits<double>::infinity();
    for (const double way : {-1.0, 1.0}) {
      AllocationProblem turn = p;
      turn.weight[row] = 1e-3;
      turn.wanted[row] = way * kMoreThanAny;
      least = std::min(least, way * (turn.effect * allocate(turn).force_N)[row]);
    }
    budget.moment_left_Nm[axis] = std::max(least, 0.0);
  }
  return budget;
}

}  // namespace lss::gnc::talaris
