#include "gnc/zebro/gait.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <vector>

#include "gnc/zebro/schedule.h"
#include "tests/zebro/gnc/generators.h"

namespace lss::gnc::zebro::test {
namespace {

constexpr Guard kPlain = Guard::own_last_group;
constexpr GaitTimes kDefault{3.0, 3.3, 0.3};

// Highest number of legs in the air at once; a touchdown and a lift-off at the same instant do not
// overlap.
int most_in_flight(const std::vector<Events>& cycles) {
  int most = 0;
  for (const Events& at : cycles) {
    for (const double time_s : at.lift_off_s) {
      int flying = 0;
      for (const Events& cycle : cycles) {
        for (std::size_t i = 0; i < kLegs; ++i) {
          if (cycle.lift_off_s[i] <= time_s && time_s < cycle.touchdown_s[i]) ++flying;
        }
      }
      most = std::max(most, flying);
    }
  }
  return most;
}

int largest_group(const Partition& gait) {
  int largest = 0;
  for (int group = 0; group < gait.groups; ++group) {
    largest = std::max(
        largest, static_cast<int>(std::count(gait.group_of.begin(), gait.group_of.end(), group)));
  }
  return largest;
}

std::vector<Events> walked(const Partition& gait, const GaitTimes& times, Events x, int cycles,
                           Guard first = kPlain) {
  std::vector<Events> out;
  for (int k = 0; k < cycles; ++k) {
    x = next_cycle(gait, times, x, k == 0 ? first : kPlain);
    out.push_back(x);
  }
  return out;
}

Events shifted(Events events, double by_s) {
  for (double& time_s : events.touchdown_s) time_s += by_s;
  for (double& time_s : events.lift_off_s) time_s += by_s;
  return events;
}

// Same shape as the gait's rhythm, wherever in time.
bool in_rhythm(const Partition& gait, const GaitTimes& times, const Events& x) {
  const Events v = rhythm(gait, times);
  const double offset_s = x.lift_off_s[0] - v.lift_off_s[0];
  const max_plus::Vector wanted = to_vector(shifted(v, offset_s)), seen = to_vector(x);
  for (std::size_t i = 0; i < max_plus::kSize; ++i) {
    if (std::abs(wanted[i] - seen[i]) > 1e-9) return false;
  }
  return true;
}

RC_GTEST_PROP(Gait, SolvingGroupByGroupIsTheProductWithTheSystemMatrix, ()) {
  const Partition gait = *any_partition();
  const GaitTimes times = *any_times();
  const Events x = *any_events();
  const Guard guard = *rc::gen::element(Guard::own_last_group, Guard::all_legs);
  const max_plus::Matrix a = *system_matrix(gait, times, guard);
  RC_ASSERT(to_vector(next_cycle(gait, times, x, guard)) == max_plus::multiply(a, to_vector(x)));
}

RC_GTEST_PROP(Gait, FlightIsExactlyTauFAndStanceAtLeastTauG, ()) {
  const Partition gait = *any_partition();
  const GaitTimes times = *any_times();
  Events last = next_cycle(gait, times, *any_events(), kPlain);
  for (int k = 0; k < 5; ++k) {
    const Events x = next_cycle(gait, times, last, kPlain);
    for (std::size_t i = 0; i < kLegs; ++i) {
      RC_ASSERT(x.touchdown_s[i] - x.lift_off_s[i] == times.flight_s);
      RC_ASSERT(x.lift_off_s[i] - last.touchdown_s[i] >= times.stance_min_s);
    }
    last = x;
  }
}

RC_GTEST_PROP(Gait, AnyStartFallsIntoTheRhythmWithinTwoCycles, ()) {
  const Partition gait = *any_partition();
  const GaitTimes times = *synchronising_times(gait);
  const std::vector<Events> cycles = walked(gait, times, *any_events(), 5);
  for (std::size_t k = 1; k < cycles.size(); ++k) RC_ASSERT(in_rhythm(gait, times, cycles[k]));
}

TEST(Gait, UnsynchronisedTimesKeepTheRhythmOfTheStart) {
  const GaitTimes slow{3.0, 9.0, 0.3};
  ASSERT_FALSE(synchronised(kTripod, slow));
  Events odd = rhythm(kTripod, slow);
  odd.lift_off_s[1] += 1.0;
  odd.touchdown_s[1] += 1.0;
  EXPECT_FALSE(in_rhythm(kTripod, slow, walked(kTripod, slow, odd, 20).back()));
}

RC_GTEST_PROP(Gait, DifferentGroupsNeverFlyTogether, ()) {
  const Partition gait = *any_partition();
  const GaitTimes times = *any_times();
  Events landed = *any_events(64);
  for (std::size_t i = 0; i < kLegs; ++i) {
    landed.lift_off_s[i] = landed.touchdown_s[i] - times.flight_s;
  }
  const std::vector<Events> cycles = walked(gait, times, landed, 4);
  for (const Events& a : cycles) {
    for (const Events& b : cycles) {
      for (std::size_t i = 0; i < kLegs; ++i) {
        for (std::size_t j = 0; j < kLegs; ++j) {
          if (gait.group_of[i] == gait.group_of[j]) continue;
          RC_ASSERT(a.touchdown_s[i] <= b.lift_off_s[j] || b.touchdown_s[j] <= a.lift_off_s[i]);
        }
      }
    }
  }
  RC_ASSERT(most_in_flight(cycles) <= largest_group(gait));
}

// From a gait at any point of its convergence to another, guarded or not.
int most_in_flight_across(const Partition& from, const Partition& to, const GaitTimes& times,
                          Guard guard) {
  std::vector<Events> cycles = walked(from, times, rhythm(from, times), 3);
  for (const Events& x : walked(to, times, cycles.back(), 4, guard)) cycles.push_back(x);
  return most_in_flight(cycles);
}

RC_GTEST_PROP(GaitSwitch, GuardedCycleNeverPutsMoreLegsInTheAirThanEitherGait, ()) {
  const Partition from = *any_partition(), to = *any_partition();
  const GaitTimes times = *any_times();
  const int most = std::max(largest_group(from), largest_group(to));
  RC_ASSERT(most_in_flight_across(from, to, times, Guard::all_legs) <= most);
  const Partition turned = best_switch(to, times, rhythm(from, times)).gait;
  RC_ASSERT(most_in_flight_across(from, turned, times, Guard::all_legs) <= most);
}

TEST(GaitSwitch, WithoutTheGuardSomePairsPutTooManyLegsInTheAir) {
  const Partition gaits[] = {
      kTripod, kTetrapodB, kWave, {3, {0, 2, 1, 0, 2, 1}}, {6, {0, 1, 2, 3, 4, 5}}};
  int broken = 0;
  for (const Partition& from : gaits) {
    for (const Partition& to : gaits) {
      const int most = std::max(largest_group(from), largest_group(to));
      if (most_in_flight_across(from, to, {3.0, 0.5, 0.3}, kPlain) > most) ++broken;
      EXPECT_LE(most_in_flight_across(from, to, {3.0, 0.5, 0.3}, Guard::all_legs), most);
    }
  }
  EXPECT_GT(broken, 0);
}

struct SwitchCase {
  Partition from, to;
  double ratio;
  std::size_t begins_with;  // a leg of the group that lifts off first
};

TEST(GaitSwitch, BestRotationDisturbsTheSpeedAsLittleAsComputedByHand) {
  constexpr std::size_t kLF = 0, kLM = 2, kRM = 3, kLH = 4;
  const SwitchCase cases[] = {
      {kTripod, kTetrapodB, 1.92, kLF}, {kTripod, kWave, 4.67, kLH},
      {kTetrapodB, kTripod, 1.92, kLF}, {kTetrapodB, kWave, 2.91, kRM},
      {kWave, kTetrapodB, 3.39, kLM},
  };
  for (const SwitchCase& c : cases) {
    const Switch best = best_switch(c.to, kDefault, rhythm(c.from, kDefault));
    EXPECT_NEAR(best.stance_ratio, c.ratio, 0.005);
    EXPECT_EQ(best.gait.group_of[c.begins_with], 0);
  }
}

RC_GTEST_PROP(Gait, LateTouchdownDelaysNothingByMoreThanItself, ()) {
  const Partition gait = *any_partition();
  const GaitTimes times = *synchronising_times(gait);
  const auto late = static_cast<std::size_t>(*rc::gen::inRange(0, kLegs));
  const double by_s = *dyadic_s(1, 320);

  const Events on_time = rhythm(gait, times);
  Events delayed = on_time;
  delayed.touchdown_s[late] += by_s;
  postpone_dependents(gait, times, delayed);
  Events a = on_time, b = delayed;
  for (int k = 0; k < 5; ++k) {
    const max_plus::Vector x = to_vector(a), y = to_vector(b);
    for (std::size_t i = 0; i < max_plus::kSize; ++i) {
      RC_ASSERT(y[i] >= x[i]);
      RC_ASSERT(y[i] <= x[i] + by_s);
    }
    if (k >= 2) RC_ASSERT(in_rhythm(gait, times, b));
    a = next_cycle(gait, times, a, kPlain);
    b = next_cycle(gait, times, b, kPlain);
  }
}

TEST(Gait, TableOfTheDefaultGaits) {
  EXPECT_DOUBLE_EQ(cycle_time_s(kWave, kDefault), 19.8);
  EXPECT_DOUBLE_EQ(cycle_time_s(kTetrapodB, kDefault), 9.9);
  EXPECT_DOUBLE_EQ(cycle_time_s(kTripod, kDefault), 6.6);
  for (const Partition& gait : {kWave, kTetrapodB, kTripod}) {
    EXPECT_TRUE(synchronised(gait, kDefault));
  }
}

// In any sequence of events a commanded event is never moved to an earlier time.
RC_GTEST_PROP(Schedule, EventsOnlyEverMoveLater, ()) {
  const GaitTimes times{3.0, 3.25, 0.25};
  Schedule schedule;
  schedule.start(*shipped_gait(), times, 0);
  for (int n = 0; n < 30; ++n) {
    const Events current = schedule.current(), next = schedule.next();
    PerLeg<double> commanded_s = kAnyTime;
    switch (*rc::gen::inRange(0, 3)) {
      case 0:
        schedule.postpone_touchdown(static_cast<std::size_t>(*rc::gen::inRange(0, kLegs)),
                                    current.touchdown_s[0] + *dyadic_s(-640, 640));
        commanded_s = next.lift_off_s;
        break;
      case 1:
        for (std::size_t i = 0; i < kLegs; ++i) {
          if (*rc::gen::arbitrary<bool>()) commanded_s[i] = next.lift_off_s[i];
        }
        schedule.change(*shipped_gait(), commanded_s);
        break;
      default:
        schedule.advance();
        RC_ASSERT(schedule.current().lift_off_s == next.lift_off_s);
        continue;
    }
    for (std::size_t i = 0; i < kLegs; ++i) {
      RC_ASSERT(schedule.current().lift_off_s[i] >= current.lift_off_s[i]);
      RC_ASSERT(schedule.current().touchdown_s[i] >= current.touchdown_s[i]);
      RC_ASSERT(schedule.next().lift_off_s[i] >= commanded_s[i]);
      // Cycles do not mix: all legs have landed before the first of the next cycle lifts off.
      for (std::size_t j = 0; j < kLegs; ++j) {
        RC_ASSERT(schedule.next().lift_off_s[i] >= schedule.current().touchdown_s[j]);
      }
    }
  }
}

}  // namespace
}  // namespace lss::gnc::zebro::test
