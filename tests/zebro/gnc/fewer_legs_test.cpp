// Walking on five and on four legs: the gaits and their margins.

#include "gnc/zebro/fewer_legs.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <bit>
#include <cstdio>
#include <fstream>
#include <functional>
#include <sstream>
#include <string>
#include <vector>

#include "gnc/zebro/schedule.h"
#include "tests/zebro/gnc/fewer_legs.h"

namespace lss::gnc::zebro::test {
namespace {

constexpr LocomotionParameters kDefault{};
constexpr Speed kSpeeds[] = {Speed::low, Speed::medium, Speed::high};

Roll roll_for(LegSet isolated, double direction, double heading_rad) {
  const Footing f = footing(isolated, kDefault);
  const SideSpeeds sides = side_speeds(direction, heading_rad);
  Roll roll{{}, f.offset_rad, kDefault.leg_diameter_m, kDefault.hips};
  for (std::size_t i = 0; i < kLegs; ++i) {
    roll.half_sweep_rad[i] = half_sweep_rad(is_left(static_cast<int>(i)) ? sides.left : sides.right,
                                            f.sweep_rad, kDefault.leg_diameter_m);
  }
  return roll;
}

// Walks two cycles on paper, flight by flight and roll by roll in small parts, and looks at the
// feet all the time in the second. Nothing of the search is used.
double walked_margin_m(const Creep& creep, const Roll& roll, int parts) {
  PerLeg<double> theta_rad{};
  double smallest_m = 1;
  for (int cycle = 0; cycle < 2; ++cycle) {
    for (int group = 0; group < creep.gait.groups; ++group) {
      PerLeg<bool> steps{}, down{}, down_in_flight{};
      for (std::size_t i = 0; i < kLegs; ++i) {
        steps[i] = creep.gait.group_of[i] == group;
        down[i] = creep.gait.group_of[i] != kNoGroup;
        down_in_flight[i] = down[i] && !steps[i];
      }
      const auto look = [&](const PerLeg<bool>& feet) {
        if (cycle == 0) return;
        smallest_m = std::min(smallest_m, static_margin_m(feet, theta_rad, roll.diameter_m));
      };
      look(down_in_flight);
      for (std::size_t i = 0; i < kLegs; ++i) {
        if (steps[i]) theta_rad[i] = roll.offset_rad + roll.half_sweep_rad[i];
      }
      look(down);
      if (((creep.rolls_after >> group) & 1) == 0) continue;
      for (int part = 0; part < parts; ++part) {
        for (std::size_t i = 0; i < kLegs; ++i) {
          theta_rad[i] -= 2 * roll.half_sweep_rad[i] / std::popcount(creep.rolls_after) / parts;
        }
        look(down);
      }
    }
  }
  return smallest_m;
}

// All orders of all groupings of the remaining legs, each begun with any group.
void for_all_partitions(LegSet isolated, const std::function<void(const Partition&)>& visit) {
  Partition gait;
  const std::function<void(std::size_t)> place = [&](std::size_t leg) {
    if (leg == kLegs) {
      int most = 0;
      LegSet used = 0;
      for (const std::uint8_t group : gait.group_of) {
        if (group == kNoGroup) continue;
        used = static_cast<LegSet>(used | 1 << group);
        most = std::max<int>(most, group);
      }
      gait.groups = most + 1;
      if (used == (1 << gait.groups) - 1) visit(gait);
      return;
    }
    if (contains(isolated, leg)) {
      gait.group_of[leg] = kNoGroup;
      return place(leg + 1);
    }
    for (std::uint8_t group = 0; group < kLegs; ++group) {
      gait.group_of[leg] = group;
      place(leg + 1);
    }
  };
  place(0);
}

// "~": the body rolls ahead before the next group lifts off.
std::string creep_text(const Creep& creep) {
  std::string text;
  for (int group = 0; group < creep.gait.groups; ++group) {
    LegSet members = 0;
    for (std::size_t i = 0; i < kLegs; ++i) {
      if (creep.gait.group_of[i] == group) members = static_cast<LegSet>(members | 1 << i);
    }
    text += (group > 0 ? ", " : "") + legs_text(members);
    if (contains(creep.rolls_after, static_cast<std::size_t>(group))) text += " ~";
  }
  return text;
}

// A row of the table in docs/gait-zebro.md: walking straight ahead, at each speed; without two legs
// all are alike. `said`: what its head says of gaits with so many groups.
std::string row(LegSet isolated, std::vector<std::string>& said) {
  const Footing f = footing(isolated, kDefault);
  const double ahead_m = advance_m(f.offset_rad - f.sweep_rad / 2, kDefault.leg_diameter_m) -
                         advance_m(f.offset_rad + f.sweep_rad / 2, kDefault.leg_diameter_m);
  const bool alike = std::popcount(isolated) == 2;
  std::string orders, margins;
  for (const Speed speed : kSpeeds) {
    if (alike && speed != Speed::medium) {
      orders += " as medium |";
      continue;
    }
    const StableGait found = stable_gait(isolated, speed, roll_for(isolated, 1, 0));
    const double lambda_s = cycle_time_s(found.creep.gait, f.times);
    char text[200];
    std::snprintf(text, sizeof text, "%d groups: %.1f s, %.1f mm/s", found.creep.gait.groups,
                  lambda_s, ahead_m / lambda_s * 1e3);
    said.emplace_back(text);
    std::snprintf(text, sizeof text, "%s%.1f", margins.empty() ? "" : ", ", found.margin_m * 1e3);
    margins += text;
    orders += " " + creep_text(found.creep) + " |";
  }
  return "| " + legs_text(isolated) + " |" + orders + " " + margins + " |";
}

TEST(FewerLegs, TableOfTheDocumentIsWhatTheCodeFinds) {
  std::ifstream file(LSS_GAIT_DOCUMENT);
  std::stringstream document;
  document << file.rdbuf();
  const std::string text = document.str();
  std::vector<std::string> said;
  for (const LegSet isolated : creeping()) {
    const std::string line = row(isolated, said);
    EXPECT_NE(text.find(line + "\n"), std::string::npos) << line;
  }
  for (const std::string& part : said) EXPECT_NE(text.find(part), std::string::npos) << part;
  EXPECT_EQ(said.size(), 6u * 3 + 3);
}

TEST(FewerLegs, AnyOneLegAndAnyTwoThatAreNoNeighboursMayBeMissing) {
  constexpr LegSet kNeighbours[] = {0b000011, 0b000101, 0b001010, 0b010100, 0b101000, 0b110000};
  for (const LegSet isolated : some_isolated()) {
    const bool neighbours = std::ranges::find(kNeighbours, isolated) != std::end(kNeighbours);
    EXPECT_EQ(can_walk_without(isolated, kDefault), !neighbours) << legs_text(isolated);
    const bool creeps = std::popcount(isolated) == 1 || isolated == 0b001100 ||
                        isolated == 0b100001 || isolated == 0b010010;
    EXPECT_EQ(creeps_without(isolated, kDefault), creeps) << legs_text(isolated);
  }
  EXPECT_TRUE(can_walk_without(0, kDefault));
  EXPECT_FALSE(can_walk_without(0b001011, kDefault));   // three
  EXPECT_FALSE(can_walk_without(0b1000000, kDefault));  // no leg
}

// Brute force over all ordered partitions and moments to roll, with a margin of its own.
TEST(FewerLegs, NoOtherCreepOfAsManyGroupsIsBetterAndAllOtherSetsHaveNone) {
  for (const LegSet isolated : some_isolated()) {
    const Roll roll = roll_for(isolated, 1, 0);
    PerLeg<double> best_m;  // by number of groups
    best_m.fill(-1);
    for_all_partitions(isolated, [&](const Partition& gait) {
      for (int rolls = 1; rolls < 1 << gait.groups; ++rolls) {
        double& best = best_m[static_cast<std::size_t>(gait.groups - 1)];
        best = std::max(best, walked_margin_m({gait, static_cast<std::uint8_t>(rolls)}, roll, 1));
      }
    });
    if (!creeps_without(isolated, kDefault)) {
      for (const double best : best_m) EXPECT_LT(best, 0) << legs_text(isolated);
      continue;
    }
    for (const Speed speed : kSpeeds) {
      const StableGait found = stable_gait(isolated, speed, roll);
      EXPECT_NEAR(found.margin_m, best_m[static_cast<std::size_t>(found.creep.gait.groups - 1)],
                  5e-6)
          << legs_text(isolated) << ' ' << found.creep.gait.groups;
    }
  }
}

TEST(FewerLegs, EverySpeedAndHeadingHasAMarginAllTheTimeAndLeavesThreeLegsDown) {
  for (const LegSet isolated : creeping()) {
    const int legs = kLegs - std::popcount(isolated);
    for (const double direction : {1.0, -1.0}) {
      for (int heading_deg = -90; heading_deg <= 90; heading_deg += 5) {
        const Roll roll = roll_for(isolated, direction, heading_deg * kDegree);
        int groups = 0;
        for (const Speed speed : {Speed::high, Speed::medium, Speed::low}) {
          const StableGait found = stable_gait(isolated, speed, roll);
          EXPECT_GE(found.margin_m, kLeastMargin_m) << legs_text(isolated) << ' ' << heading_deg;
          EXPECT_GE(found.creep.gait.groups, groups);
          groups = found.creep.gait.groups;
          EXPECT_GE(groups, legs == 5 ? 3 : 4);
          EXPECT_NEAR(walked_margin_m(found.creep, roll, 20), found.margin_m, 1e-9);
        }
      }
    }
  }
}

TEST(FewerLegs, BackwardIsTheSameInReverse) {
  for (const LegSet isolated : creeping()) {
    for (const Speed speed : kSpeeds) {
      EXPECT_NEAR(stable_gait(isolated, speed, roll_for(isolated, -1, 0)).margin_m,
                  stable_gait(isolated, speed, roll_for(isolated, 1, 0)).margin_m, 1e-5);
    }
  }
}

// By the gait's own matrix, as check() does for six legs.
TEST(FewerLegs, ChosenGaitsSynchronise) {
  for (const LegSet isolated : creeping()) {
    const Footing f = footing(isolated, kDefault);
    for (const Speed speed : kSpeeds) {
      const Partition gait = stable_gait(isolated, speed, roll_for(isolated, 1, 0)).creep.gait;
      EXPECT_TRUE(synchronised(gait, f.times));
      EXPECT_TRUE(synchronised(gait, footing(0, kDefault).times));
      EXPECT_NEAR(max_plus::cycle_mean(*system_matrix(gait, f.times, Guard::own_last_group)),
                  gait.groups * (f.times.flight_s + f.times.double_stance_s), 1e-9);
    }
  }
}

TEST(FewerLegs, ParametersThatLetTheBellyTouchAreNotCreptButRowed) {
  LocomotionParameters low = kDefault;
  low.belly_height_m = 0.045;
  EXPECT_EQ(check(low), nullptr);
  EXPECT_FALSE(creeps_without(0b000001, low));
  EXPECT_FALSE(creeps_without(0b001100, low));
  EXPECT_TRUE(can_walk_without(0b000001, low));  // by rowing, which means the belly to touch
}

// ---- the algebra with legs that have no events

rc::Gen<Partition> any_partition_without(LegSet isolated) {
  return rc::gen::map(any_partition(), [isolated](const Partition& six) {
    std::vector<int> used;
    for (std::size_t i = 0; i < kLegs; ++i) {
      if (!contains(isolated, i)) used.push_back(six.group_of[i]);
    }
    std::sort(used.begin(), used.end());
    used.erase(std::unique(used.begin(), used.end()), used.end());
    Partition gait{static_cast<int>(used.size()), {}};
    for (std::size_t i = 0; i < kLegs; ++i) {
      const auto at = std::lower_bound(used.begin(), used.end(), int{six.group_of[i]});
      gait.group_of[i] =
          contains(isolated, i) ? kNoGroup : static_cast<std::uint8_t>(at - used.begin());
    }
    return gait;
  });
}

rc::Gen<LegSet> any_isolated() { return rc::gen::elementOf(some_isolated()); }

Events without_events(LegSet isolated, Events x) {
  for (std::size_t i = 0; i < kLegs; ++i) {
    if (contains(isolated, i)) x.touchdown_s[i] = x.lift_off_s[i] = max_plus::kEps;
  }
  return x;
}

RC_GTEST_PROP(FewerLegs, SolvingGroupByGroupIsTheProductWithTheSystemMatrix, ()) {
  const LegSet isolated = *any_isolated();
  const Partition gait = *any_partition_without(isolated);
  const GaitTimes times = *any_times();
  const Events x = without_events(isolated, *any_events());
  const Guard guard = *rc::gen::element(Guard::own_last_group, Guard::all_legs);
  const Events next = next_cycle(gait, times, x, guard);
  const max_plus::Matrix a = *system_matrix(gait, times, guard);
  RC_ASSERT(to_vector(next) == max_plus::multiply(a, to_vector(x)));
  for (std::size_t i = 0; i < kLegs; ++i) {
    if (contains(isolated, i)) {
      RC_ASSERT(a[i] == max_plus::null()[i]);
      RC_ASSERT(a[kLegs + i] == max_plus::null()[i]);
      RC_ASSERT(same_cycle(gait, times)[i] == max_plus::null()[i]);
    }
    RC_ASSERT((next.lift_off_s[i] == max_plus::kEps) == contains(isolated, i));
    RC_ASSERT((next.touchdown_s[i] == max_plus::kEps) == contains(isolated, i));
  }
}

RC_GTEST_PROP(FewerLegs, AnyStartFallsIntoTheRhythmWithinTwoCycles, ()) {
  const LegSet isolated = *any_isolated();
  const Partition gait = *any_partition_without(isolated);
  const GaitTimes times = *synchronising_times(gait);
  const Events v = rhythm(gait, times);
  Events x = without_events(isolated, *any_events());
  for (int k = 0; k < 2; ++k) x = next_cycle(gait, times, x, Guard::own_last_group);
  const auto first = static_cast<std::size_t>(std::countr_one(isolated));
  const double offset_s = x.lift_off_s[first] - v.lift_off_s[first];
  for (std::size_t i = 0; i < kLegs; ++i) {
    if (contains(isolated, i)) continue;
    RC_ASSERT(std::abs(x.lift_off_s[i] - v.lift_off_s[i] - offset_s) < 1e-9);
    RC_ASSERT(std::abs(x.touchdown_s[i] - v.touchdown_s[i] - offset_s) < 1e-9);
  }
}

TEST(FewerLegs, GaitMayBeginWithAnyOfItsGroupsAndBestSwitchFindsTheOne) {
  const GaitTimes times{3.0, 3.25, 0.25};
  const Partition pairs{3, {kNoGroup, 0, 1, 2, 2, 1}}, wave{5, {kNoGroup, 0, 1, 2, 3, 4}};
  EXPECT_EQ(rotated(pairs, 1), (Partition{3, {kNoGroup, 2, 0, 1, 1, 0}}));
  const Events last = rhythm(wave, times);
  const Switch best = best_switch(pairs, times, last);
  double least = 100;
  for (int first = 0; first < pairs.groups; ++first) {
    // Longest over shortest stance of four cycles, as for six legs.
    const Partition gait = rotated(pairs, first);
    double longest_s = 0, shortest_s = 100;
    Events before = last;
    for (int k = 0; k < 4; ++k) {
      const Events x =
          next_cycle(gait, times, before, k == 0 ? Guard::all_legs : Guard::own_last_group);
      for (std::size_t i = 1; i < kLegs; ++i) {
        longest_s = std::max(longest_s, x.lift_off_s[i] - before.touchdown_s[i]);
        shortest_s = std::min(shortest_s, x.lift_off_s[i] - before.touchdown_s[i]);
      }
      before = x;
    }
    least = std::min(least, longest_s / shortest_s);
  }
  EXPECT_NEAR(best.stance_ratio, least, 1e-9);
  EXPECT_EQ(best.gait.group_of[0], kNoGroup);
}

RC_GTEST_PROP(FewerLegs, GuardedSwitchNeverPutsMoreLegsInTheAirThanEitherGait, ()) {
  const LegSet isolated = *any_isolated();
  const Partition from = *any_partition_without(isolated), to = *any_partition_without(isolated);
  const GaitTimes times = *any_times();
  Schedule schedule;
  schedule.start(from, times, 0);
  schedule.advance();
  std::vector<Events> cycles = {schedule.current()};
  schedule.change(to, kAnyTime);
  for (int k = 0; k < 4; ++k) {
    schedule.advance();
    cycles.push_back(schedule.current());
  }
  std::size_t largest = 0;
  for (const Partition& gait : {from, to}) {
    for (int group = 0; group < gait.groups; ++group) {
      largest = std::max(largest, static_cast<std::size_t>(std::count(gait.group_of.begin(),
                                                                      gait.group_of.end(), group)));
    }
  }
  for (const Events& at : cycles) {
    for (std::size_t i = 0; i < kLegs; ++i) {
      RC_ASSERT((at.lift_off_s[i] == max_plus::kEps) == contains(isolated, i));
    }
    for (const double time_s : at.lift_off_s) {
      std::size_t flying = 0;
      for (const Events& cycle : cycles) {
        for (std::size_t i = 0; i < kLegs; ++i) {
          if (cycle.lift_off_s[i] <= time_s && time_s < cycle.touchdown_s[i]) ++flying;
        }
      }
      RC_ASSERT(flying <= largest);
    }
  }
}

}  // namespace
}  // namespace lss::gnc::zebro::test
