#include "gnc/zebro/fewer_legs.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "gnc/math.h"
#include "gnc/zebro/locomotion.h"
#include "gnc/zebro/rowing.h"
#include "idl/angles.h"

namespace lss::gnc::zebro {

namespace {

constexpr LegSet kHind = 0b110000;
constexpr double kLongSweep_rad = 60 * kDegree;
// The toe behind the hip is twice as far from it as the arc ahead of it; this puts the middle of
// the foot's path under the hip. A missing hind leg needs the feet further back.
constexpr double kBalanced_rad = 5 * kDegree;
constexpr double kShareOfFlight = 0.5;  // the time to roll
// Smaller differences of margins are rounding: the first one wins, on every machine.
constexpr double kRounding_m = 1e-6;

// The best cyclic order of the remaining legs in so many groups, each leaving three legs down, with
// the best moments to roll. A counter with one digit for each leg but the first, which begins the
// cycle.
StableGait best_of(LegSet isolated, int groups, const Roll& roll) noexcept {
  std::array<std::size_t, kLegs> leg{};
  std::size_t legs = 0;
  for (std::size_t i = 0; i < kLegs; ++i) {
    if (!contains(isolated, i)) leg[legs++] = i;
  }
  StableGait best{{}, -std::numeric_limits<double>::infinity()};
  Creep creep;
  creep.gait.groups = groups;
  creep.gait.group_of.fill(kNoGroup);
  int numbers = 1;
  for (std::size_t n = 1; n < legs; ++n) numbers *= groups;
  for (int number = 0; number < numbers; ++number) {
    std::array<std::size_t, kLegs> members{};
    int digits = number * groups;
    for (std::size_t n = 0; n < legs; ++n, digits /= groups) {
      creep.gait.group_of[leg[n]] = static_cast<std::uint8_t>(digits % groups);
      ++members[creep.gait.group_of[leg[n]]];
    }
    const bool usable = std::all_of(members.begin(), members.begin() + groups,
                                    [&](std::size_t m) { return m > 0 && legs - m >= 3; });
    for (int rolls = 1; usable && rolls < 1 << groups; ++rolls) {
      creep.rolls_after = static_cast<std::uint8_t>(rolls);
      const double margin_m = static_margin_m(creep, roll, best.margin_m + kRounding_m);
      if (margin_m > best.margin_m + kRounding_m) best = {creep, margin_m};
    }
  }
  return best;
}

}  // namespace

Footing footing(LegSet isolated, const LocomotionParameters& p) noexcept {
  Footing f{
      {p.flight_s, p.stance_min_s, p.double_stance_s, p.coordination}, p.sweep_rad, p.offset_rad};
  if (isolated == 0) return f;
  f.times.coordination = Coordination::groups;
  f.times.double_stance_s = std::max(p.double_stance_s, kShareOfFlight * p.flight_s);
  f.sweep_rad = std::max(p.sweep_rad, kLongSweep_rad);
  const bool hind = std::popcount(isolated) == 1 && (isolated & kHind) != 0;
  if (!hind) f.offset_rad += kBalanced_rad;
  return f;
}

double creep_rad(const Creep& creep, std::size_t leg, int group, double half_sweep_rad,
                 double offset_rad) noexcept {
  int rolls = 0;
  int g = creep.gait.group_of[leg];
  do {
    rolls += (creep.rolls_after >> g) & 1;
    g = (g + 1) % creep.gait.groups;
  } while (g != group);
  const double rolled = static_cast<double>(rolls) / std::popcount(creep.rolls_after);
  return offset_rad + half_sweep_rad * (1 - 2 * rolled);
}

// While the body rolls all feet are down, between their places in one flight and in the next: only
// flights are checked.
double static_margin_m(const Creep& creep, const Roll& roll, double enough_m) noexcept {
  double smallest_m = std::numeric_limits<double>::infinity();
  for (int group = 0; group < creep.gait.groups && smallest_m > enough_m; ++group) {
    PerLeg<bool> in_stance{};
    PerLeg<double> theta_rad{};
    for (std::size_t i = 0; i < kLegs; ++i) {
      in_stance[i] = creep.gait.group_of[i] != kNoGroup && creep.gait.group_of[i] != group;
      if (!in_stance[i]) continue;
      theta_rad[i] = creep_rad(creep, i, group, roll.half_sweep_rad[i], roll.offset_rad);
    }
    smallest_m =
        std::min(smallest_m, static_margin_m(in_stance, theta_rad, roll.diameter_m, roll.hips));
  }
  return smallest_m;
}

StableGait stable_gait(LegSet isolated, Speed speed, const Roll& roll) noexcept {
  const int most = kLegs - std::popcount(isolated);
  const int fewest = most == 5 ? 3 : 4;
  const int choices = most - fewest + 1;
  const int first = speed == Speed::low ? choices - 1 : speed == Speed::medium ? choices / 2 : 0;
  StableGait best{{}, -std::numeric_limits<double>::infinity()};
  for (int n = 0; n < choices && best.margin_m < kLeastMargin_m; ++n) {
    const StableGait gait = best_of(isolated, fewest + (first + n) % choices, roll);
    if (gait.margin_m > best.margin_m) best = gait;
  }
  return best;
}

bool creeps_without(LegSet isolated, const LocomotionParameters& p) noexcept {
  const Footing f = footing(isolated, p);
  const double furthest_rad = std::abs(f.offset_rad) + f.sweep_rad / 2;
  if (furthest_rad >= math::acos(p.belly_height_m / p.leg_diameter_m)) return false;
  // Backward is the same in reverse; a test checks the margin of turns, over all headings.
  Roll roll{{}, f.offset_rad, p.leg_diameter_m, p.hips};
  roll.half_sweep_rad.fill(f.sweep_rad / 2);
  return stable_gait(isolated, Speed::high, roll).margin_m >= kLeastMargin_m;
}

bool can_walk_without(LegSet isolated, const LocomotionParameters& p) noexcept {
  if (isolated == 0) return true;
  if (isolated >= 1 << kLegs || std::popcount(isolated) > kMostIsolated) return false;
  return creeps_without(isolated, p) || rowing_margin_m(isolated, p) >= kLeastMargin_m;
}

}  // namespace lss::gnc::zebro
