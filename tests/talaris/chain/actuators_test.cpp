// Failed valves and fans on the whole chain: a sample at each commit, LSS_EVERYTHING=1 all of them.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <tuple>

#include "idl/talaris/codes.h"
#include "tests/support/everything.h"
#include "tests/talaris/chain/campaigns.h"
#include "tests/talaris/chain/failed_actuators.h"
#include "tests/talaris/chain/many.h"

namespace lss::talaris {
namespace {

TEST(TalarisBusCut, OfThreeHundredMillisecondsIsFlownThrough) {
  unsigned seed = 0;
  for (const Phase phase : kStruckPhases) {
    const Flown flown = fly_through_cut(0.3, phase, ++seed);
    SCOPED_TRACE(std::string(kPhaseNames[static_cast<std::size_t>(phase)]) + ", " + flown.text());
    EXPECT_TRUE(flown.upright());
    EXPECT_LE(flown.down_m_s, 2);
  }
}

// In each phase: the fans go on, no node is reset, and it lands upright.
template <class Fly>
void are_flown_through(FaultId fault, const Fly& fly) {
  unsigned seed = 0;
  for (const Phase phase : kStruckPhases) {
    const auto [flown, fans_off, resets] = fly(phase, ++seed);
    SCOPED_TRACE(std::string(kPhaseNames[static_cast<std::size_t>(phase)]) + ", " + flown.text());
    EXPECT_EQ(fans_off, 0u);
    EXPECT_EQ(resets, 0u);
    EXPECT_NE(std::ranges::find(flown.faults, fault), flown.faults.end());
    EXPECT_TRUE(flown.upright());
    EXPECT_LE(flown.down_m_s, 2);
  }
}

// The fans go on, as at a cut: icd-talaris.md, 7.
TEST(TalarisBusOff, OfAHundredMillisecondsIsFlownThrough) {
  are_flown_through(FaultId::bus_off, [](Phase phase, unsigned seed) {
    return fly_through_bus_off(0.1, phase, seed);
  });
}

// The fans go on until it has landed: flips.md.
TEST(TalarisBusMemory, DamagedInBothCopiesItLands) {
  for (const bool of_valves : {false, true}) {
    SCOPED_TRACE(of_valves);
    are_flown_through(FaultId::memory_lost, [&](Phase phase, unsigned seed) {
      return fly_through_damage(of_valves, phase, seed);
    });
  }
}

TEST(TalarisFailedActuators, OthersThanFansAndLiftValvesThatStayOpenAreSurvived) {
  std::size_t number = 0;
  for (const ActuatorFailure& failure : actuator_failures()) {
    for (const Phase phase : kStruckPhases) {
      if (!testing_support::in_sample(number++, 16)) continue;
      const Struck struck = strike(failure, phase, static_cast<unsigned>(number));
      SCOPED_TRACE(failure.fault + " in phase " + kPhaseNames[static_cast<std::size_t>(phase)] +
                   ", " + struck.flown.text());
      EXPECT_TRUE(struck.flown.came_down);
      EXPECT_FALSE(struck.flown.succeeded && struck.found);
      if (failure.often_lost) {
        EXPECT_TRUE(struck.found);
        continue;
      }
      EXPECT_FALSE(struck.wrong);
      EXPECT_TRUE(survived(struck.flown));
    }
  }
}

// It turns by up to 40 % faster than the parameters say.
TEST(TalarisFailedActuators, ALiftValveOfALightVehicleThatStaysShutIsSurvived) {
  constexpr unsigned kLight = 5;
  const auto& all = actuator_failures();
  const auto shut =
      std::ranges::find(all, std::string("valve-stuck-shut:3"), &ActuatorFailure::fault);
  ASSERT_NE(shut, all.end());
  for (const Phase phase : {Phase::traverse, Phase::descend}) {
    const Struck struck = strike(*shut, phase, kLight);
    SCOPED_TRACE(struck.flown.text());
    EXPECT_TRUE(struck.found);
    EXPECT_FALSE(struck.wrong);
    EXPECT_TRUE(survived(struck.flown));
  }
}

// It is free before, or soon after, the orders reckon with its thrust.
TEST(TalarisFailedActuators, ALiftValveThatStaysOpenForAMomentIsSurvived) {
  for (const auto& [seed, valve, stuck_s] : {std::tuple{3u, 3, 0.45}, std::tuple{4u, 7, 0.5}}) {
    const std::string fault = fmt::format("valve-stuck-open:{}", valve);
    FlightPlan plan{.faults = {fault}};  // so that the step is asked
    double struck_s = 0;
    bool free = false;
    plan.strike_step = [&](Chain& chain) {
      if (struck_s == 0 && chain.phase() == Phase::traverse) {
        chain.inject(fault);
        struck_s = chain.seconds();
      } else if (struck_s > 0 && !free && chain.seconds() - struck_s >= stuck_s) {
        chain.inject("clear:" + fault);
        free = true;
      }
      return false;
    };
    const Flown flown = fly(plan, seed);
    SCOPED_TRACE(flown.text());
    EXPECT_TRUE(free);
    EXPECT_TRUE(survived(flown));
  }
}

TEST(TalarisFailedActuators, WithoutFailureNoneIsCondemned) {
  for (const bool wide : {false, true}) {
    for (const unsigned seed : {3u, 17u}) {
      FlightPlan plan;
      if (wide) plan = wide_flight();
      plan.each_frame = [&](Chain& chain) {
        EXPECT_TRUE(gnc::talaris::all_good(chain.vehicle().flight().health)) << wide << ' ' << seed;
      };
      EXPECT_TRUE(fly(plan, seed).came_down);
    }
  }
}

TEST(TalarisResults, FailedActuators) {
  const char* seeds = std::getenv("LSS_RESULTS_ACTUATORS");
  if (seeds == nullptr)
    GTEST_SKIP() << "set LSS_RESULTS_ACTUATORS to the number of flights of each failure and phase";
  actuators_section(static_cast<unsigned>(std::atoi(seeds)));
}

TEST(TalarisResults, BusCut) {
  const char* seeds = std::getenv("LSS_RESULTS_CUT");
  if (seeds == nullptr)
    GTEST_SKIP() << "set LSS_RESULTS_CUT to the number of flights of each phase";
  for (const double cut_s : {0.1, 0.3, 0.4}) {
    for (const Phase phase : kStruckPhases) {
      const auto all = runs(static_cast<unsigned>(std::atoi(seeds)),
                            [&](unsigned seed) { return fly_through_cut(cut_s, phase, seed); });
      const auto down = figures(all, [](const Flown& f) { return f.down_m_s; });
      std::printf("cut %.1f s, %s: upright %u, as planned %u of %zu, down %.2f median, %.2f most\n",
                  cut_s, kPhaseNames[static_cast<std::size_t>(phase)],
                  count(all, [](const Flown& f) { return f.upright(); }),
                  count(all, [](const Flown& f) { return f.succeeded; }), all.size(),
                  down.share(0.5), down.most());
      for (const Flown& f : all)
        if (!f.upright() || f.down_m_s > 2) std::printf("%s\n", f.text().c_str());
    }
  }
}

TEST(TalarisResults, NoActuatorIsCondemnedWithoutFailure) {
  const char* seeds = std::getenv("LSS_RESULTS_ALARMS");
  if (seeds == nullptr) GTEST_SKIP() << "set LSS_RESULTS_ALARMS to the number of flights";
  for (const bool wide : {false, true}) {
    const auto most = runs(static_cast<unsigned>(std::atoi(seeds)), [&](unsigned seed) {
      FlightPlan plan;
      if (wide) plan = wide_flight();
      double worst = 0;
      plan.each_frame = [&](Chain& chain) {
        const auto& f = chain.vehicle().flight();
        worst = std::max(worst, f.suspicion);
        if (f.verdict.health != gnc::talaris::Health::good)
          std::printf(
              "ALARM wide %d seed %u phase %d actuator %zu health %d height %.2f measured %.1f "
              "limit %.1f\n",
              wide, seed, static_cast<int>(f.phase), f.verdict.actuator,
              static_cast<int>(f.verdict.health), f.height_m, f.verdict.measured, f.verdict.limit);
      };
      fly(plan, seed);
      return worst;
    });
    const auto all = figures(most, [](double x) { return x; });
    std::printf("wide %d: suspicion median %.2f, 95 %% %.2f, most %.2f\n", wide, all.share(0.5),
                all.share(0.95), all.most());
  }
}

}  // namespace
}  // namespace lss::talaris
