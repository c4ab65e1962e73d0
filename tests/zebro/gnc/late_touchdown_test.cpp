// A leg that comes down late, or not at all.

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <vector>

#include "gnc/zebro/locomotion.h"
#include "gnc/zebro/stability.h"
#include "tests/zebro/gnc/generators.h"
#include "tests/zebro/gnc/robot.h"

namespace lss::gnc::zebro::test {
namespace {

// When did each leg lift off and touch down, as ordered.
struct Diary {
  explicit Diary(Robot& robot) {
    robot.on_order = [this, &robot](std::size_t i, const LegTarget& target, double) {
      if (target.swing != flying[i]) {
        (target.swing ? lift_off_s : touchdown_s)[i].push_back(robot.now_s);
      }
      flying[i] = target.swing;
    };
  }
  PerLeg<bool> flying{};
  PerLeg<std::vector<double>> lift_off_s{}, touchdown_s{};
};

RC_GTEST_PROP(LateTouchdown, DelaysTheOthersByNoMoreAndTheRhythmIsBackAfterTwoCycles, ()) {
  const Speed speed = *any_pace();
  const double lambda_s = cycle_s(speed);
  const auto late = static_cast<std::size_t>(*rc::gen::inRange(0, kLegs));
  const double stuck_s = *rc::gen::inRange(10, 40) * 0.1;
  const double at_s = 2 * lambda_s + *rc::gen::inRange(0, 100) * 0.01 * lambda_s;

  Robot on_time, disturbed;
  disturbed.legs[late].stuck_until_s = -1;
  Diary a(on_time), b(disturbed);
  for (Robot* robot : {&on_time, &disturbed}) {
    robot->locomotion.walk(0, {.direction = 1, .heading_rad = 0, .speed = speed});
  }
  on_time.run(8 * lambda_s);
  disturbed.run(at_s);
  disturbed.legs[late].stuck_until_s = disturbed.now_s + stuck_s;
  disturbed.run(8 * lambda_s - at_s);
  RC_ASSERT(disturbed.locomotion.progress() == Progress::running);

  // The leg needs up to its flight time more to catch up from where it was stuck.
  const double most_s = stuck_s + 0.1;
  const Events v = rhythm(speed == Speed::low      ? kWave
                          : speed == Speed::medium ? kTetrapodB
                                                   : kTripod,
                          {3.0, 3.3, 0.3});
  for (std::size_t i = 0; i < kLegs; ++i) {
    const std::size_t cycles = std::min(a.lift_off_s[i].size(), b.lift_off_s[i].size());
    for (std::size_t k = 0; k < cycles; ++k) {
      const double delay_s = b.lift_off_s[i][k] - a.lift_off_s[i][k];
      RC_ASSERT(delay_s >= -kFrame_s * 1.1);
      RC_ASSERT(delay_s <= most_s);
    }
    // Two cycles after the disturbance the legs keep the gait's intervals again.
    const double offset_s = b.lift_off_s[0][5] - v.lift_off_s[0];
    RC_ASSERT(std::abs(b.lift_off_s[i][5] - v.lift_off_s[i] - offset_s) <= 2.1 * kFrame_s);
  }
}

TEST(LateTouchdown, NoOtherLegLiftsOffBeforeTheLateOneIsDown) {
  Robot robot;
  robot.locomotion.walk(0, {.direction = 1, .heading_rad = 0, .speed = Speed::high});
  robot.run(6.6 + 2.0);  // LF, RM, LH fly
  ASSERT_TRUE(robot.locomotion.targets()[0].swing);
  robot.legs[0].stuck_until_s = robot.now_s + 4;
  double down_s = 0;
  robot.on_order = [&](std::size_t i, const LegTarget& target, double) {
    if (i == 0 && !target.swing && down_s == 0) down_s = robot.now_s;
    if (i != 0 && target.swing) {
      EXPECT_GT(down_s, 0);
      EXPECT_GE(robot.now_s, down_s + robot.parameters.double_stance_s - kFrame_s);
    }
  };
  robot.run(8);
  EXPECT_GT(down_s, robot.legs[0].stuck_until_s);
}

// Walks on until a leg has flown half its time; then it sticks for 4 s. Returns the leg on the
// ground that has furthest to roll.
std::size_t stick_a_leg_in_the_air(Robot& robot) {
  robot.locomotion.walk(0, {.direction = 1, .heading_rad = 0, .speed = Speed::medium});
  robot.run(40);
  while (robot.flying() > 0) robot.frame();
  while (robot.flying() == 0) robot.frame();
  robot.run(1.5);
  const PerLeg<LegTarget>& targets = robot.locomotion.targets();
  const auto flies = [](const LegTarget& target) { return target.swing; };
  const auto late = std::find_if(targets.begin(), targets.end(), flies) - targets.begin();
  robot.legs[static_cast<std::size_t>(late)].stuck_until_s = robot.now_s + 4;
  const auto sooner = [](const LegTarget& a, const LegTarget& b) {
    return a.arrive_s < b.arrive_s;
  };
  return static_cast<std::size_t>(std::max_element(targets.begin(), targets.end(), sooner) -
                                  targets.begin());
}

TEST(LateTouchdown, LegsOnTheGroundAreSlowedSoThatTheyArriveWhenTheyLiftOff) {
  Robot robot;
  const std::size_t rolling = stick_a_leg_in_the_air(robot);
  double promised_s = robot.locomotion.targets()[rolling].arrive_s;
  const double at_first_s = promised_s;
  double swing_s = 0;
  robot.on_order = [&](std::size_t i, const LegTarget& target, double) {
    if (i != rolling) return;
    if (target.swing && swing_s == 0) {
      swing_s = robot.now_s;
      EXPECT_NEAR(robot.theta_rad(rolling), -20 * kDegree, 1 * kDegree);
      EXPECT_NEAR(promised_s, swing_s, 0.15);
    }
    promised_s = target.arrive_s;
  };
  robot.run(12);
  EXPECT_GT(swing_s, at_first_s + 2);
}

TEST(LateTouchdown, LegThatRanAheadIsTurnedBackWhenSlowedAndNotOnceRound) {
  Robot robot;
  const std::size_t rolling = stick_a_leg_in_the_air(robot);
  robot.legs[rolling].theta_rad = -30 * kDegree;
  robot.legs[rolling].left_rad = 0;
  int turned_back = 0;
  robot.on_order = [&](std::size_t i, const LegTarget& target, double way_rad) {
    if (i != rolling || target.swing) return;
    EXPECT_LT(std::abs(way_rad), 20 * kDegree);
    if (target.rotation < 0) ++turned_back;
  };
  robot.run(4);
  EXPECT_GT(turned_back, 0);
}

// With any of them late, nobody lifts off in the same frame as it is due, either.
TEST(LateTouchdown, WithoutDoubleStanceTheLegsOnTheGroundWaitForTheLateOne) {
  for (std::size_t late = 0; late < kLegs; ++late) {
    Robot robot({.stance_min_s = 2.9, .double_stance_s = 0});
    robot.locomotion.walk(0, {.direction = 1, .heading_rad = 0, .speed = Speed::high});
    robot.run(12);
    while (!robot.locomotion.targets()[late].swing) robot.frame();
    robot.run(1);
    robot.legs[late].stuck_until_s = robot.now_s + 3;
    for (int frame = 0; frame < 500; ++frame) {
      robot.frame();
      ASSERT_LE(robot.flying(), 3) << "late " << late;
    }
    EXPECT_EQ(robot.locomotion.progress(), Progress::running);
  }
}

TEST(LateTouchdown, BeyondTheLateLimitFails) {
  Robot robot;
  robot.locomotion.walk(0, {.direction = 1, .heading_rad = 0, .speed = Speed::high});
  robot.run(8.6);
  robot.legs[0].stuck_until_s = 1e9;
  const double due_s = robot.locomotion.targets()[0].arrive_s;
  ASSERT_TRUE(robot.finish(30));
  EXPECT_EQ(robot.locomotion.progress(), Progress::failed);
  EXPECT_NEAR(robot.now_s, due_s + robot.parameters.late_limit_s, 0.1);
}

TEST(LateTouchdown, LegWithoutReferenceIsNotBelievedToBeLate) {
  Robot robot;
  robot.legs[2].calibrated = robot.legs[2].has_sensor = false;
  robot.legs[5].answers = false;
  robot.locomotion.stand_up(0);
  ASSERT_TRUE(robot.finish());
  robot.locomotion.walk(robot.now_s, {.direction = 1, .heading_rad = 0, .speed = Speed::high});
  robot.legs[2].stuck_until_s = 1e9;
  const std::uint32_t steps = robot.locomotion.steps();
  robot.run(4 * 6.6 + 1);
  EXPECT_EQ(robot.locomotion.progress(), Progress::running);
  EXPECT_EQ(robot.locomotion.steps() - steps, 4U);
}

// The same walk with both algorithms, whose gait changes after the first cycle: no difference as
// long as all legs are in time.
RC_GTEST_PROP(Neighbours, OrderTheSameAsGroupsWhileNoLegIsLate, ()) {
  const WalkRequest first{.speed = *any_pace()}, second{.speed = *any_pace()};
  const double change_s = *rc::gen::inRange(100, 600) * 0.1;
  Robot groups, neighbours({.coordination = Coordination::neighbours});
  Diary a(groups), b(neighbours);
  for (Robot* robot : {&groups, &neighbours}) {
    robot->locomotion.walk(0, first);
    robot->run(change_s);
    robot->locomotion.walk(robot->now_s, second);
    robot->run(60);
  }
  for (std::size_t i = 0; i < kLegs; ++i) {
    RC_ASSERT(b.lift_off_s[i].size() == a.lift_off_s[i].size());
    for (std::size_t k = 0; k < a.lift_off_s[i].size(); ++k)
      RC_ASSERT(std::abs(a.lift_off_s[i][k] - b.lift_off_s[i][k]) < 1.5 * kFrame_s);
  }
}

// Any leg, late at any time of any gait: it is never in the air together with its neighbour, the
// centre of mass stays above the feet, and nobody else waits longer than with groups.
RC_GTEST_PROP(Neighbours, ALateLegHoldsUpOnlyItsNeighboursAndTheRobotStands_Conf_2, ()) {
  const Speed speed = *any_pace();
  const auto late = static_cast<std::size_t>(*rc::gen::inRange(0, kLegs));
  const double stuck_s = *rc::gen::inRange(10, 49) * 0.1;
  const double at_s = (2 + *rc::gen::inRange(0, 100) * 0.01) * cycle_s(speed);
  Robot groups, neighbours({.coordination = Coordination::neighbours});
  Diary a(groups), b(neighbours);
  for (Robot* robot : {&groups, &neighbours}) {
    robot->locomotion.walk(0, {.speed = speed});
    while (robot->now_s < 8 * cycle_s(speed)) {
      if (std::abs(robot->now_s - at_s) < kFrame_s / 2)
        robot->legs[late].stuck_until_s = robot->now_s + stuck_s;
      robot->frame();
      PerLeg<bool> down{};
      PerLeg<double> theta_rad{};
      for (std::size_t i = 0; i < kLegs; ++i) {
        down[i] = !robot->locomotion.targets()[i].swing;
        theta_rad[i] = robot->theta_rad(i);
        for (std::size_t j = 0; j < i; ++j)
          RC_ASSERT(down[i] || down[j] || !zebro::neighbours(i, j));
      }
      RC_ASSERT(static_margin_m(down, theta_rad, robot->parameters.leg_diameter_m) > 0.005);
    }
    RC_ASSERT(robot->locomotion.progress() == Progress::running);
  }
  double most_s = 0;
  for (std::size_t i = 0; i < kLegs; ++i) {
    for (std::size_t k = 0; k < std::min(a.lift_off_s[i].size(), b.lift_off_s[i].size()); ++k) {
      RC_ASSERT(b.lift_off_s[i][k] <= a.lift_off_s[i][k] + 1.5 * kFrame_s);
      most_s = std::max(most_s, a.lift_off_s[i][k] - b.lift_off_s[i][k]);
    }
  }
  RC_CLASSIFY(most_s > 1);
}

TEST(Neighbours, AFrontLegThatIsLateDoesNotDelayTheHindLegOfTheOtherSide) {
  for (const Coordination coordination : {Coordination::groups, Coordination::neighbours}) {
    Robot robot({.coordination = coordination});
    robot.locomotion.walk(0, {.speed = Speed::high});
    robot.run(6.6 + 2.0);  // LF, RM, LH fly
    ASSERT_TRUE(robot.locomotion.targets()[0].swing);
    robot.legs[0].stuck_until_s = robot.now_s + 4;
    robot.run(3);
    const auto flies = [&](std::size_t i) { return robot.locomotion.targets()[i].swing; };
    EXPECT_TRUE(flies(0));
    EXPECT_FALSE(flies(1) || flies(2)) << "its neighbours wait";
    EXPECT_EQ(flies(5), coordination == Coordination::neighbours);
  }
}

// Nobody of the next cycle lifts off before, and then none faster than planned or together with its
// neighbour.
TEST(Neighbours, ALateLegOfTheLastGroupDelaysTheNextCycle) {
  for (const Speed speed : {Speed::low, Speed::medium, Speed::high}) {
    Robot robot({.coordination = Coordination::neighbours});
    robot.locomotion.walk(0, {.speed = speed});
    robot.run(2 * cycle_s(speed));
    const std::size_t late = speed == Speed::medium ? 5 : 1;
    while (!robot.locomotion.targets()[late].swing) robot.frame();
    robot.run(1.5);
    robot.legs[late].stuck_until_s = robot.now_s + 4.9;
    Diary diary(robot);
    const double until_s = robot.now_s + 20;
    while (robot.now_s < until_s) {
      robot.frame();
      for (std::size_t i = 0; i < kLegs; ++i) {
        for (std::size_t j = 0; j < i; ++j)
          ASSERT_FALSE(diary.flying[i] && diary.flying[j] && neighbours(i, j)) << i << ' ' << j;
      }
    }
    ASSERT_EQ(robot.locomotion.progress(), Progress::running);
    for (std::size_t i = 0; i < kLegs; ++i) {
      if (diary.lift_off_s[i].empty() || diary.touchdown_s[i].empty() || i == late) continue;
      const double lift_off_s = diary.lift_off_s[i][0];
      for (const double touchdown_s : diary.touchdown_s[i]) {
        if (touchdown_s < lift_off_s) continue;
        EXPECT_GE(touchdown_s - lift_off_s, robot.parameters.flight_s - 2.5 * kFrame_s) << i;
        break;
      }
    }
  }
}

}  // namespace
}  // namespace lss::gnc::zebro::test
