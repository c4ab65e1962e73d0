#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <map>

#include "gnc/zebro/locomotion.h"
#include "tests/zebro/gnc/generators.h"
#include "tests/zebro/gnc/robot.h"

namespace lss::gnc::zebro::test {
namespace {

// [Func-4]
TEST(Walk, SpeedsAreThoseOfTheGaitTable) {
  for (const Pace& pace : kPaces) {
    Robot robot;
    robot.locomotion.walk(0, {.direction = 1, .heading_rad = 0, .speed = pace.speed});
    const double speed_m_s = two_cycles_m(robot, pace.cycle_s) / (2 * pace.cycle_s);
    EXPECT_NEAR(speed_m_s, pace.speed_m_s, 0.05e-3 + 0.005 * pace.speed_m_s);
    EXPECT_NEAR(robot.locomotion.yaw_rad(), 0, 2e-3);
    EXPECT_EQ(robot.locomotion.steps(), 4U);
  }
}

// [Func-3]
TEST(Walk, BackwardIsAsFastTheOtherWay) {
  for (const Pace& pace : kPaces) {
    Robot robot;
    robot.locomotion.walk(0, {.direction = -1, .heading_rad = 0, .speed = pace.speed});
    const double speed_m_s = two_cycles_m(robot, pace.cycle_s) / (2 * pace.cycle_s);
    EXPECT_NEAR(speed_m_s, -pace.speed_m_s, 0.05e-3 + 0.005 * pace.speed_m_s);
  }
}

// [Func-3]
TEST(Walk, HeadingNinetyDegreesTurnsClockwiseOnTheSpot) {
  Robot robot;
  robot.locomotion.walk(0, {.direction = 1, .heading_rad = kPi / 2, .speed = Speed::high});
  robot.run(2 * 6.6);
  const double from_rad = robot.locomotion.yaw_rad();
  robot.run(2 * 6.6);
  EXPECT_NEAR(robot.locomotion.yaw_rad() - from_rad, 2 * 6.6 * 2 * 10.1e-3 / 0.130, 0.02);
  EXPECT_NEAR(robot.locomotion.distance_m(), 0, 1e-3);
}

TEST(Walk, HeadingFortyFiveDegreesPivotsAboutTheStandingSide) {
  Robot robot;
  robot.locomotion.walk(0, {.direction = 1, .heading_rad = kPi / 4, .speed = Speed::medium});
  std::map<std::size_t, double> turned_rad;
  robot.on_order = [&](std::size_t leg, const LegTarget& target, double way_rad) {
    EXPECT_LT(std::abs(way_rad), 2 * kPi - 0.3);  // no order of a whole turn
    if (target.swing) turned_rad[leg] += way_rad;
  };
  robot.run(30.6);
  EXPECT_GT(robot.locomotion.distance_m(), 0);
  EXPECT_GT(robot.locomotion.yaw_rad(), 0);
  for (const std::size_t right : {1U, 3U, 5U}) {
    EXPECT_NEAR(std::remainder(turned_rad[right], kPi), 0, 0.05);
    EXPECT_LT(turned_rad[right], -3.9 * kPi);  // and really went round
    if (!robot.locomotion.targets()[right].swing) {
      EXPECT_NEAR(robot.theta_rad(right), 0, 0.02);
    }
  }
}

TEST(Walk, OneSegmentPerEventInTheSteadyRhythm) {
  for (const Pace& pace : kPaces) {
    Robot robot;
    int orders = 0;
    robot.locomotion.walk(0, {.direction = 1, .heading_rad = 0.2, .speed = pace.speed});
    robot.run(2 * pace.cycle_s + 1);
    robot.on_order = [&](std::size_t, const LegTarget&, double) { ++orders; };
    robot.run(3 * pace.cycle_s);
    EXPECT_EQ(orders, 3 * 2 * kLegs);
  }
}

TEST(Walk, NoLegOnTheGroundIsOrderedThroughTheTop) {
  for (const double double_stance_s : {0.3, 0.0}) {
    for (const Speed speed : {Speed::low, Speed::medium, Speed::high}) {
      for (int heading = -90; heading <= 90; ++heading) {
        Robot robot({.stance_min_s = 2.9, .double_stance_s = double_stance_s});
        robot.on_order = [&](std::size_t i, const LegTarget& target, double way_rad) {
          if (target.swing) return;
          EXPECT_LT(std::abs(way_rad), kPi / 2) << "heading " << heading << " leg " << i;
        };
        robot.locomotion.walk(0, {.heading_rad = heading * kDegree, .speed = speed});
        robot.run(12);
      }
    }
  }
}

TEST(Walk, FirstLiftOffComesAfterTheStartDelay) {
  Robot robot;
  robot.locomotion.walk(0, {});
  double first_s = 0;
  robot.on_order = [&](std::size_t, const LegTarget& target, double) {
    if (target.swing && first_s == 0) first_s = robot.now_s;
  };
  robot.run(3);
  EXPECT_NEAR(first_s, robot.parameters.start_delay_s, 1.5 * kFrame_s);
}

// In the steady rhythm each segment begins where the one before it ended: the reference is one
// continuous curve.
RC_GTEST_PROP(Walk, ReferenceIsContinuousAndWithinTheRateLimit, ()) {
  Robot robot;
  const WalkRequest request = *any_walk();
  PerLeg<LegTarget> before{};
  PerLeg<double> began_s{};
  bool started = false;
  robot.on_order = [&](std::size_t i, const LegTarget& target, double way_rad) {
    if (started && before[i].rotation != 0) {
      // It was there, in the time it was given, when the next movement began.
      RC_ASSERT(std::abs(wrap_rad(robot.legs[i].theta_rad - before[i].angle_rad)) <
                robot.parameters.swing_limit_rad_s * 2 * kFrame_s);
      RC_ASSERT(robot.now_s >= before[i].arrive_s - 2 * kFrame_s);
    }
    const double rate_rad_s = std::abs(way_rad) / (target.arrive_s - robot.now_s);
    RC_ASSERT(rate_rad_s <= robot.parameters.swing_limit_rad_s * (1 + 1e-9));
    RC_ASSERT(target.angle_rad > -kPi);
    RC_ASSERT(target.angle_rad <= kPi);
    before[i] = target;
    began_s[i] = robot.now_s;
  };
  robot.locomotion.walk(0, request);
  robot.run(1);
  started = true;
  robot.run(3 * cycle_s(request.speed));
  RC_ASSERT(robot.locomotion.progress() == Progress::running);
}

TEST(Walk, LegThatPassesItsSensorOnTheWayIsOrderedAgainFromItsTrueAngle) {
  Robot robot;
  robot.legs[3].calibrated = robot.legs[3].has_sensor = false;
  robot.locomotion.stand_up(0);
  ASSERT_TRUE(robot.finish());
  // It stands 50 deg off its own count, and its sensor works again.
  robot.legs[3].zero_rad -= 50 * kDegree;
  robot.legs[3].theta_rad += 50 * kDegree;
  robot.legs[3].has_sensor = true;
  robot.locomotion.walk(robot.now_s, {.direction = 1, .heading_rad = 0, .speed = Speed::high});
  robot.run(2 * 6.6);
  EXPECT_TRUE(robot.legs[3].calibrated);
  EXPECT_EQ(robot.locomotion.progress(), Progress::running);
  for (int frame = 0; frame < 330; ++frame) {
    robot.frame();
    if (robot.locomotion.targets()[3].swing) continue;
    EXPECT_LT(std::abs(robot.theta_rad(3)), 24 * kDegree);
  }
}

// As real modules do: reports 40 ms old, and 5000 rpm at the gear is 117 deg/s (Zebro thesis
// A.2.3), less than a leg that steps on the spot needs.
TEST(Walk, KeepsWalkingOnSlowLegsWithOldReports) {
  for (const double heading_deg : {0.0, 45.0, 90.0}) {
    for (const Pace& pace : kPaces) {
      Robot robot;
      robot.fastest_rad_s = 117.2 * kDegree;
      robot.report_age_frames = 2;
      robot.locomotion.walk(
          0, {.direction = 1, .heading_rad = heading_deg * kDegree, .speed = pace.speed});
      robot.run(6 * pace.cycle_s);
      EXPECT_EQ(robot.locomotion.progress(), Progress::running);
      EXPECT_GE(robot.locomotion.steps(), 5U);
      if (heading_deg == 0) {
        const double from_m = robot.locomotion.distance_m();
        robot.run(5 * pace.cycle_s);
        EXPECT_NEAR((robot.locomotion.distance_m() - from_m) / (5 * pace.cycle_s), pace.speed_m_s,
                    0.04 * pace.speed_m_s);
      }
    }
  }
}

TEST(Odometry, LegThatIsHeardAgainDoesNotMoveTheBody) {
  Robot robot;
  robot.locomotion.walk(0, {.direction = 1, .heading_rad = 0, .speed = Speed::high});
  robot.run(4 * 6.6 + 0.5 + 3.3);
  ASSERT_FALSE(robot.locomotion.targets()[0].swing);
  robot.legs[0].answers = false;
  robot.legs[0].stuck_until_s = robot.now_s + 2;
  robot.run(1.5);
  robot.legs[0].answers = true;
  const double before_m = robot.locomotion.distance_m();
  robot.frame();
  EXPECT_NEAR(robot.locomotion.distance_m(), before_m, 0.4e-3);
}

TEST(Walk, SurvivesAGapInTimeWithOrdersThatCanBeFollowed) {
  Robot robot;
  robot.locomotion.walk(0, {.direction = 1, .heading_rad = 42 * kDegree, .speed = Speed::high});
  robot.run(8);
  for (const double gap_s : {0.1, 0.7, 2.0, 4.0}) {
    robot.now_s += gap_s;
    robot.on_order = [&](std::size_t, const LegTarget& target, double way_rad) {
      EXPECT_GT(target.arrive_s, robot.now_s + 1.5 * kFrame_s);
      EXPECT_LE(std::abs(way_rad) / (target.arrive_s - robot.now_s),
                robot.parameters.swing_limit_rad_s * 1.0001);
    };
    robot.run(15);
    EXPECT_EQ(robot.locomotion.progress(), Progress::running);
  }
}

TEST(Walk, AfterAGapInTimeTheLegsLiftOffInTheirOrder) {
  for (int frames = 0; frames < 990; frames += 10) {  // one cycle
    Robot robot;
    robot.locomotion.walk(0, {.speed = Speed::low});
    robot.run(20 + frames * kFrame_s);
    for (double gap_s = 7; gap_s > 0; gap_s -= kFrame_s) {  // the legs go on
      robot.turn_legs();
      robot.now_s += kFrame_s;
    }
    for (int frame = 0; frame < 150; ++frame) {
      robot.frame();
      ASSERT_LE(robot.flying(), 1);
    }
  }
}

}  // namespace
}  // namespace lss::gnc::zebro::test
