#pragma once

// Control allocation: forces of all twelve actuators for a wanted wrench, within their limits. A
// quadratic program with bounds, solved by an active set (Härkegård, "Efficient active set
// algorithms for solving constrained least squares problems in aircraft control allocation", CDC
// 2002) in at most kMostIterations steps, each with five unknowns. No memory from the heap; the
// same inputs give the same bits. docs/gnc-talaris.md, "Allocation".

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>

#include "gnc/talaris/fans.h"
#include "gnc/talaris/parameters.h"

namespace lss::gnc::talaris {

inline constexpr int kActuators = 12;  // valves 1..8, then fans 1..4
inline constexpr int kWrench = 5;      // rows: force along x, z (N), moments about x, y, z (N m)
enum WrenchRow : int { kLiftRow, kSideRow, kRollRow, kPitchRow, kYawRow };

using Forces = Eigen::Matrix<double, kActuators, 1, Eigen::DontAlign>;  // N, along each
using WrenchB = Eigen::Matrix<double, kWrench, 1, Eigen::DontAlign>;
using Effect = Eigen::Matrix<double, kWrench, kActuators, Eigen::DontAlign>;

// Minimises  sum_rows weight (effect u - wanted)^2 + sum_actuators cost (u - preferred)^2  over
// least <= u <= most. All numbers finite, cost > 0, least <= most; other members of `effect` than
// those of effect_of() do not count.
struct AllocationProblem {
  Effect effect = Effect::Zero();
  WrenchB wanted = WrenchB::Zero(), weight = WrenchB::Ones();
  Forces preferred = Forces::Zero(), cost = Forces::Ones();
  Forces least = Forces::Zero(), most = Forces::Zero();
};

struct Allocation {
  Forces force_N = Forces::Zero();  // within the limits in any case
  int iterations = 0;
  bool optimal = false;  // else the best that was found
};

inline constexpr int kMostIterations = 40;
Allocation allocate(const AllocationProblem& problem) noexcept;

// What one newton of each actuator does.
Effect effect_of(const Thrusters& thrusters, const Fans& fans) noexcept;

// State of an actuator as failure detection knows it.
enum class Health : std::uint8_t {
  good,
  open,  // a valve stuck open: its whole thrust, always
  shut,  // a valve stuck shut
  dead,  // a fan that does not turn
  weak,  // a fan that turns without thrust
};
using Healths = std::array<Health, kActuators>;
bool all_good(const Healths& health) noexcept;

}  // namespace lss::gnc::talaris
