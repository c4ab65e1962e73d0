#include "gnc/talaris/allocation.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <cstdio>
#include <limits>
#include <random>

#include "gnc/talaris/pwm.h"
#include "tests/support/allocations.h"
#include "tests/talaris/gnc/hover_budget.h"

namespace lss::gnc::talaris {
namespace {

using Hessian = Eigen::Matrix<double, kActuators, kActuators>;

double cost(const AllocationProblem& p, const Forces& u) {
  const WrenchB error = p.effect * u - p.wanted;
  const Forces off = u - p.preferred;
  return p.weight.dot(error.cwiseAbs2()) + p.cost.dot(off.cwiseAbs2());
}

Forces gradient(const AllocationProblem& p, const Forces& u) {
  const WrenchB error = p.effect * u - p.wanted;
  return 2 * (p.effect.transpose() * p.weight.cwiseProduct(error).eval() +
              p.cost.cwiseProduct(u - p.preferred));
}

// The vehicle's own actuators with any demand and any limits; `fixed`: so many cannot move.
AllocationProblem any_problem(std::mt19937& random, int fixed = 0) {
  const auto any = [&](double from, double to) {
    return std::uniform_real_distribution<double>(from, to)(random);
  };
  AllocationProblem p;
  p.effect = effect_of(Thrusters{}, Fans{});
  p.wanted << any(-100, 900), any(-150, 150), any(-40, 40), any(-80, 80), any(-80, 80);
  for (int i = 0; i < kWrench; ++i) p.weight[i] = std::pow(10.0, any(-3, 0));
  for (int i = 0; i < kActuators; ++i) {
    p.least[i] = any(0, 40);
    p.most[i] = p.least[i] + (i < fixed ? 0 : any(0, 90));
    p.preferred[i] = any(-20, 140);
    p.cost[i] = std::pow(10.0, any(-4, -2));
  }
  return p;
}

void expect_within(const AllocationProblem& p, const Allocation& a) {
  RC_ASSERT(a.iterations <= kMostIterations);
  for (int i = 0; i < kActuators; ++i) {
    RC_ASSERT(a.force_N[i] >= p.least[i]);
    RC_ASSERT(a.force_N[i] <= p.most[i]);
  }
}

RC_GTEST_PROP(TalarisAllocation, TheLimitsAreRespectedAndTheResultIsTheMinimum, (unsigned seed)) {
  std::mt19937 random(seed);
  const AllocationProblem p = any_problem(random);
  const Allocation a = allocate(p);
  expect_within(p, a);
  RC_ASSERT(a.optimal);
  // Karush, Kuhn and Tucker: no actuator could move within its limits and lower the cost
  const Forces slope = gradient(p, a.force_N);
  for (int i = 0; i < kActuators; ++i) {
    const double most = 1e-6 * (1 + p.cost[i] * 200);
    if (a.force_N[i] > p.least[i]) RC_ASSERT(slope[i] <= most);
    if (a.force_N[i] < p.most[i]) RC_ASSERT(slope[i] >= -most);
  }
}

// By another way: one actuator after the other, until nothing changes.
RC_GTEST_PROP(TalarisAllocation, CoordinateDescentFindsNothingBetter, (unsigned seed)) {
  std::mt19937 random(seed);
  const AllocationProblem p = any_problem(random);
  Forces u = p.least;
  for (int sweep = 0; sweep < 3000; ++sweep) {
    for (int i = 0; i < kActuators; ++i) {
      const double bend = 2 * (p.effect.col(i).cwiseAbs2().dot(p.weight) + p.cost[i]);
      u[i] = std::clamp(u[i] - gradient(p, u)[i] / bend, p.least[i], p.most[i]);
    }
  }
  RC_ASSERT(cost(p, allocate(p).force_N) <= cost(p, u) * (1 + 1e-9) + 1e-9);
}

// Every combination of limits, for six actuators that can move.
RC_GTEST_PROP(TalarisAllocation, NoCombinationOfLimitsIsBetter, (unsigned seed)) {
  constexpr int kFixed = 6;
  std::mt19937 random(seed);
  const AllocationProblem p = any_problem(random, kFixed);
  const Allocation a = allocate(p);
  expect_within(p, a);
  Hessian hessian = p.effect.transpose() * p.weight.asDiagonal() * p.effect;
  hessian.diagonal() += p.cost;
  const Forces linear = -(p.effect.transpose() * p.weight.cwiseProduct(p.wanted).eval()) -
                        p.cost.cwiseProduct(p.preferred);
  double least = 1e300;
  for (int n = 0; n < 729; ++n) {
    Hessian h = hessian;
    Forces right = -linear, u = p.least;
    int rest = n;
    for (int i = 0; i < kActuators; ++i) {
      int at = 1;
      if (i >= kFixed) {
        at = rest % 3;
        rest /= 3;
      }
      if (at == 0) continue;
      u[i] = at == 1 ? p.least[i] : p.most[i];
    }
    rest = n;
    // what is at a limit goes to the right side
    for (int i = 0; i < kActuators; ++i) {
      const bool free = i >= kFixed && (rest % 3) == 0;
      if (i >= kFixed) rest /= 3;
      if (free) continue;
      right -= hessian.col(i) * u[i];
      h.row(i).setZero();
      h.col(i).setZero();
      h(i, i) = 1;
    }
    rest = n;
    for (int i = 0; i < kActuators; ++i) {
      const bool free = i >= kFixed && (rest % 3) == 0;
      if (i >= kFixed) rest /= 3;
      if (!free) right[i] = u[i];
    }
    const Forces solved = h.ldlt().solve(Eigen::Matrix<double, kActuators, 1>(right));
    if (((solved - p.least).array() < -1e-9).any() || ((solved - p.most).array() > 1e-9).any())
      continue;
    least = std::min(least, cost(p, solved));
  }
  RC_ASSERT(std::abs(cost(p, a.force_N) - least) <= 1e-7 * (1 + least));
}

RC_GTEST_PROP(TalarisAllocation, TheSameProblemGivesTheSameBits, (unsigned seed)) {
  std::mt19937 random(seed);
  const AllocationProblem p = any_problem(random);
  const std::uint64_t before = testing_support::allocations();
  const Allocation a = allocate(p), b = allocate(p);
  const std::uint64_t after = testing_support::allocations();
  RC_ASSERT(after == before);
  RC_ASSERT(a.force_N == b.force_N);
  RC_ASSERT(a.iterations == b.iterations);
}

// An unreachable demand: attitude first, lift next.
TEST(TalarisAllocation, TheHeavierWeightIsServedFirst) {
  AllocationProblem p;
  p.effect = effect_of(Thrusters{}, Fans{});
  p.most << 58, 58, 58, 58, 58, 58, 58, 58, 116, 116, 116, 116;
  p.cost.setConstant(1e-4);
  p.wanted << 690, 0, 0, 30, 0;
  p.weight << 0.02, 0.002, 0.2, 1, 1;
  const Allocation a = allocate(p);
  ASSERT_TRUE(a.optimal);
  const WrenchB got = p.effect * a.force_N;
  EXPECT_NEAR(got[kPitchRow], 30, 3);
  EXPECT_LT(got[kLiftRow], 680);
  EXPECT_GT(got[kLiftRow], 560);
}

Healths failed(std::size_t actuator, Health health) {
  Healths all{};
  all[actuator] = health;
  return all;
}

// docs/gnc-talaris.md has this table.
TEST(TalarisAllocation, HoverBudgetOfEachSingleFailure) {
  const Parameters parameters;
  constexpr double kGas_s = 20;  // left in the middle of a hop
  const auto show = [&](const char* name, const Healths& health) {
    const HoverBudget b = hover_budget(parameters, health, parameters.body.mass_kg, kGas_s);
    std::printf("| %s | %.0f of %.0f | %.0f, %.0f | %.2f | %.1f | %s |\n", name, b.lift_N,
                b.weight_N, b.moment_left_Nm[0], b.moment_left_Nm[1], b.gas_s_per_s, b.gas_time_s,
                b.hovers ? "yes" : "no");
    return b;
  };
  EXPECT_TRUE(show("none", {}).hovers);
  for (std::size_t i = 0; i < 8; ++i) {
    const bool lift = i % 2 == 0;
    const HoverBudget open =
        show(lift ? "lift valve open" : "side valve open", failed(i, Health::open));
    EXPECT_TRUE(open.hovers);
    EXPECT_GE(open.gas_s_per_s, 1);
    const HoverBudget shut =
        show(lift ? "lift valve shut" : "side valve shut", failed(i, Health::shut));
    EXPECT_TRUE(shut.hovers);
  }
  for (std::size_t i = 8; i < 12; ++i) {
    const HoverBudget dead = show("fan dead", failed(i, Health::dead));
    EXPECT_NEAR(dead.lift_N, 464, 1);  // two fans and four valves
    EXPECT_TRUE(dead.hovers);
  }
}

// Speed down at the ground after the loss of a fan at 2 m: its thrust is gone at once, or (`dead`)
// fades with its speed. In the plane of the tilt; nothing answers for `late_s`, then all that is
// left does so, in the best of several ways, without frames and pulses. Infinite: it turns over.
double lands_m_s(double late_s, bool dead) {
  constexpr double kStep_s = 0.001, kOver_rad = 2, kStands_rad = 0.35;
  const Parameters p;
  const double full_N = fan_thrust_N(p.fans.max_rpm, p.fans), force_N = p.thrusters.force_N;
  const double weight_N = p.body.mass_kg * kGravity_m_s2;
  // rad/s2 of each newton at the corner
  const double fan =
      std::hypot(p.fans.z_m / p.body.inertia_y_kg_m2, p.fans.y_m / p.body.inertia_z_kg_m2);
  const double valve = std::hypot(p.thrusters.lift_z_m / p.body.inertia_y_kg_m2,
                                  p.thrusters.lift_y_m / p.body.inertia_z_kg_m2);
  const double pulses_N = (1 - p.fans.weight_share) * weight_N / 4;
  const auto follow = [&](double& speed, double goal) {
    speed += (goal - speed) * kStep_s / p.fans.lag_s;
  };
  const auto lands = [&](double wn_rad_s, double zeta) {
    double until_s = late_s;
    double lost = std::sqrt(p.fans.weight_share * weight_N / 4 / full_N);  // speeds, of the highest
    double opposite = lost, others = lost;
    double tilt = 0, rate = 0, height_m = 2, climb_m_s = 0;
    while (height_m > 0 && std::abs(tilt) < kOver_rad) {
      follow(lost, 0);
      const double lost_N = dead ? full_N * lost * lost : 0,
                   opposite_N = full_N * opposite * opposite;
      double here_N = pulses_N, there_N = pulses_N, others_N = 2 * full_N * others * others;
      if (until_s > 0) {
        until_s -= kStep_s;
        others_N += 2 * pulses_N;
      } else {
        const double wanted = -wn_rad_s * (wn_rad_s * tilt + 2 * zeta * rate);
        const double goal_N = (valve * force_N + wanted + fan * lost_N) / fan;
        follow(opposite, goal_N > opposite_N ? 1 : 0);
        follow(others, 1);
        const double rest = (fan * (opposite_N - lost_N) - wanted) / valve;
        here_N = std::clamp(rest, 0.0, force_N);
        there_N = std::clamp(-rest, 0.0, force_N);
        const double down_m_s = -std::min(0.25 + 0.4 * height_m, 1.0);
        const double up_N = (weight_N + 4 * p.body.mass_kg * (down_m_s - climb_m_s)) /
                            std::max(std::cos(tilt), 0.2);
        others_N =
            std::clamp(up_N - lost_N - opposite_N - here_N - there_N, 0.0, others_N + 2 * force_N);
      }
      rate += kStep_s * (fan * (opposite_N - lost_N) + valve * (there_N - here_N));
      tilt += kStep_s * rate;
      const double lift_N = lost_N + opposite_N + others_N + here_N + there_N;
      climb_m_s += kStep_s * (lift_N * std::cos(tilt) - weight_N) / p.body.mass_kg;
      height_m += kStep_s * climb_m_s;
    }
    return std::abs(tilt) < kStands_rad ? -climb_m_s : std::numeric_limits<double>::infinity();
  };
  double best = std::numeric_limits<double>::infinity();
  for (const double wn_rad_s : {3.0, 4.0, 5.0, 7.0, 10.0}) {
    for (const double zeta : {0.6, 0.8, 1.0}) best = std::min(best, lands(wn_rad_s, zeta));
  }
  return best;
}

// Why fans are lost that leave enough lift: a frame takes 0.2 s (docs/gnc-talaris.md).
TEST(TalarisAllocation, ALostFanLeavesLittleTimeToAnswer) {
  for (const bool dead : {false, true}) {
    for (const double late_s : {0.05, 0.10, 0.12, 0.15, 0.20, 0.25, 0.30})
      std::printf("%s, answered after %.2f s: %.2f m/s\n", dead ? "dead" : "without thrust", late_s,
                  lands_m_s(late_s, dead));
  }
  EXPECT_LT(lands_m_s(0.10, false), 2);
  EXPECT_GT(lands_m_s(0.15, false), 2);
  EXPECT_LT(lands_m_s(0.20, true), 2);
  EXPECT_GT(lands_m_s(0.25, true), 2);
}

Pulse from_ms(double delay, double on) { return {on * 1e-3, delay * 1e-3}; }

// Just below and just above the shortest pause, between any two frames.
TEST(TalarisAllocation, PulsesOfTwoFramesKeepTheShortestPause) {
  constexpr double kPause_s = 0.040;
  const auto shut_s = [](const Pulse& before, const Pulse& next) {
    return kFrame_s - before.delay_s - before.on_s + next.delay_s;
  };
  for (double delay = 0; delay <= 160; delay += 1) {
    for (double on = 40; delay + on <= 200; on += 1) {
      const Pulse before = from_ms(delay, on);
      for (double next_on = 40; next_on <= 200; next_on += 4) {
        const Pulse next = spaced(next_on * 1e-3, before, kPause_s);
        const double shut = shut_s(before, next);
        ASSERT_TRUE(std::abs(shut) < 1e-6 || shut >= kPause_s - 1e-9)
            << delay << ' ' << on << ' ' << next_on << ": " << shut;
        ASSERT_LE(next.delay_s + next.on_s, kFrame_s + 1e-12);
        ASSERT_GE(next.on_s, kPause_s - 1e-9);
      }
    }
  }
  EXPECT_EQ(spaced(0.160, from_ms(20, 160), kPause_s).delay_s, centred(0.160).delay_s);
  EXPECT_NEAR(spaced(0.162, from_ms(20, 160), kPause_s).delay_s, 0.020, 1e-9);
  EXPECT_EQ(spaced(0, from_ms(0, 200), kPause_s).on_s, 0);
}

}  // namespace
}  // namespace lss::gnc::talaris
