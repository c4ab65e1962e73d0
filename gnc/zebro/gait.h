#pragma once

// Gaits as max-plus linear systems. A gait is an ordered partition of the legs into groups; each
// group lifts off double_stance after the one before it has landed, in a ring. Pure functions, no
// allocation, callable from every thread. Lopes, Kersbergen, De Schutter, van den Boom, Babuska:
// "Modeling and Control of Legged Locomotion via Switching Max-Plus Models" (T-RO 30(3), 2014), and
// "Synchronization of a class of cyclic discrete-event systems describing legged locomotion" (arXiv
// 1212.5525).
//
// In cycle k leg i lifts off at l_i(k) and touches down at t_i(k); a (+) b = max(a, b), a (x) b =
// a + b, eps = -infinity; l_1 < ... < l_m are the groups:
//
//   t_i(k) = tau_f + l_i(k)
//   l_i(k) = max( tau_g + t_i(k-1),  tau_Delta + t_j(k) for j in the group before,
//                 tau_Delta + t_j(k-1) for j in l_m, when i is in l_1 )
//
//   x(k) = [t l] = A0 (x) x(k) (+) A1 (x) x(k-1) = A (x) x(k-1),   A = A0* (x) A1
//
//   A0 = [ eps   tau_f (x) E ]     A1 = [ E                  eps ]
//        [ P     eps         ]          [ tau_g (x) E (+) Q  E   ]
//
// P has tau_Delta from each group to the next, Q from the last to the first; A0 is nilpotent (index
// 2m). With tau_d = tau_f + tau_Delta the rhythm is lambda = max(tau_f + tau_g, m tau_d), in which
// group j lifts off at (j - 1) tau_d; it is reached within two cycles from any start if tau_f +
// tau_g <= m tau_d.

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "gnc/zebro/leg.h"
#include "gnc/zebro/max_plus.h"

namespace lss::gnc::zebro {

template <typename T>
using PerLeg = std::array<T, kLegs>;

// Some of the legs, bit i = leg i.
using LegSet = std::uint8_t;
inline constexpr bool contains(LegSet legs, std::size_t leg) noexcept {
  return ((legs >> leg) & 1) != 0;
}

// A leg out of service has no group and no events: its times are eps and nothing waits for it.
inline constexpr std::uint8_t kNoGroup = 0xFF;

struct Partition {
  int groups = 0;                   // m
  PerLeg<std::uint8_t> group_of{};  // 0..m-1, in the order of lifting off, or kNoGroup
  bool operator==(const Partition&) const = default;
};

inline constexpr Partition kTripod{2, {0, 1, 1, 0, 0, 1}};     // {LF RM LH} {RF LM RH}
inline constexpr Partition kTetrapodB{3, {0, 1, 2, 0, 1, 2}};  // {LF RM} {RF LH} {LM RH}
inline constexpr Partition kWave{6, {2, 5, 1, 4, 0, 3}};       // LH LM LF RH RM RF: back to front

// Which legs a leg waits for before it lifts off.
enum class Coordination : std::uint8_t {
  groups,      // all of the group before: max-plus linear
  neighbours,  // those beside, ahead and behind; else it keeps the rhythm of its cycle. The cycle
               // in which the gait changes is one of groups.
};
// Leg j may not be in the air together with its neighbour i: the first rule of Cruse, "What
// mechanisms coordinate leg movement in walking arthropods?" (Trends in Neurosciences 13, 1990), on
// both sides.
bool neighbours(std::size_t i, std::size_t j) noexcept;

struct GaitTimes {
  double flight_s = 0;         // tau_f, lift-off to touchdown
  double stance_min_s = 0;     // tau_g, touchdown to the earliest lift-off
  double double_stance_s = 0;  // tau_Delta, touchdown of a group to lift-off of the next
  Coordination coordination = Coordination::groups;
};

// x(k): lift-off and touchdown of each leg in one cycle.
struct Events {
  PerLeg<double> touchdown_s{};
  PerLeg<double> lift_off_s{};
};

// x(k) = A0 (x) x(k) (+) A1 (x) x(k-1). Guarded: the first group of this cycle waits for all legs
// instead of the last group of its own gait, which makes the change from any other gait safe. Of
// Coordination::groups.
enum class Guard : std::uint8_t { own_last_group, all_legs };
max_plus::Matrix same_cycle(const Partition& gait, const GaitTimes& times) noexcept;   // A0
max_plus::Matrix from_last_cycle(const Partition&, const GaitTimes&, Guard) noexcept;  // A1
// A = A0* (x) A1; nothing when A0 is not nilpotent.
std::optional<max_plus::Matrix> system_matrix(const Partition&, const GaitTimes&, Guard) noexcept;

// Steady rhythm: cycle time lambda and one eigenvector v (first lift-off at 0), A (x) v = lambda
// (x) v.
double cycle_time_s(const Partition& gait, const GaitTimes& times) noexcept;
Events rhythm(const Partition& gait, const GaitTimes& times) noexcept;
// Every start converges to the one rhythm: tau_f + tau_g <= m (tau_f + tau_Delta).
bool synchronised(const Partition& gait, const GaitTimes& times) noexcept;

// One cycle ahead: with groups A (x) x(k-1), solved in the order of the groups instead of by the
// full matrix (36 maxima). No leg lifts off before `not_before_s` (lift-offs already commanded).
inline constexpr PerLeg<double> kAnyTime = {max_plus::kEps, max_plus::kEps, max_plus::kEps,
                                            max_plus::kEps, max_plus::kEps, max_plus::kEps};
Events next_cycle(const Partition& gait, const GaitTimes& times, const Events& last, Guard guard,
                  const PerLeg<double>& not_before_s = kAnyTime) noexcept;

// Moves events that depend on a postponed touchdown after it, within the cycle; moves nothing
// earlier.
void postpone_dependents(const Partition& gait, const GaitTimes& times, Events& cycle) noexcept;

// The same gait, beginning with another group.
Partition rotated(const Partition& gait, int first_group) noexcept;

// The rotation of the new gait with the least disturbance of the body's speed after `last`, and its
// ratio of longest to shortest stance during four cycles (at fixed sweep the body's speed is the
// inverse of the stance time).
struct Switch {
  Partition gait;
  double stance_ratio = 0;
};
Switch best_switch(const Partition& to, const GaitTimes& times, const Events& last,
                   const PerLeg<double>& not_before_s = kAnyTime) noexcept;

}  // namespace lss::gnc::zebro
