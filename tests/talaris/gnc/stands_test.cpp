// The test campaigns of the TALARIS thesis 5.2.3 to 5.2.9 on their stands.

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

#include "tests/talaris/gnc/dispersed.h"

namespace lss::gnc::talaris::test {
namespace {

World stand(Stand which) {
  World world;
  world.stand = which;
  return world;
}

PlanRequest request(Program program, double height_m = 0, double time_s = 0) {
  PlanRequest r;
  r.program = program;
  r.height_m = height_m;
  r.time_s = time_s;
  return r;
}

PlanRequest turn(double degrees, Program program = Program::turn) {
  PlanRequest r = request(program);
  r.turn_rad = degrees * kDegree;
  r.distance_m = 0.8;
  return r;
}

Spread sled_spread() {
  Spread s;
  s.mass = s.inertia = 0.3;
  s.thrust = 0.1;
  s.drift_m_s2 = 0;  // the altimeter looks at the wall
  return s;
}

TEST(TalarisTurn, NinetyDegreesSettleWithinSixSecondsIntoALimitCycle) {
  World world = stand(Stand::sled);
  world.moment_N_m = {0.1, 0, 0};
  Hopper hopper(world, Parameters{});
  ASSERT_TRUE(hopper.flight.plan(turn(90)).feasible());
  ASSERT_TRUE(hopper.flight.execute());
  double within = 0, cycle = 0;
  while (hopper.time_s < 30 && !hopper.out.finished) {
    hopper.frame();
    const double e = std::abs(attitude_of(hopper.q_NB).roll_rad - 90 * kDegree);
    if (e > 3 * kDegree) within = hopper.time_s;
    if (hopper.time_s > 5.5) cycle = std::max(cycle, e);
  }
  EXPECT_TRUE(hopper.out.succeeded);
  EXPECT_GT(within, 3.5);  // 20 deg/s
  EXPECT_LT(within, 5.2);
  EXPECT_LT(cycle, 3 * kDegree);
}

TEST(TalarisTurn, TwoHundredDispersedTurnsSucceed) {
  int succeeded = 0;
  Statistics end, gas, time;
  for (unsigned seed = 1; seed <= 200; ++seed) {
    Hopper hopper(dispersed(seed, sled_spread(), stand(Stand::sled)), Parameters{});
    hopper.fly(turn(90));
    const double e = attitude_of(hopper.q_NB).roll_rad - 90 * kDegree;
    succeeded += hopper.out.succeeded && std::abs(e) < 5 * kDegree ? 1 : 0;
    end.add(e / kDegree);
    gas.add(hopper.out.gas_used_s);
    time.add(hopper.time_s);
  }
  std::printf("turns: %d of 200; error %.2f..%.2f deg, %.2f thruster-s, %.1f..%.1f s\n", succeeded,
              end.least, end.most, gas.mean(), time.least, time.most);
  EXPECT_EQ(succeeded, 200);
}

TEST(TalarisTurn, TwoHundredDispersedTurnsAndTraversesSucceed) {
  int succeeded = 0;
  Statistics along, gas, time;
  for (unsigned seed = 1; seed <= 200; ++seed) {
    Hopper hopper(dispersed(seed, sled_spread(), stand(Stand::sled)), Parameters{});
    hopper.fly(turn(45, Program::turn_traverse));
    // distance to the wall, which stands 45 deg from where it looked; the turn itself moves it
    const Vector3 target = hopper.out.target_N_m - hopper.position;
    const double e = (target.z() - target.y()) / std::sqrt(2.0);
    succeeded += hopper.out.succeeded && std::abs(e) < 0.15 ? 1 : 0;
    along.add(e);
    gas.add(hopper.out.gas_used_s);
    time.add(hopper.time_s);
  }
  std::printf("turn-traverse: %d of 200; error %.3f..%.3f m, %.2f thruster-s, %.1f..%.1f s\n",
              succeeded, along.least, along.most, gas.mean(), time.least, time.most);
  EXPECT_EQ(succeeded, 200);
}

TEST(TalarisTraverse, OnRailsTheTargetIsReached) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    PlanRequest r = request(Program::traverse);
    r.distance_m = 2;
    r.range_m = 4;
    Hopper hopper(dispersed(seed, sled_spread(), stand(Stand::rails)), Parameters{});
    ASSERT_TRUE(hopper.fly(r));
    EXPECT_TRUE(hopper.out.succeeded);
    EXPECT_NEAR(hopper.position.z(), 2, 0.15);
  }
}

TEST(TalarisAttitude, StaysWithinTwoDegreesBalancedAndThreeUnbalanced) {
  double balanced = 0, unbalanced = 0;
  for (unsigned seed = 1; seed <= 20; ++seed) {
    Spread s;
    s.moment_N_m = {0, 0.3, 0.2};
    World world = dispersed(seed, s, stand(seed % 2 == 0 ? Stand::attitude_y : Stand::attitude_z));
    Hopper first(world, Parameters{});
    ASSERT_TRUE(first.fly(request(Program::attitude)));
    EXPECT_TRUE(first.out.succeeded);
    balanced = std::max(balanced, first.log.max_tilt_rad);
    world.moment_N_m =
        seed % 2 == 0 ? Vector3(0, 2.0, 0) : Vector3(0, 0, -1.2);  // weight on one end
    Hopper second(world, Parameters{});
    ASSERT_TRUE(second.fly(request(Program::attitude)));
    // brought to within 3 deg (5.2.8) after the initial effect of the weight
    unbalanced = std::max(unbalanced, second.log.settled_tilt_rad);
    EXPECT_LT(second.log.max_tilt_rad, 8 * kDegree);
  }
  std::printf("attitude: %.2f deg balanced, %.2f deg unbalanced\n", balanced / kDegree,
              unbalanced / kDegree);
  EXPECT_LT(balanced, 2 * kDegree);
  EXPECT_LT(unbalanced, 3 * kDegree);
}

TEST(TalarisAltitude, GasAndFansHopOnTheStandHoldingTheAttitude) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    Hopper hopper(dispersed(seed, Spread{}, stand(Stand::altitude)), Parameters{});
    ASSERT_TRUE(hopper.fly(request(Program::altitude, 1, 3)));
    EXPECT_TRUE(hopper.out.succeeded);
    EXPECT_NEAR(hopper.log.max_height_m, 1, 0.2);
    EXPECT_LT(hopper.log.max_tilt_rad, 5 * kDegree);
    EXPECT_LT(hopper.log.landing_speed_m_s, 0.5);
  }
}

Gains of_height(double kp_1_s2, double kd_1_s, double ki_1_s3, double rate_m_s) {
  Gains g;
  g.height_kp_1_s2 = kp_1_s2;
  g.height_kd_1_s = kd_1_s;
  g.height_ki_1_s3 = ki_1_s3;
  g.height_rate_m_s = rate_m_s;
  return g;
}
Gains gentle() { return of_height(0.6, 1.2, 0.06, 0.12); }
Gains aggressive() { return of_height(1.6, 2.2, 0.2, 0.3); }

TEST(TalarisFanAltitude, ThirtyCentimetresWithGentleAndAggressiveGainsBetweenRuns) {
  Parameters p;
  p.gain_sets = 2;
  p.gains[0] = gentle();
  p.gains[1] = aggressive();
  double too_high_m[2] = {};
  World world = stand(Stand::height);
  Hopper hopper(world, p);
  for (std::size_t set = 1; set <= 2; ++set) {
    ASSERT_TRUE(hopper.flight.select_gains(set));
    hopper.log = {};
    const double begin = hopper.time_s;
    ASSERT_TRUE(hopper.flight.plan(request(Program::fan_altitude, 0.3, 4)).feasible());
    ASSERT_TRUE(hopper.flight.execute());
    EXPECT_FALSE(hopper.flight.plan({}).feasible());
    hopper.frame();
    EXPECT_FALSE(hopper.flight.select_gains(1));  // not while it flies
    while (!hopper.out.finished && hopper.time_s - begin < 60) hopper.frame();
    too_high_m[set - 1] = hopper.log.max_height_m - 0.3;
    EXPECT_TRUE(hopper.out.succeeded);
    EXPECT_NEAR(hopper.log.max_height_m, 0.3, 0.08);
    EXPECT_LT(hopper.log.landing_speed_m_s, 0.45);
    EXPECT_DOUBLE_EQ(hopper.out.gas_used_s, 0);
  }
  EXPECT_LT(too_high_m[1], 0.8 * too_high_m[0]);  // the aggressive ones control it more closely
}

// Longer than any time after which the ground should have come.
TEST(TalarisFanAltitude, ThreeMetresAreComeDownToTheGround) {
  for (const double rate_m_s : {0.20, 0.40}) {
    Parameters p;
    p.gains[0].height_rate_m_s = rate_m_s;
    Hopper hopper(stand(Stand::height), p);
    ASSERT_TRUE(hopper.fly(request(Program::fan_altitude, 3)));
    std::printf("fan altitude 3 m at %.2f m/s: lands with %.2f m/s\n", rate_m_s,
                hopper.log.landing_speed_m_s);
    EXPECT_TRUE(hopper.out.succeeded);
    EXPECT_TRUE(hopper.log.landed);
    EXPECT_NEAR(hopper.log.max_height_m, 3, 0.2);
    EXPECT_LT(hopper.log.landing_speed_m_s, 0.45);
  }
}

TEST(TalarisParachute, FansAloneTakeItUpAndDownAndHoldPitchAndYaw) {
  Statistics speed, tilt;
  for (unsigned seed = 1; seed <= 50; ++seed) {
    Spread s;
    s.moment_N_m.x() = 0;  // nothing controls the roll
    Hopper hopper(dispersed(seed, s), Parameters{});
    ASSERT_TRUE(hopper.fly(request(Program::parachute, 2))) << seed;
    EXPECT_TRUE(hopper.out.succeeded || hopper.out.shortfall == Shortfall::sideways) << seed;
    EXPECT_DOUBLE_EQ(hopper.out.gas_used_s, 0);
    speed.add(hopper.log.landing_speed_m_s);
    tilt.add(hopper.log.max_tilt_rad / kDegree);
  }
  std::printf("parachute: lands with %.2f..%.2f m/s, tilt up to %.2f deg\n", speed.least,
              speed.most, tilt.most);
  EXPECT_LT(speed.most, 1.0);
  EXPECT_LT(tilt.most, 10);
}

}  // namespace
}  // namespace lss::gnc::talaris::test
