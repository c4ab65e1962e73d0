// Every fault in every phase of the hop: its end. Limits of each type are those of
// docs/gnc-talaris.md.

#include <gtest/gtest.h>

#include <cstdio>
#include <functional>
#include <set>

#include "tests/talaris/gnc/dispersed.h"

namespace lss::gnc::talaris::test {
namespace {

struct Worst {
  double speed_m_s = 0, tilt_deg = 0, drift_m_s = 0, height_m = 0;
  int flights = 0, succeeded = 0, unfinished = 0, stops = 0;
  std::set<Phase> phases;  // in which it struck
  std::set<Reaction> reactions;
};

// A hop with `fault` from each 0.6 s after lift-off on; until it lies on the ground.
Worst strike(const char* name, const std::function<void(Hopper&)>& fault,
             const PlanRequest& request = {}) {
  Worst worst;
  for (int n = 0; n < 36; ++n) {
    World world;
    world.seed = static_cast<unsigned>(n) + 1;
    Hopper hopper(world, Parameters{});
    EXPECT_TRUE(hopper.flight.plan(request).feasible());
    EXPECT_TRUE(hopper.flight.execute());
    double lift_off = -1;
    while (hopper.time_s < 80 && !hopper.out.finished) {
      if (lift_off < 0 && hopper.out.airborne) lift_off = hopper.time_s;
      if (lift_off >= 0 && hopper.time_s >= lift_off + 0.6 * n - 1e-6) {
        worst.phases.insert(hopper.out.phase);
        fault(hopper);
      }
      hopper.frame();
    }
    if (hopper.out.all_stop) {
      for (int k = 0; k < 30 && !hopper.log.landed; ++k) hopper.frame();
    }
    ++worst.flights;
    worst.reactions.insert(hopper.out.reaction);
    worst.succeeded += hopper.out.succeeded ? 1 : 0;
    const bool down = hopper.log.landed || hopper.log.max_height_m < 0.12;  // hardly lifted off
    worst.unfinished += hopper.out.finished && down ? 0 : 1;
    worst.stops += hopper.out.all_stop ? 1 : 0;
    worst.speed_m_s = std::max(worst.speed_m_s, hopper.log.landing_speed_m_s);
    worst.tilt_deg = std::max(worst.tilt_deg, hopper.log.landing_tilt_rad / kDegree);
    worst.drift_m_s = std::max(worst.drift_m_s, hopper.log.landing_drift_m_s);
    worst.height_m = std::max(worst.height_m, hopper.log.max_height_m);
    // in every case: at the end no valve is open and no fan turns
    for (const Pulse& p : hopper.out.actuation.valve) EXPECT_EQ(p.on_s, 0);
    for (const double t : hopper.out.actuation.fan_throttle) EXPECT_EQ(t, 0);
  }
  std::printf("%-24s lands with %.2f m/s, tilted %.1f deg, sideways %.2f m/s; up to %.2f m\n", name,
              worst.speed_m_s, worst.tilt_deg, worst.drift_m_s, worst.height_m);
  EXPECT_EQ(worst.unfinished, 0) << name;
  EXPECT_LT(worst.height_m, request.height_m + 0.6) << name;
  for (const Phase phase :
       {Phase::ascend, Phase::hover, Phase::traverse, Phase::brake, Phase::descend}) {
    EXPECT_TRUE(worst.phases.contains(phase)) << name;
  }
  return worst;
}

void expect_lands(const Worst& w, double speed_m_s, double tilt_deg, double drift_m_s) {
  EXPECT_LT(w.speed_m_s, speed_m_s);
  EXPECT_LT(w.tilt_deg, tilt_deg);
  EXPECT_LT(w.drift_m_s, drift_m_s);
}

// As high as a plan may go.
PlanRequest high() {
  PlanRequest request;
  request.height_m = 10;
  request.distance_m = 5;
  return request;
}

TEST(TalarisContingency, LandIsObeyedInGoodOrder) {
  const Worst w = strike("land", [](Hopper& h) { h.flight.land(); });
  expect_lands(w, 0.6, 3, 0.6);
  EXPECT_EQ(w.stops, 0);
}

// A gust near the ground is waited for; what ends the flight meanwhile ends the waiting.
TEST(TalarisContingency, LandEndsTheWaitingForCalm) {
  Hopper hopper(World{}, Parameters{});
  ASSERT_TRUE(hopper.flight.plan({}).feasible());
  ASSERT_TRUE(hopper.flight.execute());
  double land_s = 0, waiting_s = 0;
  while (hopper.time_s < 80 && !hopper.out.finished) {
    const bool low = hopper.out.phase == Phase::descend && hopper.out.height_m < 0.5;
    if (land_s == 0 && low) {
      hopper.velocity.z() = 0.5;  // the gust
      waiting_s += kFrame_s;
      if (waiting_s >= 2) {
        EXPECT_GT(hopper.out.height_m, 0.14) << "it waits";
        hopper.flight.land();
        land_s = hopper.time_s;
      }
    }
    hopper.frame();
  }
  ASSERT_GT(land_s, 0);
  EXPECT_TRUE(hopper.out.finished);
  EXPECT_LT(hopper.time_s - land_s, 10);
  EXPECT_LT(hopper.log.landing_speed_m_s, 0.6);
}

TEST(TalarisContingency, AShortGapOfTheImuChangesNothing) {
  // silent in every tenth frame
  const Worst w = strike("IMU gaps", [](Hopper& h) {
    h.imu_silent = static_cast<int>(h.time_s / kFrame_s + 0.5) % 10 == 0;
  });
  EXPECT_EQ(w.succeeded, w.flights);
  expect_lands(w, 0.6, 3, 0.6);
}

TEST(TalarisContingency, WithoutAltimeterItEscapesByDeadReckoning) {
  expect_lands(strike("altimeter silent", [](Hopper& h) { h.range_silent = true; }), 0.9, 3, 0.6);
}

TEST(TalarisContingency, OverrunsEndInAnEscape) {
  expect_lands(strike("overruns", [](Hopper& h) { h.told = kOverruns; }), 0.6, 3, 0.6);
}

TEST(TalarisContingency, WithoutValvesTheFansAreTheParachute) {
  const Worst w = strike("valves silent", [](Hopper& h) { h.valves_dead = true; });
  expect_lands(w, 1.4, 8, 1.2);
  EXPECT_TRUE(w.reactions.contains(Reaction::parachute));
  EXPECT_EQ(w.stops, 0);
}

TEST(TalarisContingency, WithoutGasTheFansAreTheParachute) {
  expect_lands(strike("gas pressure gone", [](Hopper& h) { h.pressure_gone = true; }), 1.0, 8, 1.2);
}

// The 100 N of TALARIS thesis 2.3.2 do not carry the vehicle; they soften the fall.
TEST(TalarisContingency, WithFansOf100NewtonTheParachuteIsHard) {
  Parameters p;
  p.fans.thrust_N_per_rpm2 = 100.0 / (33000.0 * 33000.0);
  Hopper hopper(World{}, p);
  ASSERT_TRUE(hopper.flight.plan({}).feasible());
  ASSERT_TRUE(hopper.flight.execute());
  while (hopper.time_s < 60 && !hopper.out.finished) {
    hopper.valves_dead = hopper.valves_dead || hopper.out.phase == Phase::traverse;
    hopper.frame();
  }
  std::printf("parachute of 4 x 100 N: lands with %.2f m/s\n", hopper.log.landing_speed_m_s);
  EXPECT_TRUE(hopper.log.landed);
  EXPECT_GT(hopper.log.landing_speed_m_s, 1.0);
  EXPECT_LT(hopper.log.landing_speed_m_s, 2.6);
  EXPECT_LT(hopper.log.landing_tilt_rad, 10 * kDegree);
}

TEST(TalarisContingency, WithoutWordOfTheFansItEscapesWithGas) {
  expect_lands(strike("fan node silent", [](Hopper& h) { h.fans_silent = true; }), 1.0, 4, 0.6);
}

// The node fell back and was brought up again, half a second later: better than without.
TEST(TalarisContingency, FansThatComeBackCarryAgain) {
  const Worst w = strike("fans stopped, back", [](Hopper& h) {
    h.fans_silent = h.fans_dead = (h.out.faults & kFansLost) == 0;
  });
  expect_lands(w, 3.4, 10, 4.6);
  EXPECT_EQ(w.stops, 0);
}

// The gas lifts at most 232 N of 441 N: from 2 m it cannot be less than 4.3 m/s.
TEST(TalarisContingency, WhenTheFansStopGasTakesWhatItCan) {
  const Worst w = strike("fans stopped", [](Hopper& h) { h.fans_silent = h.fans_dead = true; });
  expect_lands(w, 4.9, 10, 4.6);
}

TEST(TalarisContingency, WithoutImuTheFansTakeItDownLevel) {
  expect_lands(strike("IMU silent", [](Hopper& h) { h.imu_silent = true; }), 1.6, 30, 8);
}

TEST(TalarisContingency, WithoutImuAndAltimeterItSinks) {
  expect_lands(
      strike("IMU, altimeter silent", [](Hopper& h) { h.imu_silent = h.range_silent = true; }), 2.2,
      30, 8);
}

TEST(TalarisContingency, WithNothingLeftEverythingIsStopped) {
  const Worst w = strike("valves and fans gone",
                         [](Hopper& h) { h.valves_dead = h.fans_silent = h.fans_dead = true; });
  EXPECT_GT(w.stops, 30);
}

TEST(TalarisContingency, AllStopIsObeyedAtOnceAnywhere) {
  const Worst w = strike("all-stop", [](Hopper& h) { h.flight.all_stop(); });
  EXPECT_GT(w.stops, 30);
}

TEST(TalarisContingency, LowGasEndsTheHopSoonerAndStillUnderControl) {
  Parameters p;
  World world;
  Hopper hopper(world, p);
  ASSERT_TRUE(hopper.flight.plan({}).feasible());
  for (int n = 0; n < 100; ++n) {  // 20 thruster-seconds leaked after the plan
    hopper.flight.count_gas({0.2});
  }
  ASSERT_TRUE(hopper.flight.execute());
  ASSERT_TRUE(hopper.run(60));
  EXPECT_NE(hopper.out.faults & kGasShort, 0U);
  EXPECT_EQ(hopper.out.faults & kGasLow, 0U) << "early enough";
  EXPECT_EQ(hopper.out.reaction, Reaction::shorten);
  EXPECT_EQ(hopper.out.shortfall, Shortfall::cut_short);
  EXPECT_FALSE(hopper.out.succeeded);
  EXPECT_LT(hopper.log.landing_speed_m_s, 0.6);
  EXPECT_LT(hopper.log.landing_drift_m_s, 0.8);
  EXPECT_LT(hopper.out.gas_used_s, 44);
}

// After a hold the rest of the way takes its time again: begun without the gas for it, the flight
// would end where it stopped.
TEST(TalarisContingency, AHoldIsOnlyBegunWhenTheGasCoversTheRestOfTheWayAfterIt) {
  constexpr double kBehind_m = 4.5, kSpare_s = 5;
  for (const bool enough : {false, true}) {
    Parameters p;
    if (enough) p.gas.budget_s = 60;
    Hopper hopper(World{}, p);
    ASSERT_TRUE(hopper.flight.plan({}).feasible());
    ASSERT_TRUE(hopper.flight.execute());
    while (hopper.time_s < 30 && !(hopper.out.phase == Phase::traverse && hopper.out.phase_s > 1.5))
      hopper.frame();
    ASSERT_EQ(hopper.out.phase, Phase::traverse);
    while (!enough && hopper.flight.gas().left_s() > hopper.out.gas_needed_s + kSpare_s)
      hopper.flight.count_gas({0.1});
    hopper.position.z() -= kBehind_m;
    for (int n = 0; n < 2; ++n) hopper.frame();
    EXPECT_EQ(hopper.out.phase, enough ? Phase::hold : Phase::traverse);
    ASSERT_TRUE(hopper.run(60));
    EXPECT_EQ(hopper.out.faults & kGasShort, 0U);
    EXPECT_TRUE(hopper.out.succeeded);
    EXPECT_NEAR(hopper.position.z(), 30, 1.5);
  }
}

// Nothing is cut before the ground because that took longer than from 2 m.
TEST(TalarisContingency, FromTenMetresItLandsToo) {
  struct Case {
    const char* name;
    void (*fault)(Hopper&);
    double speed_m_s, tilt_deg, drift_m_s;
  };
  for (const Case& c : {
           Case{"10 m: land", [](Hopper& h) { h.flight.land(); }, 0.8, 3, 0.6},
           Case{"10 m: overruns", [](Hopper& h) { h.told = kOverruns; }, 1.0, 3, 0.6},
           Case{"10 m: altimeter silent", [](Hopper& h) { h.range_silent = true; }, 1.4, 3, 0.6},
           Case{"10 m: valves silent", [](Hopper& h) { h.valves_dead = true; }, 1.5, 8, 1.2},
           Case{"10 m: gas pressure gone", [](Hopper& h) { h.pressure_gone = true; }, 1.0, 8, 1.2},
           Case{"10 m: fan node silent", [](Hopper& h) { h.fans_silent = true; }, 1.0, 4, 0.6},
       })
    expect_lands(strike(c.name, c.fault, high()), c.speed_m_s, c.tilt_deg, c.drift_m_s);
}

TEST(TalarisContingency, FromTenMetresTheParachuteWithoutAltimeterLandsToo) {
  // the altimeter is lost on the way down
  const auto both = [](Hopper& h) {
    h.valves_dead = true;
    h.range_silent = h.out.phase == Phase::parachute && h.out.phase_s > 4;
  };
  expect_lands(strike("10 m: valves, altimeter", both, high()), 1.5, 8, 1.2);
}

// As slow as may be configured.
TEST(TalarisContingency, ASlowParachuteFromTenMetresIsNotCut) {
  Parameters p;
  p.limits.parachute_m_s = 0.2;
  Hopper hopper(World{}, p);
  ASSERT_TRUE(hopper.flight.plan(high()).feasible());
  ASSERT_TRUE(hopper.flight.execute());
  while (hopper.time_s < 120 && !hopper.out.finished) {
    hopper.valves_dead = hopper.valves_dead || hopper.out.phase == Phase::brake;
    hopper.frame();
  }
  EXPECT_TRUE(hopper.log.landed);
  EXPECT_LT(hopper.log.landing_speed_m_s, 1.0);
}

// Without IMU, on its side: the altimeter looks at a wall, and the fans must come to an end.
TEST(TalarisContingency, WithoutImuAnAltimeterThatSaysHighDoesNotKeepTheFansRunning) {
  Hopper hopper(World{}, Parameters{});
  ASSERT_TRUE(hopper.flight.plan({}).feasible());
  ASSERT_TRUE(hopper.flight.execute());
  while (hopper.time_s < 60 && hopper.out.phase != Phase::parachute) {
    hopper.imu_silent = hopper.out.phase == Phase::traverse || hopper.imu_silent;
    hopper.frame();
  }
  FlightInputs inputs = hopper.inputs;
  inputs.range_m = 5;
  double still_s = 0;
  while (still_s < 60 && !hopper.out.finished) {
    hopper.out = hopper.flight.step(inputs);
    still_s += kFrame_s;
  }
  EXPECT_TRUE(hopper.out.finished);
  EXPECT_GT(still_s, 10);
  EXPECT_LT(still_s, 30);
}

TEST(TalarisContingency, OnTheGroundAFaultStopsEverything) {
  Hopper hopper(World{}, Parameters{});
  ASSERT_TRUE(hopper.flight.plan({}).feasible());
  ASSERT_TRUE(hopper.flight.execute());
  for (int n = 0; n < 5; ++n) hopper.frame();
  EXPECT_EQ(hopper.out.phase, Phase::spin_up);
  EXPECT_FALSE(hopper.out.airborne);
  hopper.imu_silent = true;
  ASSERT_TRUE(hopper.run(2));
  EXPECT_TRUE(hopper.out.all_stop);
  EXPECT_FALSE(hopper.log.landed);
}

TEST(TalarisContingency, FansThatDoNotComeToSpeedAreGivenUpOnTheGround) {
  World world;
  world.fan_speed[2] = 0.6;
  Hopper hopper(world, Parameters{});
  ASSERT_TRUE(hopper.flight.plan({}).feasible());
  ASSERT_TRUE(hopper.flight.execute());
  ASSERT_TRUE(hopper.run(20));
  EXPECT_TRUE(hopper.out.all_stop);
  EXPECT_NE(hopper.out.faults & kSpinUpFailed, 0U);
  EXPECT_LT(hopper.log.max_height_m, 0.01);
}

// Hovering quietly, then for one frame as `happen` says; its faults.
FaultSet faults_after(const Parameters& parameters, const std::function<void(Hopper&)>& happen) {
  World world;
  world.noise = 0;
  Hopper hopper(world, parameters);
  EXPECT_TRUE(hopper.flight.plan({}).feasible());
  EXPECT_TRUE(hopper.flight.execute());
  while (hopper.time_s < 60 && hopper.out.phase != Phase::hover) hopper.frame();
  EXPECT_EQ(hopper.out.faults, 0u);
  happen(hopper);
  hopper.frame();
  return hopper.out.faults;
}

// Of each limit one percent to either side, at two values of it.
TEST(TalarisContingency, LimitsOfTiltRateAndPressureAreThoseOfTheirParameters) {
  for (const double share : {0.99, 1.01}) {
    SCOPED_TRACE(share);
    const FaultSet upset = share > 1 ? FaultSet{kUpset} : FaultSet{0};
    for (const double tilt_rad : {20 * kDegree, 30 * kDegree}) {
      Parameters p;
      p.limits.tilt_rad = tilt_rad;
      EXPECT_EQ(faults_after(p,
                             [&](Hopper& h) {
                               h.q_NB = Eigen::AngleAxisd(share * tilt_rad, Vector3::UnitY());
                             }),
                upset);
    }
    for (const double rate_rad_s : {90 * kDegree, 180 * kDegree}) {
      Parameters p;
      p.limits.rate_rad_s = rate_rad_s;
      EXPECT_EQ(faults_after(p, [&](Hopper& h) { h.rate_B = Vector3(0, 0, -share * rate_rad_s); }),
                upset);
    }
    for (const double least_kPa : {800.0, 1000.0}) {
      Parameters p;
      p.gas.min_regulated_kPa = least_kPa;
      EXPECT_EQ(faults_after(p, [&](Hopper& h) { h.regulated_kPa = share * least_kPa; }),
                share < 1 ? FaultSet{kPressureLost} : FaultSet{0});
    }
  }
}

TEST(TalarisContingency, TheTable) {
  const FaultSet none = 0;
  EXPECT_EQ(react(none, true, true, true), Reaction::none);
  EXPECT_EQ(react(kImuGap, true, true, true), Reaction::hold);
  EXPECT_EQ(react(kImuLost, true, true, true), Reaction::parachute);
  EXPECT_EQ(react(kImuLost | kFansLost, true, true, true), Reaction::all_stop);
  EXPECT_EQ(react(kAltimeterLost, true, true, true), Reaction::escape);
  EXPECT_EQ(react(kValvesLost, true, true, true), Reaction::parachute);
  EXPECT_EQ(react(kPressureLost | kAltimeterLost, true, true, true), Reaction::parachute);
  EXPECT_EQ(react(kValvesLost | kFansLost, true, true, true), Reaction::all_stop);
  EXPECT_EQ(react(kFansLost, true, true, true), Reaction::escape);
  EXPECT_EQ(react(kUpset, true, true, true), Reaction::parachute);
  EXPECT_EQ(react(kActuatorFailed, true, true, true), Reaction::escape);
  EXPECT_EQ(react(kActuatorFailed | kUpset, true, true, true), Reaction::escape);
  EXPECT_EQ(react(kActuatorFailed | kPressureLost, true, true, true), Reaction::parachute);
  EXPECT_EQ(react(kUpset | kFansLost, true, true, true), Reaction::escape);
  EXPECT_EQ(react(kGasLow, true, true, true), Reaction::escape);
  EXPECT_EQ(react(kOverruns, true, true, true), Reaction::escape);
  EXPECT_EQ(react(kOverruns, true, true, false), Reaction::parachute);
  EXPECT_EQ(react(kFansLost, true, true, false), Reaction::all_stop);
  EXPECT_EQ(react(kUpset, false, true, true), Reaction::all_stop);
  EXPECT_EQ(react(kValvesLost, false, false, true), Reaction::all_stop);
  EXPECT_EQ(react(kAltimeterLost, false, false, true), Reaction::land);
  // more faults never make the reaction milder, in flight with all that a hop has
  for (FaultSet a = 0; a < 2048; ++a) {
    for (FaultSet bit = 1; bit < 2048; bit <<= 1U) {
      const Reaction before = react(a, true, true, true), after = react(a | bit, true, true, true);
      const bool fewer_ways = (bit & kFansLost) != 0;  // no parachute without fans
      if (fewer_ways || (a & kFansLost) != 0) continue;
      EXPECT_LE(before, after) << a << ' ' << bit;
    }
  }
}

}  // namespace
}  // namespace lss::gnc::talaris::test
