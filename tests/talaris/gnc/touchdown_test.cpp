// Witnesses of the ground, and the corridor.

#include "gnc/talaris/touchdown.h"

#include <gtest/gtest.h>

#include "gnc/talaris/corridor.h"
#include "gnc/talaris/flight.h"

namespace lss::gnc::talaris::test {
namespace {

NavState state(double up_m_s2 = 0, double turned_rad = 0) {
  NavState s;
  s.valid = true;
  s.acceleration_N_m_s2.x() = up_m_s2;
  s.q_NB = Quaternion(Eigen::AngleAxisd(turned_rad, Vector3::UnitX()));
  return s;
}

TEST(Touchdown, LiftThatIsTakenAwayAndNotMissedIsCarriedByTheGround) {
  Touchdown t;
  for (int i = 0; i < 3; ++i) t.step(state(), true, 0.1);
  for (const double expected : {0.0, -0.1, -0.2, -0.25}) t.step(state(0.02), true, expected);
  EXPECT_TRUE(t.supported());
}

TEST(Touchdown, AnErrorOfMassOrThrustAloneIsNot) {
  Touchdown t;
  for (int i = 0; i < 100; ++i) t.step(state(), true, -0.6 + 0.05 * (i % 2));
  EXPECT_FALSE(t.supported());
}

TEST(Touchdown, LiftThatIsFollowedIsNot) {
  Touchdown t;
  for (int i = 0; i < 40; ++i) {
    const double expected = i % 8 < 4 ? 0.0 : -0.4;
    t.step(state(expected), true, expected);
    EXPECT_FALSE(t.supported());
  }
}

// After a long hover, when the lift swings, it comes down slowly.
TEST(Touchdown, AGentleDescentAfterALongHoverIsNot) {
  Touchdown t;
  for (int i = 0; i < 40; ++i) {
    const double expected = i % 4 < 2 ? 0.2 : -0.2;
    t.step(state(0.5 * expected), true, expected);
  }
  for (int i = 0; i < 10; ++i) {
    t.step(state(-0.1), true, -0.1);
    EXPECT_FALSE(t.supported());
  }
}

TEST(Touchdown, WhatTiltsFliesAndWhatTurnsDoesNotStand) {
  Touchdown tilts, turns;
  for (int i = 0; i < 30; ++i) {
    NavState s = state();
    s.q_NB = Quaternion(Eigen::AngleAxisd(0.01 * i, Vector3::UnitY()));
    tilts.step(s, true, -0.1 * i);
    turns.step(state(0, 0.01 * i), true, 0);
  }
  EXPECT_FALSE(tilts.supported());
  EXPECT_FALSE(turns.stands());
}

TEST(Touchdown, LightOnItsLegsItMaySlideAndTurn) {
  Touchdown t;
  for (int i = 0; i < 6; ++i) {
    NavState s = state(0, 0.02 * i);
    s.acceleration_N_m_s2.z() = 0.5;
    t.step(s, true, -0.1 * i);
  }
  EXPECT_TRUE(t.supported());
}

TEST(Touchdown, WhatIsStillForThreeSecondsStandsUnlessTheImuIsSilent) {
  Touchdown heard, silent;
  for (int i = 0; i < 16; ++i) {
    heard.step(state(), true, 0);
    silent.step(state(), i % 5 != 0, 0);
  }
  EXPECT_TRUE(heard.stands());
  EXPECT_FALSE(silent.stands());
}

TEST(Touchdown, NoNumberIsNoWitness) {
  Touchdown t;
  for (int i = 0; i < 30; ++i) t.step(state(kNaN), true, -0.1 * i);
  for (int i = 0; i < 30; ++i) t.step(state(), true, kNaN);
  EXPECT_FALSE(t.supported() || t.stands());
}

class CorridorTest : public testing::Test {
 protected:
  CorridorTest() { corridor.begin(Vector3::Zero(), {0, 0, 30}, 10); }
  Judgement judge(double tilt_rad = 0, double flown_s = 10, double wind_m_s2 = 0) const {
    return corridor.judge(at, tilt_rad, flown_s, 20, wind_m_s2, limits);
  }
  // On the plan, after so many frames.
  void pass(int frames) {
    for (int i = 0; i < frames; ++i) corridor.step();
    at.position_N_m = corridor.place_N_m();
    at.velocity_N_m_s = corridor.speed_N_m_s();
  }
  Corridor corridor;
  NavState at;
  Limits limits;
};

TEST_F(CorridorTest, ThePlanIsMinimumEffortBetweenStandstills) {
  pass(25);
  EXPECT_NEAR(corridor.place_N_m().z(), 15, 1e-9);
  EXPECT_NEAR(corridor.speed_N_m_s().z(), 4.5, 1e-9);
  pass(50);
  EXPECT_NEAR(corridor.place_N_m().z(), 30, 1e-9);
  EXPECT_EQ(corridor.speed_N_m_s().norm(), 0);
}

TEST_F(CorridorTest, OnThePlanNothingIsWrong) {
  pass(20);
  EXPECT_EQ(judge().off, Off::none);
  EXPECT_FALSE(judge().wavers);
  EXPECT_TRUE(judge().back);
}

// Just below and just above each limit.
TEST_F(CorridorTest, EachLimitIsWhereItShouldBe) {
  pass(20);
  const NavState planned = at;
  const auto moved = [&](const Vector3& place_m, const Vector3& speed_m_s) {
    at = planned;
    at.position_N_m += place_m;
    at.velocity_N_m_s += speed_m_s;
    return judge().off;
  };
  EXPECT_EQ(moved({0, 7.99, 0}, Vector3::Zero()), Off::none);
  EXPECT_EQ(moved({0, 8.01, 0}, Vector3::Zero()), Off::side);
  EXPECT_EQ(moved({0, 0, -8.01}, Vector3::Zero()), Off::side);
  EXPECT_EQ(moved({-1.79, 0, 0}, Vector3::Zero()), Off::none);
  EXPECT_EQ(moved({-1.81, 0, 0}, Vector3::Zero()), Off::height);
  EXPECT_EQ(moved(Vector3::Zero(), {0, 2.49, 0}), Off::none);
  EXPECT_EQ(moved(Vector3::Zero(), {0, 2.51, 0}), Off::speed);
  at = planned;
  EXPECT_EQ(judge(0.99 * limits.corridor_tilt_rad).off, Off::none);
  EXPECT_EQ(judge(1.01 * limits.corridor_tilt_rad).off, Off::tilt);
  EXPECT_EQ(judge(0, 20 + 14.9).off, Off::none);
  EXPECT_EQ(judge(0, 20 + 15.1).off, Off::late);
  EXPECT_EQ(judge(0, 10, 1.29).off, Off::none);
  EXPECT_EQ(judge(0, 10, 1.31).off, Off::wind);
}

TEST_F(CorridorTest, WhatNavigationCannotExcludeCounts) {
  pass(20);
  at.position_N_m.y() += 5;
  at.position_sigma_m = {0, 1.4, 1};
  EXPECT_EQ(judge().off, Off::none);
  at.position_sigma_m = {0, 1.6, 1};
  const Judgement out = judge();
  EXPECT_EQ(out.off, Off::side);
  EXPECT_NEAR(out.measured, 5 + 3.2, 1e-9);
  EXPECT_EQ(out.limit, 8);
}

// After a gap of the IMU anything is possible; the flight goes on, and its end is judged by all of
// it.
TEST_F(CorridorTest, UncertaintyAloneEndsNoFlight) {
  pass(20);
  at.position_sigma_m = {5, 50, 50};
  at.velocity_sigma_m_s = {5, 5, 5};
  at.attitude_sigma_rad = {0.3, 0.3, 0.3};
  EXPECT_EQ(judge().off, Off::none);
  at.position_N_m.y() += 4.1;
  EXPECT_EQ(judge().off, Off::side);
}

// A hold at 4 m/s is no speed off the plan.
TEST_F(CorridorTest, APlanThatStopsSlowsDownEvenly) {
  pass(20);
  const NavState before = at;
  corridor.stop(at.position_N_m, {0, 0, 4}, 2);
  EXPECT_EQ(corridor.speed_N_m_s().z(), 4);
  at.velocity_N_m_s = {0, 0, 4};
  EXPECT_EQ(judge().off, Off::none);
  pass(5);
  EXPECT_NEAR(corridor.speed_N_m_s().z(), 2, 1e-9);
  EXPECT_NEAR(corridor.place_N_m().z(), before.position_N_m.z() + 3, 1e-9);
  pass(20);
  EXPECT_NEAR(corridor.place_N_m().z(), before.position_N_m.z() + 4, 1e-9);
  EXPECT_EQ(corridor.speed_N_m_s().norm(), 0);
}

TEST(Reactions, OfTheCorridorAreMilderThanThoseOfLosses) {
  EXPECT_EQ(react(kOffTrack, true, true, true), Reaction::hold);
  EXPECT_EQ(react(kGasShort, true, true, true), Reaction::shorten);
  EXPECT_EQ(react(kGasShort | kOffCourse, true, true, true), Reaction::land);
  EXPECT_EQ(react(kOffCourse | kGasLow, true, true, true), Reaction::escape);
  EXPECT_EQ(react(kRunTime, true, true, true), Reaction::escape);
  EXPECT_EQ(react(kRunTime | kOverTime, true, true, true), Reaction::parachute);
}

}  // namespace
}  // namespace lss::gnc::talaris::test
