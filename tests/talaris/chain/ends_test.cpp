// A flight always ends: upright when physics allows it, with everything shut and the fans off,
// with any readings of the altimeter, and within a time that is known beforehand.

#include <gtest/gtest.h>

#include "idl/talaris/codes.h"
#include "tests/talaris/chain/flights.h"
#include "tests/talaris/chain/many.h"

namespace lss::talaris {
namespace {

constexpr double kLongest_s = 60;  // of a flight whose altimeter is wrong, from execute on

bool descends(Chain& chain) { return chain.phase() == Phase::descend; }

FlightPlan hop_with(std::vector<std::string> faults, std::function<bool(Chain&)> when) {
  return {.faults = std::move(faults), .strike = std::move(when)};
}

// The beam looks into a hole: the range is longer than the legs are above the ground.
TEST(TalarisEnds, AHoleUnderTheBeamDoesNotKeepItFlying) {
  for (const char* fault :
       {"altimeter-offset:0.45", "altimeter-offset:0.7", "altimeter-offset:1"}) {
    for (const unsigned seed : {1u, 2u, 41u, 181u}) {
      const Flown flown = fly(hop_with({fault}, descends), seed);
      SCOPED_TRACE(std::string(fault) + " " + flown.text());
      EXPECT_TRUE(flown.upright());
      EXPECT_LT(flown.run_s, kLongest_s);
      EXPECT_LT(flown.gas_s, 42);
      EXPECT_LT(flown.down_m_s, 2);
      EXPECT_FALSE(flown.succeeded && (flown.down_m_s > 1 || flown.sideways_m_s > 0.5));
    }
  }
}

TEST(TalarisEnds, AHoleDuringTheParachuteDoesNotKeepTheFansRunning) {
  for (const unsigned seed : {1u, 2u, 3u}) {
    const Flown flown = fly(hop_with({"altimeter-offset:1", "node-silent:0x20"}, descends), seed);
    SCOPED_TRACE(flown.text());
    EXPECT_TRUE(flown.upright());
    EXPECT_LT(flown.run_s, kLongest_s);
  }
}

TEST(TalarisEnds, AnAltimeterThatRepeatsItselfIsNotBelieved) {
  for (const double at_s : {2.0, 8.0, 12.0, 15.0}) {
    FlightPlan plan{.faults = {"altimeter-stuck"}, .fault_s = at_s};
    const Flown flown = fly(plan, 1 + static_cast<unsigned>(at_s));
    SCOPED_TRACE(flown.text());
    EXPECT_TRUE(flown.upright());
    EXPECT_TRUE(std::ranges::count(flown.faults, faults::altitude_lost) == 1);
    EXPECT_LT(flown.run_s, kLongest_s);
    EXPECT_LT(flown.down_m_s, 1.5);
    EXPECT_FALSE(flown.succeeded);
  }
}

// Heavier than fans and gas can lift.
TEST(TalarisEnds, AVehicleThatCannotLeaveTheGroundIsGivenUp) {
  const auto load = [](sim::talaris::TalarisOptions& world) { world.plant.mass_kg = 58; };
  const Flown flown = fly({.dispersed = false, .world = load}, 1);
  SCOPED_TRACE(flown.text());
  EXPECT_FALSE(flown.lifted_off);
  EXPECT_TRUE(flown.came_down);
  EXPECT_FALSE(flown.succeeded);
  EXPECT_NE(flown.why, Reason::none);
  EXPECT_LT(flown.run_s, 20);
}

// Samples that fans shake are no touchdown: fans and valves stay on down to the ground.
TEST(TalarisEnds, FansThatShakeTheImuAreNotTheGround) {
  for (const double shaken_m_s2 : {3.0, 4.0, 6.0}) {
    const auto shake = [&](sim::talaris::TalarisOptions& world) {
      world.imu.vibration_m_s2 = shaken_m_s2;
      world.imu.vibration_rad_s = 0.02 * shaken_m_s2;
    };
    for (const unsigned seed : {1u, 2u, 3u, 7u}) {
      const Flown flown = fly({.world = shake}, seed);
      SCOPED_TRACE(flown.text());
      EXPECT_TRUE(flown.upright());
      EXPECT_LT(flown.down_m_s, 1) << shaken_m_s2 << " m/s2";
      EXPECT_FALSE(flown.succeeded && flown.sideways_m_s > 0.5);
    }
  }
}

// Then the motion of the IMU is no witness: the flight ends all the same.
TEST(TalarisEnds, FansThatShakeTheImuOverAHoleDoNotKeepItFlying) {
  for (const unsigned seed : {1u, 2u, 41u, 181u}) {
    FlightPlan plan = hop_with({"altimeter-offset:0.7"}, descends);
    plan.world = [](sim::talaris::TalarisOptions& world) { world.imu.vibration_m_s2 = 4; };
    const Flown flown = fly(plan, seed);
    SCOPED_TRACE(flown.text());
    EXPECT_TRUE(flown.upright());
    EXPECT_LT(flown.run_s, kLongest_s);
    EXPECT_LT(flown.down_m_s, 2);
    EXPECT_FALSE(flown.succeeded && (flown.down_m_s > 1 || flown.sideways_m_s > 0.5));
  }
}

}  // namespace
}  // namespace lss::talaris
