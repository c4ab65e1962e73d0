// Every motion with legs out of service: dead where they hang.

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "gnc/zebro/fewer_legs.h"
#include "gnc/zebro/locomotion.h"
#include "tests/support/allocations.h"
#include "tests/zebro/gnc/crippled.h"

namespace lss::gnc::zebro::test {
namespace {

// Flying at most as many legs as the largest group; never a margin below zero; nothing for the
// dead.
void watch_walking(Crippled& robot, double duration_s) {
  const double until_s = robot.now_s + duration_s;
  const int most_flying = std::popcount(robot.isolated) == 2 ? 1 : 2;
  while (robot.now_s < until_s) {
    robot.frame();
    RC_ASSERT(robot.flying() <= most_flying);
    RC_ASSERT(robot.margin_m() > 0);
    RC_ASSERT(!robot.ordered);
    for (std::size_t i = 0; i < kLegs; ++i) {
      if (!robot.dead(i)) continue;
      RC_ASSERT(robot.locomotion.targets()[i].segment == 0U);
      RC_ASSERT(robot.locomotion.targets()[i].rotation == 0);
      RC_ASSERT(!robot.locomotion.targets()[i].swing);
    }
  }
}

RC_GTEST_PROP(IsolatedLegs, WalkingStaysStableThroughAnyChangesAndNeverOrdersADeadLeg, ()) {
  Crippled robot(*rc::gen::elementOf(creeping()), *rc::gen::inRange(-180, 180) * kDegree);
  robot.locomotion.walk(0, *any_walk());
  for (int n = 0; n < 4; ++n) {
    watch_walking(robot, *rc::gen::inRange(1, 400) * 0.1);
    robot.locomotion.walk(robot.now_s, *any_walk());
  }
  watch_walking(robot, 60);
  RC_ASSERT(robot.locomotion.progress() == Progress::running);
  RC_ASSERT(robot.locomotion.steps() > 0U);
  robot.locomotion.lay_down(robot.now_s);
  RC_ASSERT(robot.succeeds());
  RC_ASSERT(!robot.ordered);
}

// Legs take a new heading over one after the other; the gait was once judged by its end alone, and
// 0.07 mm were missing between the two.
TEST(IsolatedLegs, ATurnTheOtherWayIsStableBetweenTheTwoHeadingsToo) {
  Crippled robot(0b000100, -180 * kDegree);
  const auto walk = [&](double direction, double heading_deg, Speed speed, double duration_s) {
    robot.locomotion.walk(
        robot.now_s,
        {.direction = direction, .heading_rad = heading_deg * kDegree, .speed = speed});
    for (const double until_s = robot.now_s + duration_s; robot.now_s < until_s;) {
      robot.frame();
      ASSERT_GT(robot.margin_m(), 0) << robot.now_s;
    }
  };
  walk(-1, -90, Speed::low, 0.1);
  walk(-1, -90, Speed::high, 0.1);
  walk(1, -45, Speed::low, 12.3);
  walk(1, -45, Speed::low, 12.5);
  walk(1, 31, Speed::low, 60);
}

TEST(IsolatedLegs, WalkAheadAndBackAtTheSpeedOfTheirGait) {
  for (const LegSet isolated : creeping()) {
    for (const Pace& pace : kPaces) {
      for (const double direction : {1.0, -1.0}) {
        Crippled robot(isolated);
        const Footing f = footing(isolated, robot.parameters);
        Roll roll{{}, f.offset_rad, robot.parameters.leg_diameter_m, robot.parameters.hips};
        roll.half_sweep_rad.fill(direction * f.sweep_rad / 2);
        const Partition gait = stable_gait(isolated, pace.speed, roll).creep.gait;
        const double period_s = cycle_time_s(gait, f.times);
        const double wanted_m_s = (advance_m(f.offset_rad - f.sweep_rad / 2, 0.053) -
                                   advance_m(f.offset_rad + f.sweep_rad / 2, 0.053)) /
                                  period_s;
        robot.locomotion.walk(0, {.direction = direction, .heading_rad = 0, .speed = pace.speed});
        const double speed_m_s = two_cycles_m(robot, period_s) / (2 * period_s);
        EXPECT_NEAR(speed_m_s, direction * wanted_m_s, 0.02 * wanted_m_s) << int{isolated};
        EXPECT_GT(std::abs(speed_m_s), 1e-3);  // Zebro thesis [Oper-8]
        EXPECT_NEAR(robot.locomotion.yaw_rad(), 0, 0.1);
        EXPECT_FALSE(robot.ordered);
      }
    }
  }
}

// The first stance is already the rhythm's, so the first lift-off has the margin of all others.
TEST(IsolatedLegs, WalkIsInItsRhythmFromTheFirstLiftOff) {
  for (const LegSet isolated : creeping()) {
    Crippled robot(isolated);
    robot.locomotion.walk(0, {.direction = 1, .heading_rad = 0, .speed = Speed::high});
    while (robot.flying() == 0) {
      robot.frame();
      ASSERT_LT(robot.now_s, 10);
    }
    const double lambda_s = std::popcount(isolated) == 2 ? 18.0 : 13.5;
    PerLeg<double> theta_rad{};
    for (std::size_t i = 0; i < kLegs; ++i) theta_rad[i] = robot.theta_rad(i);
    robot.run(lambda_s);
    for (std::size_t i = 0; i < kLegs; ++i) {
      EXPECT_NEAR(wrap_rad(robot.theta_rad(i) - theta_rad[i]), 0, 0.06)
          << int{isolated} << ' ' << i;
    }
  }
}

TEST(IsolatedLegs, TurnOnTheSpotBothWays) {
  for (const LegSet isolated : creeping()) {
    for (const double heading_rad : {kPi / 2, -kPi / 2}) {
      Crippled robot(isolated);
      robot.locomotion.walk(0, {.direction = 1, .heading_rad = heading_rad, .speed = Speed::high});
      robot.run(60);
      EXPECT_GT(robot.locomotion.yaw_rad() * heading_rad, 0.5);
      EXPECT_NEAR(robot.locomotion.distance_m(), 0, 0.02);
    }
  }
}

// While a leg flies no foot on the ground moves: the margin relies on this.
TEST(IsolatedLegs, BodyRollsOnlyWhileAllFeetAreDown) {
  for (const LegSet isolated : creeping()) {
    Crippled robot(isolated);
    robot.locomotion.walk(0, {.direction = 1, .heading_rad = 0.2, .speed = Speed::medium});
    robot.run(2);
    double rolled_rad = 0;
    while (robot.now_s < 50) {
      robot.frame();
      for (std::size_t i = 0; i < kLegs; ++i) {
        if (robot.locomotion.targets()[i].swing) continue;
        if (robot.flying() > 0) {
          EXPECT_NEAR(robot.legs[i].rate_rad_s, 0, 0.02);
        }
        if (robot.now_s > 4) {  // in its double stance, and no faster
          EXPECT_LT(std::abs(robot.legs[i].rate_rad_s), 60 * kDegree / 1.5 * 1.1);
        }
        rolled_rad += std::abs(robot.legs[i].rate_rad_s) * kFrame_s;
      }
    }
    EXPECT_GT(rolled_rad, 5);
  }
}

// An On-Board Computer that steers by a trickle of small changes still gets ahead.
TEST(IsolatedLegs, SmallChangesOfHeadingDoNotKeepFiveLegsFromWalking) {
  Crippled robot(kLF);
  int n = 0;
  for (const double until_s = 60; robot.now_s < until_s; ++n) {
    robot.locomotion.walk(
        robot.now_s,
        {.direction = 1, .heading_rad = (n % 2 == 0 ? 3 : -3) * kDegree, .speed = Speed::high});
    robot.run(1);
  }
  EXPECT_GE(robot.locomotion.steps(), 4U);
}

RC_GTEST_PROP(IsolatedLegs, StandUpPushesWithAllOthersTogetherWhereverTheDeadHang, ()) {
  Crippled robot(*rc::gen::elementOf(some_isolated()), *rc::gen::inRange(-180, 180) * kDegree);
  robot.put_legs_at(kRest_rad);
  robot.locomotion.stand_up(0);
  while (robot.locomotion.progress() == Progress::running || robot.now_s == 0) {
    robot.frame();
    double low_rad = 10, high_rad = -10;
    for (std::size_t i = 0; i < kLegs; ++i) {
      if (robot.dead(i)) continue;
      low_rad = std::min(low_rad, robot.theta_rad(i));
      high_rad = std::max(high_rad, robot.theta_rad(i));
    }
    RC_ASSERT(high_rad - low_rad < 0.02);
    RC_ASSERT(robot.now_s < 5);
  }
  RC_ASSERT(robot.locomotion.progress() == Progress::done);
  for (std::size_t i = 0; i < kLegs; ++i) {
    if (!robot.dead(i)) RC_ASSERT(std::abs(robot.theta_rad(i)) < 0.06);
  }
  RC_ASSERT(!robot.ordered);
}

RC_GTEST_PROP(IsolatedLegs, LostLegsAreFoundAndDeadOnesAreNotWaitedFor, ()) {
  Crippled robot(*rc::gen::elementOf(some_isolated()), *rc::gen::inRange(-180, 180) * kDegree);
  for (std::size_t i = 0; i < kLegs; ++i) {
    if (robot.dead(i)) {
      robot.legs[i].answers = *rc::gen::arbitrary<bool>();  // it may still talk
      continue;
    }
    robot.legs[i].theta_rad = *rc::gen::inRange(-180, 180) * kDegree;
    robot.legs[i].zero_rad = *rc::gen::inRange(-180, 180) * kDegree;
    robot.legs[i].calibrated = false;
  }
  robot.locomotion.stand_up(0);
  RC_ASSERT(robot.succeeds());
  for (std::size_t i = 0; i < kLegs; ++i) {
    if (!robot.dead(i)) RC_ASSERT(robot.legs[i].calibrated);
  }
  robot.locomotion.stow(robot.now_s);
  RC_ASSERT(robot.succeeds());
  for (std::size_t i = 0; i < kLegs; ++i) {
    if (!robot.dead(i)) RC_ASSERT(std::abs(robot.theta_rad(i) - kRest_rad) < 0.06);
  }
  RC_ASSERT(!robot.ordered);
}

TEST(IsolatedLegs, AllOtherMotionsEndWhereTheyDoWithSix) {
  for (const LegSet isolated : some_isolated()) {
    Crippled robot(isolated);
    robot.locomotion.lay_down(0);
    ASSERT_TRUE(robot.finish());
    robot.expect_legs_at(kRest_rad);
    robot.locomotion.stand_up(robot.now_s);
    ASSERT_TRUE(robot.finish());
    robot.expect_legs_at(0);
    robot.locomotion.finish_step(robot.now_s);
    ASSERT_TRUE(robot.finish());
    robot.expect_legs_at(0);
    EXPECT_EQ(robot.locomotion.progress(), Progress::done);
    EXPECT_FALSE(robot.ordered);
  }
}

TEST(IsolatedLegs, FinishStepLandsWhatFliesAndStandsStraight) {
  for (const LegSet isolated : creeping()) {
    Crippled robot(isolated);
    robot.locomotion.walk(0, {.direction = 1, .heading_rad = 0, .speed = Speed::high});
    robot.run(30);
    robot.locomotion.finish_step(robot.now_s);
    while (robot.locomotion.progress() == Progress::running) {
      robot.frame();
      EXPECT_GT(robot.margin_m(), 0);
      ASSERT_LT(robot.now_s, 40);
    }
    robot.expect_legs_at(0);
  }
}

TEST(IsolatedLegs, WithoutAStableGaitWalkFailsAtOnceAndNothingMoves) {
  for (const LegSet isolated : some_isolated()) {
    if (can_walk_without(isolated)) continue;
    Crippled robot(isolated);
    robot.locomotion.walk(0, {});
    robot.run(2);
    EXPECT_EQ(robot.locomotion.progress(), Progress::failed);
    for (const LegTarget& target : robot.locomotion.targets()) EXPECT_EQ(target.segment, 0U);
  }
}

TEST(IsolatedLegs, AreChosenOnlyWhileNothingMovesAndAreTwoAtMost) {
  Robot robot;
  EXPECT_FALSE(robot.locomotion.isolate(0b000111));
  EXPECT_FALSE(robot.locomotion.isolate(0b1000000));
  EXPECT_EQ(robot.locomotion.isolated(), 0);
  robot.locomotion.walk(0, {});
  robot.run(1);
  EXPECT_FALSE(robot.locomotion.isolate(kLF));
  EXPECT_EQ(robot.locomotion.isolated(), 0);
  robot.locomotion.hold(robot.now_s);
  EXPECT_TRUE(robot.locomotion.isolate(kLF));
  EXPECT_EQ(robot.locomotion.isolated(), kLF);
}

// As when a leg fails in the middle of a walk: emergency, hold, isolate, continue.
TEST(IsolatedLegs, WalkGoesOnAfterALegDiedInTheAir) {
  Robot robot;
  robot.locomotion.walk(0, {.direction = 1, .heading_rad = 0, .speed = Speed::high});
  robot.run(8.6);
  ASSERT_TRUE(robot.locomotion.targets()[0].swing);
  robot.legs[0].stuck_until_s = 1e9;
  ASSERT_TRUE(robot.finish(30));
  ASSERT_EQ(robot.locomotion.progress(), Progress::failed);
  robot.locomotion.hold(robot.now_s);
  for (RobotLeg& leg : robot.legs) leg.left_rad = 0;
  ASSERT_TRUE(robot.locomotion.isolate(kLF));
  const std::uint32_t segment = robot.locomotion.targets()[0].segment;
  robot.locomotion.stand_up(robot.now_s);
  ASSERT_TRUE(robot.succeeds());
  robot.locomotion.walk(robot.now_s, {.direction = 1, .heading_rad = 0, .speed = Speed::high});
  const double from_m = robot.locomotion.distance_m();
  robot.run(60);
  EXPECT_GT(robot.locomotion.distance_m() - from_m, 0.15);
  EXPECT_EQ(robot.locomotion.targets()[0].segment, segment);
  EXPECT_EQ(robot.locomotion.targets()[0].rotation, 0);
}

TEST(IsolatedLegs, LegThatFellSilentOnItsWayIsNotSentOn) {
  Robot robot;
  robot.locomotion.walk(0, {.direction = 1, .heading_rad = 0, .speed = Speed::high});
  robot.run(8.6);
  ASSERT_TRUE(robot.locomotion.targets()[0].swing);
  ASSERT_GT(robot.locomotion.targets()[0].arrive_s, robot.now_s + 0.5);
  robot.legs[0].stuck_until_s = 1e9;
  robot.legs[0].answers = false;
  robot.locomotion.hold(robot.now_s);
  ASSERT_TRUE(robot.locomotion.isolate(kLF));
  const std::uint32_t segment = robot.locomotion.targets()[0].segment;
  robot.locomotion.stand_up(robot.now_s);
  ASSERT_TRUE(robot.finish());
  EXPECT_EQ(robot.locomotion.targets()[0].segment, segment);
}

// It stands on two legs and, perhaps, on the dead one.
TEST(IsolatedLegs, DeadLegIsNotStoodOn) {
  Crippled robot(kLF, 0);
  robot.legs[0].answers = robot.legs[0].calibrated = true;
  for (const std::size_t up : {1U, 2U, 5U}) robot.legs[up].theta_rad = 150 * kDegree;
  robot.locomotion.stand_up(0);
  double highest_rad = 0;
  for (int frame = 0; frame < 300; ++frame) {
    robot.frame();
    highest_rad = std::max(highest_rad, std::abs(robot.theta_rad(3)));
  }
  EXPECT_GT(highest_rad, 90 * kDegree);  // all go to where the belly carries first
  EXPECT_FALSE(robot.ordered);
}

TEST(IsolatedLegs, WalkThatIsCalledOffWhileItAlignsEndsStraight) {
  Crippled robot(kMiddle);
  robot.locomotion.walk(0, {.direction = 1, .heading_rad = 0, .speed = Speed::high});
  robot.run(0.5);
  robot.locomotion.walk(robot.now_s, {.direction = 1, .heading_rad = 0, .speed = Speed::zero});
  ASSERT_TRUE(robot.succeeds());
  robot.expect_legs_at(0);
}

TEST(IsolatedLegs, BackInServiceItWalksAsIfNothingHadHappened) {
  Robot robot, never;
  ASSERT_TRUE(robot.locomotion.isolate(kMiddle));
  ASSERT_TRUE(robot.locomotion.isolate(0));
  for (Robot* r : {&robot, &never}) {
    r->locomotion.walk(0, {.direction = 1, .heading_rad = 0.2, .speed = Speed::medium});
    r->run(40);
  }
  for (std::size_t i = 0; i < kLegs; ++i) {
    EXPECT_EQ(robot.locomotion.targets()[i].angle_rad, never.locomotion.targets()[i].angle_rad);
    EXPECT_EQ(robot.locomotion.targets()[i].arrive_s, never.locomotion.targets()[i].arrive_s);
    EXPECT_EQ(robot.locomotion.targets()[i].segment, never.locomotion.targets()[i].segment);
  }
  EXPECT_EQ(robot.locomotion.distance_m(), never.locomotion.distance_m());
}

TEST(IsolatedLegs, WhatADeadLegReportsDoesNotMoveTheBody) {
  Crippled quiet(kLF), noisy(kLF);
  noisy.legs[0].answers = noisy.legs[0].calibrated = true;
  for (Crippled* robot : {&quiet, &noisy}) {
    robot->locomotion.walk(0, {.direction = 1, .heading_rad = 0, .speed = Speed::medium});
    for (int frame = 0; frame < 2000; ++frame) {
      if (robot == &noisy) noisy.legs[0].theta_rad = (frame % 40 - 20) * kDegree;
      robot->frame();
    }
  }
  EXPECT_GT(quiet.locomotion.distance_m(), 0.05);
  EXPECT_EQ(quiet.locomotion.distance_m(), noisy.locomotion.distance_m());
  EXPECT_EQ(quiet.locomotion.yaw_rad(), noisy.locomotion.yaw_rad());
}

TEST(IsolatedLegs, LateLegIsWaitedForAndTheMarginKept) {
  Crippled robot(kLF);
  robot.locomotion.walk(0, {.direction = 1, .heading_rad = 0, .speed = Speed::high});
  robot.run(30);
  for (const bool fly : {false, true}) {
    while ((robot.flying() > 0) != fly) {
      robot.frame();
      ASSERT_LT(robot.now_s, 60);
    }
  }
  robot.run(1.5);
  std::size_t late = 0;
  while (!robot.locomotion.targets()[late].swing) ++late;
  robot.legs[late].stuck_until_s = robot.now_s + 4;
  for (int frame = 0; frame < 1500; ++frame) {
    robot.frame();
    EXPECT_GT(robot.margin_m(), 0);
    EXPECT_LE(robot.flying(), 2);
  }
  EXPECT_EQ(robot.locomotion.progress(), Progress::running);
}

TEST(IsolatedLegs, NothingAllocates) {
  Crippled robot(kMiddle);
  robot.locomotion.hold(0);
  const std::uint64_t before = testing_support::allocations();
  robot.locomotion.isolate(kLF);
  robot.locomotion.walk(0, {.direction = 1, .heading_rad = 0.3, .speed = Speed::high});
  robot.run(30);
  robot.locomotion.walk(robot.now_s, {.direction = -1, .heading_rad = 1, .speed = Speed::low});
  robot.run(30);
  robot.locomotion.hold(robot.now_s);
  robot.locomotion.isolate(0b010001);  // rows
  robot.locomotion.walk(robot.now_s, {.direction = 1, .heading_rad = 0.3, .speed = Speed::high});
  robot.run(30);
  EXPECT_EQ(testing_support::allocations(), before);
}

}  // namespace
}  // namespace lss::gnc::zebro::test
