// The full hop: up 2 m, 30 m level, down, six degrees of freedom. Cold gas 58 N.

#include <gtest/gtest.h>

#include <cstdio>

#include "tests/talaris/gnc/dispersed.h"

namespace lss::gnc::talaris::test {
namespace {

void show(const char* what, const Statistics& s) {
  std::printf("  %-28s %8.3f %8.3f %8.3f\n", what, s.least, s.mean(), s.most);
}

TEST(TalarisHop, ThirtyMetresWithinTheCheckedFigures) {
  for (unsigned seed = 1; seed <= 3; ++seed) {
    World world;
    world.seed = seed;
    Hopper hopper(world, Parameters{});
    ASSERT_TRUE(hopper.fly({}));
    EXPECT_TRUE(hopper.out.succeeded);
    EXPECT_TRUE(hopper.log.landed);
    EXPECT_LE(hopper.log.max_height_error_m, 0.35);
    EXPECT_LE(hopper.log.rms_height_m(), 0.10);
    EXPECT_LE(hopper.log.max_tilt_rad, 4.1 * kDegree);
    EXPECT_LE(hopper.log.max_roll_error_rad, 4.1 * kDegree);
    EXPECT_NEAR(hopper.position.z(), 30, 1.5);
    EXPECT_NEAR(hopper.position.y(), 0, 1.0);
    EXPECT_LT(hopper.log.landing_speed_m_s, 0.4);
    EXPECT_LT(hopper.log.landing_tilt_rad, 2 * kDegree);
    EXPECT_LT(hopper.out.gas_used_s, 36);
    EXPECT_GT(hopper.out.gas_used_s, 28);
    // reckoned beforehand, and not too little
    EXPECT_NEAR(hopper.out.gas_used_s, hopper.flight.planned().gas_s, 5);
    EXPECT_LE(hopper.out.gas_used_s, hopper.flight.planned().gas_s);
  }
}

TEST(TalarisHop, TheOffsetOfTheThesisIsFlownAsWell) {
  Parameters p;
  p.offset_s = 0.050;
  Hopper hopper(World{}, p);
  ASSERT_TRUE(hopper.fly({}));
  EXPECT_TRUE(hopper.out.succeeded);
  EXPECT_LE(hopper.log.max_tilt_rad, 4.1 * kDegree);
  EXPECT_NEAR(hopper.position.z(), 30, 1.5);
}

TEST(TalarisHop, ATurnInTheHoverComesBeforeTheTraverse) {
  PlanRequest request;
  request.distance_m = 5;
  request.turn_rad = 90 * kDegree;
  Hopper hopper(World{}, Parameters{});
  ASSERT_TRUE(hopper.fly(request));
  EXPECT_TRUE(hopper.out.succeeded);
  EXPECT_NEAR(hopper.position.y(), -5, 1);  // +z turned by 90 deg about x is -y
  EXPECT_NEAR(hopper.position.z(), 0, 1);
  EXPECT_NEAR(attitude_of(hopper.q_NB).roll_rad, 90 * kDegree, 5 * kDegree);
}

// On a slope it slides and turns on its legs while the fans already carry it: the operator's target
// is where it was, not as far from where it lifts off.
TEST(TalarisHop, SlidingBeforeLiftOffDoesNotMoveTheTarget) {
  Hopper hopper(World{}, Parameters{});
  ASSERT_TRUE(hopper.flight.plan({}).feasible());
  ASSERT_TRUE(hopper.flight.execute());
  hopper.frame();
  ASSERT_EQ(hopper.out.phase, Phase::spin_up);
  hopper.position += Vector3(0, 0.7, -0.3);
  hopper.q_NB = Quaternion(Eigen::AngleAxisd(8 * kDegree, Vector3::UnitX()));
  ASSERT_TRUE(hopper.run(60));
  EXPECT_TRUE(hopper.out.succeeded);
  EXPECT_NEAR(hopper.position.y(), 0, 1);
  EXPECT_NEAR(hopper.position.z(), 30, 1.5);
  EXPECT_NEAR(attitude_of(hopper.q_NB).roll_rad, 0, 4 * kDegree);
}

TEST(TalarisHop, AWeakerVehicleHopsLessFar) {
  World world;
  world.force_N.fill(40);
  Parameters p;
  p.thrusters.force_N = 40;
  Hopper hopper(world, p);
  EXPECT_FALSE(hopper.flight.plan({}).feasible());
  EXPECT_FALSE(hopper.flight.execute());
  PlanRequest request;
  request.distance_m = 5;
  ASSERT_TRUE(hopper.fly(request));
  EXPECT_TRUE(hopper.out.succeeded);
  EXPECT_NEAR(hopper.position.z(), 5, 1.0);
}

// Without the trim of the fans it stays up: the shortest pulses of four valves lift more than these
// fans leave of it.
TEST(TalarisHop, AVehicleThatIsLightForItsFansComesDown) {
  World world;
  world.mass_kg = 43.9;
  world.fan_scale = 1.03;
  Hopper hopper(world, Parameters{});
  ASSERT_TRUE(hopper.fly({}));
  EXPECT_TRUE(hopper.out.succeeded);
  EXPECT_LT(hopper.log.max_height_m, 6) << "until the trim has seen it";
  EXPECT_LT(hopper.log.landing_speed_m_s, 0.7);
  EXPECT_LT(hopper.out.gas_used_s, 41);
}

// Braked by 1.3 m/s2 it wants 15 N of the valves, whose shortest pulses push with 46 N: the fans
// have to give way, or it rises too high.
TEST(TalarisHop, AQuickClimbEndsAtItsHeight) {
  Parameters p;
  p.profile.climb_m_s2 = 1.3;
  p.profile.hover_s = 0.2;
  PlanRequest request;
  request.distance_m = 5;
  for (unsigned seed = 1; seed <= 12; ++seed) {
    Hopper hopper(dispersed(seed, Spread{}), p);
    ASSERT_TRUE(hopper.fly(request));
    EXPECT_TRUE(hopper.out.succeeded);
    EXPECT_NEAR(hopper.log.max_height_m, request.height_m, 0.05 * request.height_m) << seed;
  }
}

// Mass +-1 %, inertia +-20 %, thrust +-5 % (+-2 % from jet to jet), fans +-1 %, moments up to 0.5 N
// m, navigation drifting by up to 0.01 m/s2.
TEST(TalarisHop, TwoHundredDispersedHopsSucceed) {
  Statistics speed, tilt, landing_tilt, height, gas, z, y, drift;
  int succeeded = 0;
  for (unsigned seed = 1; seed <= 200; ++seed) {
    Hopper hopper(dispersed(seed, Spread{}), Parameters{});
    hopper.fly({});
    succeeded += hopper.out.succeeded && hopper.log.landed ? 1 : 0;
    speed.add(hopper.log.landing_speed_m_s);
    tilt.add(hopper.log.max_tilt_rad / kDegree);
    landing_tilt.add(hopper.log.landing_tilt_rad / kDegree);
    height.add(hopper.log.max_height_error_m);
    gas.add(hopper.out.gas_used_s);
    z.add(hopper.position.z());
    y.add(hopper.position.y());
    drift.add(hopper.log.landing_drift_m_s);
  }
  std::printf("200 dispersed hops, %d succeeded: least, mean, greatest\n", succeeded);
  show("landing speed, m/s", speed);
  show("tilt in flight, deg", tilt);
  show("tilt at landing, deg", landing_tilt);
  show("sideways at landing, m/s", drift);
  show("height error, m", height);
  show("gas, thruster-seconds", gas);
  show("z at the end, m", z);
  show("y at the end, m", y);
  EXPECT_EQ(succeeded, 200);
  EXPECT_LT(speed.most, 0.7);
  EXPECT_LT(tilt.most, 6);
  EXPECT_LT(landing_tilt.most, 3);
  EXPECT_LT(drift.most, 0.6);
  EXPECT_LT(height.most, 0.4);
  EXPECT_LT(gas.most, 41);
}

}  // namespace
}  // namespace lss::gnc::talaris::test
