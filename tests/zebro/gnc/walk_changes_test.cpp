// Changes during a walk: heading, gait, direction, stop.

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "gnc/zebro/locomotion.h"
#include "tests/zebro/gnc/generators.h"
#include "tests/zebro/gnc/robot.h"

namespace lss::gnc::zebro::test {
namespace {

RC_GTEST_PROP(Walk, ChangingEverythingWhileWalkingKeepsEnoughLegsDownAndTheRateInItsLimit, ()) {
  Robot robot;
  robot.on_order = [&](std::size_t, const LegTarget& target, double way_rad) {
    RC_ASSERT(target.arrive_s > robot.now_s);
    RC_ASSERT(std::abs(way_rad) / (target.arrive_s - robot.now_s) <=
              robot.parameters.swing_limit_rad_s * (1 + 1e-9));
  };
  robot.locomotion.walk(0, *any_walk());
  for (int n = 0; n < 6; ++n) {
    const double until_s = robot.now_s + *rc::gen::inRange(1, 150) * 0.1;
    while (robot.now_s < until_s) {
      robot.frame();
      RC_ASSERT(robot.flying() <= 3);
    }
    robot.locomotion.walk(robot.now_s, *any_walk());
  }
  robot.run(90);
  RC_ASSERT(robot.locomotion.progress() == Progress::running);
  RC_ASSERT(robot.locomotion.steps() > 3);
}

TEST(Walk, NewHeadingTakesEffectWithTheNextSwingOfEachLeg) {
  Robot robot;
  robot.locomotion.walk(0, {.direction = 1, .heading_rad = 0, .speed = Speed::high});
  robot.run(2 * 6.6 + 1);
  const PerLeg<LegTarget> before = robot.locomotion.targets();
  robot.locomotion.walk(robot.now_s, {.direction = 1, .heading_rad = 0.5, .speed = Speed::high});
  robot.frame();
  for (std::size_t i = 0; i < kLegs; ++i) {
    EXPECT_EQ(robot.locomotion.targets()[i].segment, before[i].segment);
  }
  PerLeg<double> touchdown_rad{};
  robot.on_order = [&](std::size_t i, const LegTarget& target, double) {
    if (target.swing) touchdown_rad[i] = target.angle_rad;
  };
  robot.run(6.6);
  for (std::size_t i = 0; i < kLegs; ++i) {
    if (is_left(static_cast<int>(i))) {
      EXPECT_NEAR(touchdown_rad[i], 20 * kDegree, 1e-6);
    } else {
      EXPECT_LT(touchdown_rad[i], 10 * kDegree);
      EXPECT_GT(touchdown_rad[i], 1 * kDegree);
    }
  }
}

// A leg module counts the time of a movement in 16 bits of milliseconds.
TEST(Walk, ChangesOfTheSlowestGaitsOrderNothingLongerThanAModuleCanCount) {
  EXPECT_NE(check({.flight_s = 10}), nullptr);
  const LocomotionParameters slowest{.flight_s = 8.9};
  ASSERT_EQ(check(slowest), nullptr);
  for (const Pace& from : kPaces) {
    for (const Pace& to : kPaces) {
      if (from.speed == to.speed) continue;
      Robot robot(slowest);
      robot.on_order = [&](std::size_t i, const LegTarget& target, double) {
        EXPECT_LE(target.arrive_s - robot.now_s, 65.535) << i;
      };
      robot.locomotion.walk(0, {.direction = 1, .heading_rad = 0, .speed = from.speed});
      robot.run(150);
      robot.locomotion.walk(robot.now_s, {.direction = 1, .heading_rad = 0, .speed = to.speed});
      robot.run(150);
      EXPECT_EQ(robot.locomotion.progress(), Progress::running);
    }
  }
}

TEST(Walk, NewGaitIsWalkedFromTheNextCycleAndNothingCommandedMovesEarlier) {
  for (const Pace& from : kPaces) {
    for (const Pace& to : kPaces) {
      if (from.speed == to.speed) continue;
      Robot robot;
      robot.locomotion.walk(0, {.direction = 1, .heading_rad = 0, .speed = from.speed});
      robot.run(from.cycle_s + 5);
      PerLeg<LegTarget> last = robot.locomotion.targets();
      robot.on_order = [&](std::size_t i, const LegTarget& target, double) {
        // Replaced while it was under way: only by the same movement, later.
        if (robot.now_s < last[i].arrive_s - kFrame_s) {
          EXPECT_EQ(target.angle_rad, last[i].angle_rad);
          EXPECT_GE(target.arrive_s, last[i].arrive_s);
        }
        last[i] = target;
      };
      robot.locomotion.walk(robot.now_s, {.direction = 1, .heading_rad = 0, .speed = to.speed});
      robot.run(from.cycle_s + to.cycle_s);
      robot.on_order = nullptr;
      const double speed_m_s = two_cycles_m(robot, to.cycle_s) / (2 * to.cycle_s);
      EXPECT_NEAR(speed_m_s, to.speed_m_s, 0.05e-3 + 0.005 * to.speed_m_s);
    }
  }
}

// Whoever changes the gait faster than it can be changed must not hold the robot up.
TEST(Walk, GaitsRequestedInTurnDoNotDelayTheWalk) {
  for (const Speed other : {Speed::medium, Speed::high}) {
    for (const double every_s : {0.5, 2.0, 4.0, 8.0}) {
      Robot robot;
      robot.locomotion.walk(0, {.speed = Speed::low});
      robot.run(25);
      const std::uint32_t before = robot.locomotion.steps();
      const double until_s = robot.now_s + 200;
      for (bool low = false; robot.now_s < until_s; low = !low) {
        robot.locomotion.walk(robot.now_s, {.speed = low ? Speed::low : other});
        robot.run(every_s);
      }
      EXPECT_GE(robot.locomotion.steps() - before, 7U) << every_s;  // the slowest: 10
      EXPECT_EQ(robot.locomotion.progress(), Progress::running);
    }
  }
}

// From standing, two tripods put the legs in place at half speed; then all go at the speed of the
// gait.
TEST(Walk, LegsOnTheGroundNeverWorkAgainstEachOtherEvenInTheFirstCycle) {
  for (const Pace& pace : kPaces) {
    Robot robot;
    robot.locomotion.walk(0, {.direction = 1, .heading_rad = 0, .speed = pace.speed});
    robot.run(robot.parameters.start_delay_s + 0.1);
    const double full_rad_s = 40 * kDegree / (pace.cycle_s - 3.0);
    int compared = 0;
    while (robot.now_s < 2.5 * pace.cycle_s) {
      robot.frame();
      const double since_s = robot.now_s - robot.parameters.start_delay_s - 6.6;
      if (std::abs(since_s) < 0.1) continue;
      const double wanted_rad_s = since_s < 0 ? full_rad_s / 2 : full_rad_s;
      for (std::size_t i = 0; i < kLegs; ++i) {
        const LegTarget& target = robot.locomotion.targets()[i];
        if (target.swing || target.arrive_s < robot.now_s + 0.1 || robot.legs[i].rate_rad_s == 0) {
          continue;
        }
        EXPECT_NEAR(-robot.legs[i].rate_rad_s, wanted_rad_s, 0.2 * full_rad_s) << robot.now_s;
        ++compared;
      }
    }
    EXPECT_GT(compared, 1000);
  }
}

TEST(Walk, ReversalFinishesTheStepFirstSoThatLegsNeverPushAgainstEachOther) {
  Robot robot;
  robot.locomotion.walk(0, {.direction = 1, .heading_rad = 0, .speed = Speed::low});
  robot.run(30);
  robot.locomotion.walk(robot.now_s, {.direction = -1, .heading_rad = 0, .speed = Speed::low});
  bool backward = false;
  for (int frame = 0; frame < 2000; ++frame) {
    robot.frame();
    int forward_stance = 0, backward_swing = 0;
    for (const LegTarget& target : robot.locomotion.targets()) {
      if (!target.swing && target.rotation > 0 && target.arrive_s > robot.now_s) ++forward_stance;
      if (target.swing && target.rotation < 0) ++backward_swing;
    }
    backward |= backward_swing > 0;
    if (backward) {
      EXPECT_EQ(forward_stance, 0);
    }
  }
  EXPECT_TRUE(backward);
  EXPECT_EQ(robot.locomotion.motion(), Motion::walk);
  EXPECT_LT(two_cycles_m(robot, 19.8), -1.9 * kStride_m);
}

TEST(Walk, OneSideReversingAloneFinishesTheStepToo) {
  for (const double heading_rad : {kPi / 2, -kPi / 2}) {
    Robot robot;
    robot.locomotion.walk(0, {.direction = 1, .heading_rad = 0, .speed = Speed::medium});
    robot.run(21);
    ASSERT_GT(robot.flying(), 0);
    robot.locomotion.walk(robot.now_s,
                          {.direction = 1, .heading_rad = heading_rad, .speed = Speed::medium});
    robot.run(3.5);
    EXPECT_EQ(robot.flying(), 0);
    for (std::size_t i = 0; i < kLegs; ++i) EXPECT_EQ(robot.locomotion.targets()[i].angle_rad, 0);
  }
}

class Stopping : public testing::TestWithParam<int> {};

// [Func-2] [Oper-7]
TEST_P(Stopping, SwingsInTheAirLandAsPlannedAndNoOtherLegLiftsOff) {
  for (const bool by_zero_speed : {false, true}) {
    for (const Pace& pace : kPaces) {
      Robot robot;
      robot.locomotion.walk(0, {.direction = 1, .heading_rad = 0.3, .speed = pace.speed});
      robot.run(pace.cycle_s + 0.25 * GetParam());
      const PerLeg<LegTarget> before = robot.locomotion.targets();
      if (by_zero_speed) {
        robot.locomotion.walk(robot.now_s,
                              {.direction = 1, .heading_rad = 0.3, .speed = Speed::zero});
      } else {
        robot.locomotion.finish_step(robot.now_s);
      }
      const double asked_s = robot.now_s;
      while (robot.locomotion.progress() == Progress::running) {
        robot.frame();
        for (std::size_t i = 0; i < kLegs; ++i) {
          const LegTarget& target = robot.locomotion.targets()[i];
          if (target.swing) {
            EXPECT_TRUE(before[i].swing);
            EXPECT_EQ(target.arrive_s, before[i].arrive_s);
          }
        }
        ASSERT_LT(robot.now_s, asked_s + 3.0 + 1.0 + 0.2);
      }
      EXPECT_EQ(robot.locomotion.progress(), Progress::done);
      for (std::size_t i = 0; i < kLegs; ++i) EXPECT_NEAR(robot.theta_rad(i), 0, 0.051);
      const PerLeg<LegTarget> still = robot.locomotion.targets();
      robot.run(5);
      for (std::size_t i = 0; i < kLegs; ++i) {
        EXPECT_EQ(robot.locomotion.targets()[i].segment, still[i].segment);
      }
      // And on again.
      robot.locomotion.walk(robot.now_s, {.direction = 1, .heading_rad = 0, .speed = Speed::high});
      EXPECT_GT(two_cycles_m(robot, 6.6), 1.9 * 6.6 * 10.1e-3);
    }
  }
}
INSTANTIATE_TEST_SUITE_P(AtAnyMoment, Stopping, testing::Range(0, 14, 3));

TEST(Walk, LyingDownWhileWalkingFinishesTheStepFirst) {
  Robot robot;
  robot.locomotion.walk(0, {.direction = 1, .heading_rad = 0, .speed = Speed::high});
  robot.run(9);
  robot.locomotion.lay_down(robot.now_s);
  ASSERT_TRUE(robot.succeeds());
  for (std::size_t i = 0; i < kLegs; ++i) EXPECT_NEAR(robot.theta_rad(i), 105.7 * kDegree, 0.06);
}

}  // namespace
}  // namespace lss::gnc::zebro::test
