// Sensors beyond those as built: a camera, a second IMU, and altimeters at the corners; with and
// without failures of them.

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>

#include "idl/talaris/codes.h"
#include "tests/support/everything.h"
#include "tests/talaris/chain/campaigns.h"
#include "tests/talaris/chain/failed_actuators.h"
#include "tests/talaris/chain/flights.h"

namespace lss::talaris {
namespace {

constexpr double kMostOff_m = 6;

// Flights of the wide set with a camera, which succeed.
void fly_wide(std::initializer_list<unsigned> seeds, void (*expect)(const Flown&)) {
  for (const unsigned seed : seeds) {
    const Flown flown = fly(with_camera(wide_flight()), seed);
    SCOPED_TRACE(flown.text());
    EXPECT_TRUE(flown.succeeded);
    expect(flown);
  }
}

// As built these touch down with 0.4 to 0.7 m/s sideways. Navigation's speed is that of the last
// frame, up to 0.2 s before contact.
TEST(TalarisCamera, KeepsTheSpeedOverGroundAndThePlace) {
  fly_wide({1, 31, 34}, [](const Flown& flown) {
    EXPECT_LT(flown.sideways_m_s, 0.4);
    EXPECT_LT(flown.off_m(), 1.5);
    EXPECT_LT(flown.nav_side_m_s, 0.15);
  });
}

// Drag that is gone when it stands, jets at full thrust and so without roll: with a lean against
// all of the drag these came down 2.8 m short, for want of gas, and 1.4 m across.
TEST(TalarisCamera, BrakesWhereItIsMeantTo) {
  fly_wide({10, 67}, [](const Flown& flown) {
    EXPECT_LT(flown.off_m(), 1);
    EXPECT_LT(flown.gas_s, 36);
  });
}

// By navigation 0.28 to 0.46 m from it, when only the speed counted near the ground.
TEST(TalarisCamera, HoldsThePlaceAgainstGustsOnTheWayDown) {
  fly_wide({7, 19, 30}, [](const Flown& flown) {
    EXPECT_LT(std::abs(flown.across_m - flown.nav_across_m), 0.25);
    EXPECT_LT(flown.sideways_m_s, 0.2);
  });
}

// 1 % of 30 m: as much as the configuration says, and no more than navigation says.
TEST(TalarisCamera, NavigationKnowsThatItsScaleMayBeOff) {
  const auto off = [](sim::talaris::TalarisOptions& world) { world.camera.scale = 0.01; };
  const Flown flown = fly(with_camera({.world = off}), 1);
  SCOPED_TRACE(flown.text());
  EXPECT_GT(std::abs(flown.nav_along_m), 0.15);
  EXPECT_LT(flown.nav_off_m(), 3 * flown.sigma_m);
}

// Gusts of the wide set that came on the last half metre: 0.5 to 0.8 m/s sideways without waiting.
TEST(TalarisCamera, GustsNearTheGroundAreWaitedFor) {
  fly_wide({28, 42, 67}, [](const Flown& flown) { EXPECT_LT(flown.sideways_m_s, 0.45); });
}

// Without it the flight goes on as built.
TEST(TalarisCamera, OneThatIsSilentBlindOrFarOffCostsNoFlight) {
  for (const char* fault : {"camera-silent", "camera-blind", "camera-off:3"}) {
    const Flown flown = fly(with_camera({.faults = {fault}, .fault_s = 6}), 2);
    SCOPED_TRACE(std::string(fault) + ": " + flown.text());
    EXPECT_TRUE(flown.upright());
    EXPECT_LT(flown.down_m_s, 1);
    EXPECT_LT(flown.sideways_m_s, 1);
    EXPECT_LT(flown.off_m(), kMostOff_m);
    EXPECT_TRUE(!flown.succeeded || safe(flown));
    EXPECT_EQ(std::ranges::count(flown.faults, faults::camera_lost),
              std::string_view(fault) == "camera-blind" ? 0 : 1);
  }
}

// Frozen, mounted the wrong way round, half as much again, off to one side: it comes down as if
// there were none.
TEST(TalarisCamera, OneThatLiesCostsNoFlight) {
  const auto expect_gentle = [](const FlightPlan& plan, unsigned seed) {
    const Flown flown = fly(plan, seed);
    SCOPED_TRACE(flown.text());
    EXPECT_TRUE(safe(flown));
    EXPECT_LT(flown.off_m(), kMostOff_m);
    EXPECT_EQ(std::ranges::count(flown.faults, faults::camera_lost), 1);
  };
  for (const double scale : {-1.0, -2.0, -0.5}) {
    const auto lies = [=](sim::talaris::TalarisOptions& world) { world.camera.scale = scale; };
    expect_gentle(with_camera({.world = lies}), 1);
  }
  for (const char* fault : {"camera-off:0.16", "camera-off:0.5", "camera-off:3"}) {
    expect_gentle(with_camera({.faults = {fault}, .fault_s = 0.1}), 2);
  }
}

FlightPlan over_a_floor(FlightPlan plan) {
  plan.adjust = [](Parameters& p) {
    p.navigation.ground_slope_rad = 0;
    p.navigation.range_sigma_m = 0.004;
  };
  return plan;
}

// Over a floor that is known to be level they keep the attitude, and so place and speed; and
// navigation knows how well: the mean square of 16 errors is 1 +- 0.35.
TEST(TalarisCorners, KeepThePlaceOverAFloor) {
  double squares = 0;
  for (unsigned seed = 301; seed <= 308; ++seed) {
    const Flown with = fly(with_corner_altimeters(over_a_floor({})), seed);
    SCOPED_TRACE(with.text());
    EXPECT_TRUE(with.succeeded);
    EXPECT_LT(with.sigma_m, 0.55);    // 0.68 without them
    EXPECT_LT(with.sigma_m_s, 0.09);  // 0.12
    squares += (with.nav_along_m * with.nav_along_m + with.nav_across_m * with.nav_across_m) /
               (16 * with.sigma_m * with.sigma_m);
  }
  EXPECT_LT(squares, 1.7);
  const Flown without = fly(over_a_floor({}), 301);
  EXPECT_GT(without.sigma_m, 0.6);
}

TEST(TalarisCorners, FlyTheWideSetAsWithoutThem) {
  for (const unsigned seed : {1u, 31u, 34u}) {
    const Flown flown = fly(with_corner_altimeters(wide_flight()), seed);
    SCOPED_TRACE(flown.text());
    EXPECT_TRUE(safe(flown));
    EXPECT_LT(flown.off_m(), kMostOff_m);
    EXPECT_TRUE(flown.faults.empty());
  }
}

// The one in the middle fails, or lies: they replace it.
TEST(TalarisCorners, TheLossOfTheAltimeterCostsNoFlight) {
  for (const char* fault : {"altimeter-silent", "altimeter-error", "altimeter-stuck",
                            "altimeter-offset:0.8", "altimeter-offset:-0.8"}) {
    for (const double at_s : {6.0, 14.0}) {
      const Flown flown = fly(with_corner_altimeters({.faults = {fault}, .fault_s = at_s}), 302);
      SCOPED_TRACE(std::string(fault) + ": " + flown.text());
      EXPECT_TRUE(flown.succeeded);
      EXPECT_TRUE(safe(flown));
      EXPECT_LT(flown.height_error_m, 0.3);
      EXPECT_EQ(std::ranges::count(flown.faults, faults::altitude_lost), 0);
      const bool lies = std::string_view(fault).starts_with("altimeter-offset");
      EXPECT_EQ(
          std::ranges::count(flown.faults, lies ? faults::altimeter_off : faults::altimeter_lost),
          std::string_view(fault) == "altimeter-stuck" ? 0 : 1);
    }
  }
}

// Overruled by four, of which one is silent then: nothing says how high it is.
TEST(TalarisCorners, AnAltimeterThatIsDoubtedIsNotUsedAgain) {
  FlightPlan plan = with_corner_altimeters({.faults = {"altimeter-offset:0.8"}, .fault_s = 5});
  plan.each_frame = [struck = false](Chain& chain) mutable {
    if (struck || !chain.has(faults::altimeter_off, kAltimeterModule)) return;
    struck = true;
    chain.inject("corner-silent:3");
  };
  const Flown flown = fly(plan, 304);
  SCOPED_TRACE(flown.text());
  EXPECT_TRUE(flown.upright());
  EXPECT_FALSE(flown.succeeded);
  EXPECT_EQ(std::ranges::count(flown.faults, faults::altitude_lost), 1);
}

// Without one of the four, or with one that lies, it flies as built.
TEST(TalarisCorners, TheLossOfOneOfThemCostsNoFlight) {
  for (const char* fault : {"corner-silent:3", "corner-offset:2:0.5", "corner-offset:4:0.2"}) {
    const Flown flown = fly(with_corner_altimeters({.faults = {fault}, .fault_s = 6}), 303);
    SCOPED_TRACE(std::string(fault) + ": " + flown.text());
    EXPECT_TRUE(flown.succeeded);
    EXPECT_TRUE(safe(flown));
    EXPECT_EQ(std::ranges::count(flown.faults, faults::corner_altimeter_lost),
              std::string_view(fault) == "corner-silent:3" ? 1 : 0);
    EXPECT_EQ(std::ranges::count(flown.faults, faults::altimeter_off), 0);
  }
}

// Taken for measurements the samples moved the height so far that the altimeter was not believed.
TEST(TalarisImu, OneThatRepeatsASampleAgainAndAgainIsFlownThrough) {
  struct Repeats {
    unsigned seed;
    double every_s, for_s;
  };
  for (const auto& [seed, every_s, for_s] : {Repeats{1, 0.89, 0.1}, Repeats{2, 0.4, 0.11}}) {
    FlightPlan plan{.faults = {""}};  // so that the step is asked
    plan.strike_step = [=, stuck = false](Chain& chain) mutable {
      if (!chain.airborne()) return false;
      const bool now = std::fmod(chain.seconds(), every_s) < for_s;
      if (now != stuck) chain.inject(now ? "imu-stuck" : "clear:imu-stuck");
      stuck = now;
      return false;
    };
    const Flown flown = fly(plan, seed);
    SCOPED_TRACE(flown.text());
    EXPECT_TRUE(flown.upright());
    EXPECT_LT(flown.down_m_s, 1);
  }
}

TEST(TalarisStandbyImu, TheLossOfOneImuCostsNoFlight) {
  for (const char* fault : {"imu-silent", "imu-stuck", "standby-imu-silent", "standby-imu-stuck"}) {
    for (const double at_s : {1.03, 15.11}) {
      if (at_s > 2 && fault != std::string_view("imu-silent")) continue;
      const Flown flown =
          fly(with_camera(with_standby_imu({.faults = {fault}, .fault_s = at_s})), 1);
      SCOPED_TRACE(std::string(fault) + ": " + flown.text());
      EXPECT_TRUE(flown.succeeded);
      EXPECT_TRUE(safe(flown));
      EXPECT_LT(flown.off_m(), 1.5);
      EXPECT_EQ(std::ranges::count(flown.faults, faults::navigation_lost), 0);
    }
  }
}

TEST(TalarisStandbyImu, OneThatIsOffEndsTheFlightUpright) {
  for (const char* fault : {"imu-bias:2:0.05", "imu-bias:6:0.4"}) {  // 2.9 deg/s; 0.4 m/s2
    const Flown flown = fly(with_standby_imu({.faults = {fault}, .fault_s = 6}), 1);
    SCOPED_TRACE(std::string(fault) + ": " + flown.text());
    EXPECT_TRUE(flown.upright());
    EXPECT_EQ(std::ranges::count(flown.faults, faults::imus_disagree), 1);
    EXPECT_FALSE(flown.succeeded);
  }
}

// IMU and altimeter, with and without others that replace them: a sample at each commit.
TEST(TalarisFailedSensors, AreSurvivedExceptTheOnlyImu) {
  std::size_t number = 0;
  for (const Failure& failure : sensor_failures()) {
    for (const Phase phase : kStruckPhases) {
      if (!testing_support::in_sample(number++, 7)) continue;
      const Flown flown = fail_in(phase, failure, static_cast<unsigned>(number));
      SCOPED_TRACE(std::string(failure.name) + " in phase " +
                   kPhaseNames[static_cast<std::size_t>(phase)] + ", " + flown.text());
      EXPECT_TRUE(flown.came_down);
      EXPECT_FALSE(wrong(flown));
      if (failure.right == std::string_view("as planned")) {
        EXPECT_TRUE(flown.succeeded);
      }
      if (!failure.often_lost) {
        EXPECT_TRUE(survived(flown));
      }
    }
  }
}

TEST(TalarisResults, FailedSensors) {
  const char* seeds = std::getenv("LSS_RESULTS_SENSORS");
  if (seeds == nullptr)
    GTEST_SKIP() << "set LSS_RESULTS_SENSORS to the number of flights of each failure and phase";
  sensors_section(static_cast<unsigned>(std::atoi(seeds)));
}

}  // namespace
}  // namespace lss::talaris
