#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <map>
#include <vector>

#include "gnc/zebro/locomotion.h"
#include "tests/zebro/gnc/generators.h"
#include "tests/zebro/gnc/robot.h"

namespace lss::gnc::zebro::test {
namespace {

constexpr double kStride_m = 36.42e-3;

rc::Gen<Speed> any_pace() { return rc::gen::element(Speed::low, Speed::medium, Speed::high); }

rc::Gen<WalkRequest> any_walk() {
  return rc::gen::build<WalkRequest>(
      rc::gen::set(&WalkRequest::direction, rc::gen::element(1.0, -1.0)),
      rc::gen::set(&WalkRequest::heading_rad,
                   rc::gen::map(rc::gen::inRange(-90, 91), [](int deg) { return deg * kDeg; })),
      rc::gen::set(&WalkRequest::speed, any_pace()));
}

double cycle_s(Speed speed) {
  return speed == Speed::low ? 19.8 : speed == Speed::medium ? 9.9 : 6.6;
}

struct Pace {
  Speed speed;
  double cycle_s, speed_m_s;
};
constexpr Pace kPaces[] = {
    {Speed::low, 19.8, 2.2e-3}, {Speed::medium, 9.9, 5.3e-3}, {Speed::high, 6.6, 10.1e-3}};

// Distance of two whole cycles in the steady rhythm.
double two_cycles_m(Robot& robot, double period_s) {
  robot.run(2 * period_s + robot.parameters.start_delay_s);
  const double from_m = robot.locomotion.distance_m();
  robot.run(2 * period_s);
  return robot.locomotion.distance_m() - from_m;
}

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

TEST(Walk, BackwardIsAsFastTheOtherWay) {
  for (const Pace& pace : kPaces) {
    Robot robot;
    robot.locomotion.walk(0, {.direction = -1, .heading_rad = 0, .speed = pace.speed});
    const double speed_m_s = two_cycles_m(robot, pace.cycle_s) / (2 * pace.cycle_s);
    EXPECT_NEAR(speed_m_s, -pace.speed_m_s, 0.05e-3 + 0.005 * pace.speed_m_s);
  }
}

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
      EXPECT_NEAR(touchdown_rad[i], 20 * kDeg, 1e-6);
    } else {
      EXPECT_LT(touchdown_rad[i], 10 * kDeg);
      EXPECT_GT(touchdown_rad[i], 1 * kDeg);
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

// From standing, two tripods put the legs in place at half speed; then all go at the speed of the
// gait.
TEST(Walk, LegsOnTheGroundNeverWorkAgainstEachOtherEvenInTheFirstCycle) {
  for (const Pace& pace : kPaces) {
    Robot robot;
    robot.locomotion.walk(0, {.direction = 1, .heading_rad = 0, .speed = pace.speed});
    robot.run(robot.parameters.start_delay_s + 0.1);
    const double full_rad_s = 40 * kDeg / (pace.cycle_s - 3.0);
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
  ASSERT_TRUE(robot.finish());
  EXPECT_EQ(robot.locomotion.progress(), Progress::done);
  for (std::size_t i = 0; i < kLegs; ++i) EXPECT_NEAR(robot.theta_rad(i), 105.7 * kDeg, 0.06);
}

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
      EXPECT_NEAR(robot.theta_rad(rolling), -20 * kDeg, 1 * kDeg);
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
  robot.legs[rolling].theta_rad = -30 * kDeg;
  robot.legs[rolling].left_rad = 0;
  int turned_back = 0;
  robot.on_order = [&](std::size_t i, const LegTarget& target, double way_rad) {
    if (i != rolling || target.swing) return;
    EXPECT_LT(std::abs(way_rad), 20 * kDeg);
    if (target.rotation < 0) ++turned_back;
  };
  robot.run(4);
  EXPECT_GT(turned_back, 0);
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

TEST(Walk, LegThatPassesItsSensorOnTheWayIsOrderedAnewFromItsTrueAngle) {
  Robot robot;
  robot.legs[3].calibrated = robot.legs[3].has_sensor = false;
  robot.locomotion.stand_up(0);
  ASSERT_TRUE(robot.finish());
  // It stands 50 deg off what it believes, and its sensor comes back.
  robot.legs[3].zero_rad -= 50 * kDeg;
  robot.legs[3].theta_rad += 50 * kDeg;
  robot.legs[3].has_sensor = true;
  robot.locomotion.walk(robot.now_s, {.direction = 1, .heading_rad = 0, .speed = Speed::high});
  robot.run(2 * 6.6);
  EXPECT_TRUE(robot.legs[3].calibrated);
  EXPECT_EQ(robot.locomotion.progress(), Progress::running);
  for (int frame = 0; frame < 330; ++frame) {
    robot.frame();
    if (robot.locomotion.targets()[3].swing) continue;
    EXPECT_LT(std::abs(robot.theta_rad(3)), 24 * kDeg);
  }
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

// As real modules do: reports 40 ms old, and 5000 rpm at the gear is 117 deg/s (Zebro thesis
// A.2.3), less than a leg that steps on the spot needs.
TEST(Walk, KeepsWalkingOnSlowLegsWithOldReports) {
  for (const double heading_deg : {0.0, 45.0, 90.0}) {
    for (const Pace& pace : kPaces) {
      Robot robot;
      robot.fastest_rad_s = 117.2 * kDeg;
      robot.report_age_frames = 2;
      robot.locomotion.walk(
          0, {.direction = 1, .heading_rad = heading_deg * kDeg, .speed = pace.speed});
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
  robot.locomotion.walk(0, {.direction = 1, .heading_rad = 42 * kDeg, .speed = Speed::high});
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

}  // namespace
}  // namespace lss::gnc::zebro::test
