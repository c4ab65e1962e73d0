#include "gnc/zebro/gait.h"

#include <algorithm>
#include <cstddef>
#include <limits>

namespace lss::gnc::zebro {

namespace {

using max_plus::kEps;
using max_plus::Matrix;

double last_touchdown_s(const Partition& gait, int group, const Events& events) noexcept {
  double last_s = kEps;
  for (std::size_t i = 0; i < kLegs; ++i) {
    if (gait.group_of[i] == group) last_s = std::max(last_s, events.touchdown_s[i]);
  }
  return last_s;
}

// After the begin of its cycle.
double begins_s(const GaitTimes& times, int group) noexcept {
  return group * (times.flight_s + times.double_stance_s);
}

// When the cycle after `last` begins: in the rhythm of the leg with the greatest delay, and not
// before all legs have landed.
double next_begins_s(const Partition& gait, const GaitTimes& times, const Events& last) noexcept {
  double began_s = kEps;
  for (std::size_t i = 0; i < kLegs; ++i) {
    if (gait.group_of[i] != kNoGroup)
      began_s = std::max(began_s, last.lift_off_s[i] - begins_s(times, gait.group_of[i]));
  }
  const double landed_s = *std::max_element(last.touchdown_s.begin(), last.touchdown_s.end());
  return std::max(began_s + cycle_time_s(gait, times), landed_s);
}

// When the neighbours of leg i have landed: of this cycle those of earlier groups.
double neighbours_landed_s(const Partition& gait, std::size_t i, const Events& cycle,
                           const Events* last) noexcept {
  double landed_s = kEps;
  for (std::size_t j = 0; j < kLegs; ++j) {
    if (!neighbours(i, j)) continue;
    if (last != nullptr) landed_s = std::max(landed_s, last->touchdown_s[j]);
    if (gait.group_of[j] < gait.group_of[i]) landed_s = std::max(landed_s, cycle.touchdown_s[j]);
  }
  return landed_s;
}

}  // namespace

bool neighbours(std::size_t i, std::size_t j) noexcept {
  const std::size_t apart = i > j ? i - j : j - i;
  return apart == 2 || (apart == 1 && i / 2 == j / 2);
}

Matrix same_cycle(const Partition& gait, const GaitTimes& times) noexcept {
  Matrix a0 = max_plus::null();
  for (std::size_t i = 0; i < kLegs; ++i) {
    if (gait.group_of[i] == kNoGroup) continue;
    a0[i][kLegs + i] = times.flight_s;
    for (std::size_t j = 0; j < kLegs; ++j) {
      if (gait.group_of[i] == gait.group_of[j] + 1) a0[kLegs + i][j] = times.double_stance_s;
    }
  }
  return a0;
}

Matrix from_last_cycle(const Partition& gait, const GaitTimes& times, Guard guard) noexcept {
  Matrix a1 = max_plus::identity();
  for (std::size_t i = 0; i < kLegs; ++i) {
    if (gait.group_of[i] == kNoGroup) {
      a1[i][i] = a1[kLegs + i][kLegs + i] = max_plus::kEps;
      continue;
    }
    for (std::size_t j = 0; j < kLegs; ++j) {
      const bool waits = gait.group_of[i] == 0 &&
                         (guard == Guard::all_legs || gait.group_of[j] == gait.groups - 1);
      if (waits) a1[kLegs + i][j] = times.double_stance_s;
    }
    a1[kLegs + i][i] = std::max(a1[kLegs + i][i], times.stance_min_s);
  }
  return a1;
}

std::optional<Matrix> system_matrix(const Partition& gait, const GaitTimes& times,
                                    Guard guard) noexcept {
  const std::optional<Matrix> star = max_plus::star(same_cycle(gait, times));
  if (!star) return std::nullopt;
  return max_plus::multiply(*star, from_last_cycle(gait, times, guard));
}

double cycle_time_s(const Partition& gait, const GaitTimes& times) noexcept {
  return std::max(times.flight_s + times.stance_min_s,
                  gait.groups * (times.flight_s + times.double_stance_s));
}

Events rhythm(const Partition& gait, const GaitTimes& times) noexcept {
  Events v;
  for (std::size_t i = 0; i < kLegs; ++i) {
    const bool steps = gait.group_of[i] != kNoGroup;
    v.lift_off_s[i] = !steps ? max_plus::kEps : begins_s(times, gait.group_of[i]);
    v.touchdown_s[i] = v.lift_off_s[i] + times.flight_s;
  }
  return v;
}

bool synchronised(const Partition& gait, const GaitTimes& times) noexcept {
  return times.flight_s + times.stance_min_s <=
         gait.groups * (times.flight_s + times.double_stance_s);
}

Events next_cycle(const Partition& gait, const GaitTimes& times, const Events& last, Guard guard,
                  const PerLeg<double>& not_before_s) noexcept {
  Events next;
  next.lift_off_s = next.touchdown_s = kAnyTime;
  const bool by_neighbours =
      times.coordination == Coordination::neighbours && guard == Guard::own_last_group;
  const double clock_s = by_neighbours ? next_begins_s(gait, times, last) : kEps;
  double landed_s = guard == Guard::all_legs
                        ? *std::max_element(last.touchdown_s.begin(), last.touchdown_s.end())
                        : last_touchdown_s(gait, gait.groups - 1, last);
  for (int group = 0; group < gait.groups; ++group) {
    for (std::size_t i = 0; i < kLegs; ++i) {
      if (gait.group_of[i] != group) continue;
      if (by_neighbours) landed_s = neighbours_landed_s(gait, i, next, &last);
      next.lift_off_s[i] =
          std::max({landed_s + times.double_stance_s, last.touchdown_s[i] + times.stance_min_s,
                    last.lift_off_s[i], not_before_s[i], clock_s + begins_s(times, group)});
      next.touchdown_s[i] = std::max(next.lift_off_s[i] + times.flight_s, last.touchdown_s[i]);
    }
    if (!by_neighbours) landed_s = last_touchdown_s(gait, group, next);
  }
  return next;
}

void postpone_dependents(const Partition& gait, const GaitTimes& times, Events& cycle) noexcept {
  for (int group = 1; group < gait.groups; ++group) {
    double landed_s = last_touchdown_s(gait, group - 1, cycle);
    for (std::size_t i = 0; i < kLegs; ++i) {
      if (gait.group_of[i] != group) continue;
      if (times.coordination == Coordination::neighbours)
        landed_s = neighbours_landed_s(gait, i, cycle, nullptr);
      cycle.lift_off_s[i] = std::max(cycle.lift_off_s[i], landed_s + times.double_stance_s);
      cycle.touchdown_s[i] = std::max(cycle.touchdown_s[i], cycle.lift_off_s[i] + times.flight_s);
    }
  }
}

Partition rotated(const Partition& gait, int first_group) noexcept {
  Partition turned = gait;
  for (std::uint8_t& group : turned.group_of) {
    if (group == kNoGroup) continue;
    group = static_cast<std::uint8_t>((group - first_group + gait.groups) % gait.groups);
  }
  return turned;
}

Switch best_switch(const Partition& to, const GaitTimes& times, const Events& last,
                   const PerLeg<double>& not_before_s) noexcept {
  constexpr int kCycles = 4;
  Switch best{to, std::numeric_limits<double>::infinity()};
  for (int first = 0; first < to.groups; ++first) {
    const Partition gait = rotated(to, first);
    double longest_s = 0;
    double shortest_s = std::numeric_limits<double>::infinity();
    Events before = last;
    for (int k = 0; k < kCycles; ++k) {
      const Events cycle = k == 0 ? next_cycle(gait, times, before, Guard::all_legs, not_before_s)
                                  : next_cycle(gait, times, before, Guard::own_last_group);
      for (std::size_t i = 0; i < kLegs; ++i) {
        if (gait.group_of[i] == kNoGroup) continue;
        const double stance_s = cycle.lift_off_s[i] - before.touchdown_s[i];
        longest_s = std::max(longest_s, stance_s);
        shortest_s = std::min(shortest_s, stance_s);
      }
      before = cycle;
    }
    // Rotations that differ by rounding only are equal: the first one wins, on every machine.
    constexpr double kRounding = 1e-9;
    if (longest_s / shortest_s < best.stance_ratio - kRounding) {
      best = {gait, longest_s / shortest_s};
    }
  }
  return best;
}

}  // namespace lss::gnc::zebro
