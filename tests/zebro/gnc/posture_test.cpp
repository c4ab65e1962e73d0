// Standing up, lying down, stowing, holding: everything but walking.

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "gnc/zebro/locomotion.h"
#include "tests/zebro/gnc/generators.h"
#include "tests/zebro/gnc/robot.h"

namespace lss::gnc::zebro::test {
namespace {

constexpr double kRest_rad =
    105.7 * kDegree;  // the belly carries from 93.2 deg, the toe rises above the body at 118.1 deg
constexpr double kNear_rad = 0.06;

void expect_all_at(const Robot& robot, double theta_rad) {
  for (std::size_t i = 0; i < kLegs; ++i) {
    EXPECT_NEAR(wrap_rad(robot.theta_rad(i) - theta_rad), 0, kNear_rad) << "leg " << i;
  }
}

void put_all_at(Robot& robot, double theta_rad) {
  for (RobotLeg& leg : robot.legs) leg.theta_rad = theta_rad;
}

TEST(Hold, AsksForNoMovement) {
  Robot robot;
  robot.locomotion.hold(0);
  robot.run(1);
  EXPECT_EQ(robot.locomotion.progress(), Progress::done);
  for (const LegTarget& target : robot.locomotion.targets()) {
    EXPECT_EQ(target.segment, 0U);
    EXPECT_EQ(target.rotation, 0);
  }
}

// [Miss-1]
RC_GTEST_PROP(StandUp, FromAnyUnknownAnglesEndsCalibratedWithAllLegsStraightDown, ()) {
  Robot robot;
  for (RobotLeg& leg : robot.legs) put_anywhere(leg);
  robot.locomotion.stand_up(0);
  RC_ASSERT(robot.succeeds());
  for (std::size_t i = 0; i < kLegs; ++i) {
    RC_ASSERT(robot.legs[i].calibrated);
    RC_ASSERT(std::abs(robot.theta_rad(i)) < kNear_rad);
  }
}

TEST(StandUp, LegsThatWereStowedFindTheirSensorOnTheShortWayBackThroughTheAir) {
  Robot robot;
  put_all_at(robot, kRest_rad);
  for (RobotLeg& leg : robot.legs) {
    leg.calibrated = false;
    leg.zero_rad = -kRest_rad;
  }
  robot.locomotion.stand_up(0);
  for (int frame = 0; frame < 100; ++frame) {
    robot.frame();
    for (std::size_t i = 0; i < kLegs; ++i) EXPECT_GT(std::abs(robot.theta_rad(i)), 90 * kDegree);
  }
  for (const RobotLeg& leg : robot.legs) EXPECT_TRUE(leg.calibrated);
  EXPECT_TRUE(robot.finish());
}

TEST(StandUp, LegsThatDoNotFindItTurnOneTripodAfterTheOther) {
  Robot robot;
  put_all_at(robot, kRest_rad);
  for (RobotLeg& leg : robot.legs) {
    leg.calibrated = leg.has_sensor = false;
    leg.zero_rad = -kRest_rad;
  }
  robot.locomotion.stand_up(0);
  bool first_turned = false, second_turned = false;
  for (int frame = 0; frame < 450; ++frame) {
    robot.frame();
    if (frame < 60) continue;  // all look back together first
    const bool first = robot.legs[0].rate_rad_s != 0, second = robot.legs[1].rate_rad_s != 0;
    EXPECT_FALSE(first && second);
    EXPECT_LE(robot.legs[0].rate_rad_s, 0);  // robot-forward: theta falls
    first_turned |= first;
    second_turned |= second;
  }
  EXPECT_TRUE(first_turned && second_turned);
}

TEST(StandUp, TurnsALegWithoutSensorOnceRoundAndGoesOnWithoutIt) {
  Robot robot;
  put_all_at(robot, kRest_rad);
  robot.legs[2].calibrated = robot.legs[2].has_sensor = false;
  double fell_rad = 0;
  robot.on_order = [&](std::size_t leg, const LegTarget& target, double way_rad) {
    if (leg == 2 && robot.now_s < 5) {
      EXPECT_LT(std::abs(way_rad), 2 * kPi - 0.5);
      if (target.rotation == 1) fell_rad -= way_rad;
    }
  };
  robot.locomotion.stand_up(0);
  ASSERT_TRUE(robot.succeeds());
  EXPECT_GT(fell_rad, 2 * kPi);
  EXPECT_LT(fell_rad, 2.2 * kPi);
  EXPECT_FALSE(robot.legs[2].calibrated);
}

// As after modules were reset in the middle of a walk.
RC_GTEST_PROP(StandUp, FindsLegsThatLostTheirReferenceOnAWalk, ()) {
  Robot robot;
  robot.locomotion.walk(0, {});
  robot.run(*rc::gen::inRange(20, 200) * 0.1);
  robot.locomotion.hold(robot.now_s);
  robot.frame();
  for (RobotLeg& leg : robot.legs) {
    leg.left_rad = 0;
    leg.calibrated = *rc::gen::arbitrary<bool>();
    if (!leg.calibrated) leg.zero_rad = -leg.theta_rad;
  }
  robot.locomotion.stand_up(robot.now_s);
  RC_ASSERT(robot.succeeds());
  for (std::size_t i = 0; i < kLegs; ++i) {
    RC_ASSERT(robot.legs[i].calibrated);
    RC_ASSERT(std::abs(robot.theta_rad(i)) < kNear_rad);
  }
}

RC_GTEST_PROP(StandUp, CalibratedLegsGoThroughTheAirAndThenPushTogether, ()) {
  Robot robot;
  for (RobotLeg& leg : robot.legs) leg.theta_rad = *rc::gen::inRange(101, 297) * kDegree;
  robot.locomotion.stand_up(0);
  bool together = false;
  while (robot.locomotion.progress() == Progress::running || robot.now_s == 0) {
    robot.frame();
    bool all_same = true, any_low = false;
    for (std::size_t i = 0; i < kLegs; ++i) {
      all_same &=
          std::abs(robot.theta_rad(i) - robot.theta_rad(0)) < 2 * robot.parameters.arrived_rad;
      any_low |= std::abs(robot.theta_rad(i)) < 60 * kDegree;
    }
    if (any_low) {
      RC_ASSERT(all_same);  // no leg reaches the ground alone
      together = true;
    }
    RC_ASSERT(robot.now_s < 20);
  }
  RC_ASSERT(together);
}

RC_GTEST_PROP(StandUp, LegsInFrontBackOffTheGroundInsteadOfPassingIt, ()) {
  Robot robot;
  for (RobotLeg& leg : robot.legs) leg.theta_rad = *rc::gen::inRange(45, 105) * kDegree;
  robot.locomotion.stand_up(0);
  robot.run(robot.parameters.lift_s);
  for (const RobotLeg& leg : robot.legs) {
    RC_ASSERT(leg.theta_rad > 40 * kDegree);
    RC_ASSERT(std::abs(leg.theta_rad - kRest_rad) < kNear_rad);
  }
}

TEST(StandUp, PushesForwardInTheTimeAsked) {
  Robot robot;
  put_all_at(robot, kRest_rad);
  robot.locomotion.stand_up(0);
  ASSERT_TRUE(robot.finish());
  EXPECT_NEAR(robot.now_s, robot.parameters.stand_up_s, 0.1);
  EXPECT_NEAR(robot.legs[0].theta_rad, 0,
              1e-6);  // unwrapped: straight down the front, not once round
}

TEST(StandUp, OfAStandingRobotOnlyAligns) {
  Robot robot;
  for (std::size_t i = 0; i < kLegs; ++i)
    robot.legs[i].theta_rad = (i % 2 == 0 ? 19 : -19) * kDegree;
  robot.locomotion.stand_up(0);
  double highest_rad = 0;
  while (robot.locomotion.progress() == Progress::running || robot.now_s == 0) {
    robot.frame();
    for (const RobotLeg& leg : robot.legs) {
      highest_rad = std::max(highest_rad, std::abs(leg.theta_rad));
    }
    ASSERT_LT(robot.now_s, 20);
  }
  EXPECT_LT(highest_rad, 20 * kDegree);
  expect_all_at(robot, 0);
  EXPECT_NEAR(robot.now_s, robot.parameters.align_s, 0.1);
}

TEST(StandUp, WithThreeLegsLeftInTheAirBringsThemDownInsteadOfDroppingTheBody) {
  Robot robot;
  for (const std::size_t flying : {1U, 2U, 5U}) robot.legs[flying].theta_rad = 150 * kDegree;
  robot.locomotion.stand_up(0);
  while (robot.locomotion.progress() == Progress::running || robot.now_s == 0) {
    robot.frame();
    for (const std::size_t standing : {0U, 3U, 4U}) {
      ASSERT_LT(std::abs(robot.theta_rad(standing)), 20 * kDegree);
    }
    ASSERT_LT(robot.now_s, 20);
  }
  expect_all_at(robot, 0);
}

TEST(LayDown, FromStandingRollsBackUntilTheBellyCarries) {
  Robot robot;
  robot.locomotion.lay_down(0);
  ASSERT_TRUE(robot.succeeds());
  expect_all_at(robot, kRest_rad);
  EXPECT_GT(robot.legs[0].theta_rad, 0);  // backward, by the shortest way
  EXPECT_NEAR(robot.now_s, robot.parameters.lay_down_s, 0.1);
}

TEST(LayDown, OfALyingRobotIsDoneAtOnce) {
  Robot robot;
  put_all_at(robot, kRest_rad);
  robot.locomotion.lay_down(0);
  robot.frame();
  EXPECT_EQ(robot.locomotion.progress(), Progress::done);
  for (const LegTarget& target : robot.locomotion.targets()) EXPECT_EQ(target.segment, 0U);
}

RC_GTEST_PROP(LayDown, FromUnknownAnglesFindsThemFirst, ()) {
  Robot robot;
  for (RobotLeg& leg : robot.legs) {
    leg.theta_rad = *rc::gen::inRange(-180, 180) * kDegree;
    leg.zero_rad = *rc::gen::inRange(-180, 180) * kDegree;
    leg.calibrated = false;
  }
  robot.locomotion.lay_down(0);
  RC_ASSERT(robot.succeeds());
  for (std::size_t i = 0; i < kLegs; ++i) {
    RC_ASSERT(std::abs(robot.theta_rad(i) - kRest_rad) < kNear_rad);
  }
}

TEST(LayDown, DoesNotSpinLegsThatLostTheirReferenceWhileItStandsOnThem) {
  Robot robot;
  robot.locomotion.stand_up(0);
  ASSERT_TRUE(robot.finish());
  for (const std::size_t left : {0U, 2U, 4U}) {
    robot.legs[left].calibrated = robot.legs[left].has_sensor = false;
  }
  robot.locomotion.lay_down(robot.now_s);
  ASSERT_TRUE(robot.finish());
  expect_all_at(robot, kRest_rad);
  for (const RobotLeg& leg : robot.legs) EXPECT_LT(std::abs(leg.theta_rad), 110 * kDegree);
}

// The storage plates are level with the top and the bottom of the body (Zebro thesis 3.2 [Miss-2]);
// the hips are halfway between them.
TEST(Stow, Miss_2_LegsReachBeyondNeitherTheTopNorTheBottomOfTheBody) {
  Robot robot;
  robot.locomotion.stow(0);
  ASSERT_TRUE(robot.succeeds());
  const LocomotionParameters& p = robot.parameters;
  for (const RobotLeg& leg : robot.legs) {
    EXPECT_LT(hip_height_m(leg.theta_rad, p.leg_diameter_m), p.belly_height_m);
    EXPECT_LT(-p.leg_diameter_m * std::cos(leg.theta_rad), p.belly_height_m);  // the toe, upwards
  }
}

bool stands_up_with_late_leg(Robot& robot, double stuck_until_s) {
  put_all_at(robot, kRest_rad);
  robot.legs[3].stuck_until_s = stuck_until_s;
  robot.locomotion.stand_up(0);
  return robot.finish();
}

TEST(Posture, LateLegFailsTheMotionAfterTheLateLimit) {
  Robot robot;
  ASSERT_TRUE(stands_up_with_late_leg(robot, 1e9));
  EXPECT_EQ(robot.locomotion.progress(), Progress::failed);
  EXPECT_NEAR(robot.now_s, robot.parameters.stand_up_s + robot.parameters.late_limit_s, 0.1);
}

TEST(Posture, LateLegDelaysTheMotionUntilItArrives) {
  Robot robot;
  ASSERT_TRUE(stands_up_with_late_leg(robot, 5));
  EXPECT_EQ(robot.locomotion.progress(), Progress::done);
  EXPECT_GT(robot.now_s, 5);
  expect_all_at(robot, 0);
}

TEST(Posture, LegThatReportsNoAngleIsGivenItsTime) {
  Robot robot;
  put_all_at(robot, kRest_rad);
  robot.legs[0].answers = false;
  robot.locomotion.stand_up(0);
  ASSERT_TRUE(robot.succeeds());
}

TEST(Posture, NaNFromALegIsNotAnAngle) {
  Robot robot;
  put_all_at(robot, std::numeric_limits<double>::quiet_NaN());
  robot.locomotion.stand_up(0);
  robot.frame();
  for (const LegTarget& target : robot.locomotion.targets()) {
    EXPECT_TRUE(std::isfinite(target.angle_rad));
    EXPECT_TRUE(std::isfinite(target.arrive_s));
  }
  EXPECT_TRUE(std::isfinite(robot.locomotion.distance_m()));
}

TEST(Odometry, StandingUpRollsAheadAndLyingDownRollsBack) {
  Robot robot;
  put_all_at(robot, kRest_rad);
  robot.locomotion.stand_up(0);
  ASSERT_TRUE(robot.finish());
  const double ahead_m = robot.locomotion.distance_m();
  EXPECT_NEAR(ahead_m, -advance_m(93.2 * kDegree, 0.053), 1e-3);
  robot.locomotion.lay_down(robot.now_s);
  ASSERT_TRUE(robot.finish());
  EXPECT_NEAR(robot.locomotion.distance_m(), 0, 1e-3);
}

// The centre of mass.
void move_ahead(LocomotionParameters& p, double by_m) {
  for (double& x_m : p.hips.x_m) x_m -= by_m;
}

struct Unusable {
  const char* what;
  void (*spoil)(LocomotionParameters&);
  const char* says;
};

TEST(Check, NamesWhatIsWrong) {
  EXPECT_EQ(check({}), nullptr);
  const Unusable cases[] = {
      {"not synchronised", [](auto& p) { p.stance_min_s = 4; }, "7 s exceeds 2"},
      {"not synchronised", [](auto& p) { p.stance_min_s = 4; }, "= 6.6 s"},
      {"swing too fast", [](auto& p) { p.swing_limit_rad_s = 2; }, "a full turn in flight_s"},
      {"stance too fast", [](auto& p) { p.stance_min_s = 0.1; }, "the sweep in stance_min_s"},
      {"push too fast", [](auto& p) { p.stand_up_s = 0.5; }, "standing up"},
      {"lower too fast", [](auto& p) { p.lay_down_s = 0.5; }, "lying down"},
      {"NaN", [](auto& p) { p.sweep_rad = std::nan(""); }, "sweep_rad"},
      {"belly too high", [](auto& p) { p.belly_height_m = 0.06; }, "belly_height_m"},
      {"sweep too wide", [](auto& p) { p.sweep_rad = 2.4; }, "belly touches"},
      {"stance too long to order", [](auto& p) { p.double_stance_s = 12; },
       "longer than a leg module can count"},
      {"it would fall ahead", [](auto& p) { move_ahead(p, 0.03); },
       "in gait tripod the centre of mass is -"},
      {"at the edge of its feet", [](auto& p) { move_ahead(p, 0.026); },
       "in gait tetrapod-B the centre of mass is 1.3"},
  };
  for (const Unusable& c : cases) {
    LocomotionParameters p;
    c.spoil(p);
    const char* wrong = check(p);
    ASSERT_NE(wrong, nullptr) << c.what;
    EXPECT_NE(std::string(wrong).find(c.says), std::string::npos) << wrong;
  }
  LocomotionParameters inside;
  move_ahead(inside, 0.024);
  EXPECT_EQ(check(inside), nullptr);
}

}  // namespace
}  // namespace lss::gnc::zebro::test
