// Rowing: support of the body over time; every motion in the middle of it.

#include "gnc/zebro/rowing.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <cstdio>
#include <fstream>
#include <sstream>

#include "gnc/zebro/locomotion.h"
#include "tests/zebro/gnc/crippled.h"

namespace lss::gnc::zebro::test {
namespace {

constexpr LocomotionParameters kDefault{};
constexpr LegSet kLeftCorners = 0b010001;
// The belly is this near to the ground, or on it: a body out of balance is caught by its edge.
constexpr double kNear_m = 0.0095;
constexpr double kMostRoll_m = 0.022;  // one side standing, the other on its belly: 0.028
constexpr double kBodyLength_m = 0.200, kBodyWidth_m = 0.130;

// Checks forbidden conditions while it rows.
struct Rower : Crippled {
  explicit Rower(LegSet without) : Crippled(without) {
    on_order = [this](std::size_t i, const LegTarget& target, double way_rad) {
      ordered |= contains(isolated, i);
      fastest_rad_s_ordered =
          std::max(fastest_rad_s_ordered, std::abs(way_rad) / (target.arrive_s - now_s));
    };
  }

  // Off the ground, or at most the remainder at the start of the swing.
  bool low(std::size_t i) const {
    return hip_height_m(theta_rad(i), parameters.leg_diameter_m) <
           parameters.belly_height_m + kNear_m;
  }

  // A side whose legs are low has its edge of the belly to carry it, or nearly; the other one has
  // all its feet. In a turn the sides go down at angles of their own.
  void look() const {
    PerLeg<bool> down{};
    PerLeg<double> theta{};
    HipGeometry points;
    bool all_low = true;
    std::array<double, 2> height_m{};
    for (const std::size_t front : {0U, 1U}) {
      bool side_low = true;
      height_m[front] = parameters.belly_height_m;
      for (std::size_t i = front; i < kLegs; i += 2) {
        if (dead(i)) continue;
        side_low &= low(i);
        height_m[front] =
            std::max(height_m[front], hip_height_m(theta_rad(i), parameters.leg_diameter_m));
      }
      all_low &= side_low;
      for (std::size_t i = front; i < kLegs; i += 2) {
        if (side_low) {
          down[i] = i != front + 2;  // the ends of the edge
          points.x_m[i] = i == front ? kBodyLength_m / 2 : -kBodyLength_m / 2;
          points.y_m[i] = std::copysign(kBodyWidth_m / 2, points.y_m[i]);
        } else if (!dead(i)) {
          down[i] = true;
          theta[i] = theta_rad(i);
          RC_ASSERT(hip_height_m(theta[i], parameters.leg_diameter_m) >= parameters.belly_height_m);
        }
      }
    }
    RC_ASSERT(std::abs(height_m[0] - height_m[1]) < kMostRoll_m);
    if (all_low) return;
    RC_ASSERT(static_margin_m(down, theta, parameters.leg_diameter_m, points) >= kLeastMargin_m);
  }

  void row(double duration_s) {
    for (const double until_s = now_s + duration_s; now_s < until_s;) {
      frame();
      look();
      RC_ASSERT(!ordered);
      RC_ASSERT(fastest_rad_s_ordered <= parameters.swing_limit_rad_s * 1.001);
    }
  }

  void end(double most_s = 30) {
    const double until_s = now_s + most_s;
    do {
      frame();
      look();
      RC_ASSERT(now_s < until_s);
    } while (locomotion.progress() == Progress::running);
    RC_ASSERT(locomotion.progress() == Progress::done);
  }

  double fastest_rad_s_ordered = 0;
};

RC_GTEST_PROP(Rowing, BellyCarriesWheneverNotAllFeetDoWithAMargin, ()) {
  Rower robot(*rc::gen::elementOf(rowing()));
  robot.locomotion.walk(0, *any_walk());
  for (int n = 0; n < 4; ++n) {
    robot.row(*rc::gen::inRange(1, 300) * 0.1);
    robot.locomotion.walk(robot.now_s, *any_walk());
  }
  robot.row(40);
  RC_ASSERT(robot.locomotion.progress() == Progress::running);
  RC_ASSERT(robot.locomotion.steps() > 0U);
}

RC_GTEST_PROP(Rowing, EveryMotionEndsWhereItShouldFromAnyMoment, ()) {
  Rower robot(*rc::gen::elementOf(rowing()));
  robot.locomotion.walk(0, *any_walk());
  robot.row(*rc::gen::inRange(1, 500) * 0.05);
  const int motion = *rc::gen::inRange(0, 5);
  if (motion == 0) robot.locomotion.finish_step(robot.now_s);
  if (motion == 1) robot.locomotion.stand_up(robot.now_s);
  if (motion == 2) robot.locomotion.walk(robot.now_s, {.speed = Speed::zero});
  if (motion == 3) robot.locomotion.lay_down(robot.now_s);
  if (motion == 4) robot.locomotion.stow(robot.now_s);
  robot.end();
  robot.expect_legs_at(motion < 3 ? 0 : kRest_rad);
}

TEST(Rowing, MarginOfEveryHeadingAllTheTime) {
  for (const LegSet isolated : rowing()) {
    EXPECT_GE(rowing_margin_m(isolated, kDefault), kLeastMargin_m);
    for (const double direction : {1.0, -1.0}) {
      for (int heading_deg = -90; heading_deg <= 90; heading_deg += 15) {
        Rower robot(isolated);
        robot.locomotion.walk(
            0,
            {.direction = direction, .heading_rad = heading_deg * kDegree, .speed = Speed::high});
        robot.row(30);
        EXPECT_GT(robot.locomotion.steps(), 4U);
      }
    }
  }
}

// With all legs by request, from any moment of a walk, and on its legs again from any stroke.
RC_GTEST_PROP(Rowing, WithAllLegsByRequestAndBackToSteps, ()) {
  Rower robot(0);
  WalkRequest request = *any_walk();
  request.speed = Speed::high;
  request.rows = *rc::gen::arbitrary<bool>();
  robot.locomotion.walk(0, request);
  for (int n = 0; n < 4; ++n) {
    robot.run(*rc::gen::inRange(20, 300) * 0.1);
    request = {.direction = *rc::gen::elementOf(std::vector{-1.0, 1.0}),
               .speed = Speed::high,
               .rows = !request.rows};
    robot.locomotion.walk(robot.now_s, request);
    // Within a cycle of the gait and the way to the other.
    robot.run(20);
    RC_ASSERT(robot.fastest_rad_s_ordered <= robot.parameters.swing_limit_rad_s * 1.001);
    std::uint32_t steps = robot.locomotion.steps();
    int most_flying = 0;
    for (int frame = 0; frame < 500; ++frame) {
      robot.frame();
      most_flying = std::max(most_flying, robot.flying());
    }
    RC_ASSERT(most_flying == (request.rows ? kLegs : kLegs / 2));
    RC_ASSERT(robot.locomotion.steps() > steps);
    RC_ASSERT(robot.locomotion.progress() == Progress::running);
  }
  robot.locomotion.finish_step(robot.now_s);
  RC_ASSERT(robot.finish());
  robot.expect_legs_at(0);
}

TEST(Rowing, SidesGoWhatTheyWereAskedForToHalfAStroke) {
  for (int percent = -100; percent <= 100; percent += 7) {
    double owed = 0, gone = 0;
    for (int n = 1; n <= 50; ++n) {
      owed += percent / 100.0;
      gone += static_cast<double>(next_stroke(owed));
      EXPECT_NEAR(gone, n * percent / 100.0, 0.5 + 1e-9);
    }
  }
}

double rowed_m_s(double direction, Speed speed, double cycle_s) {
  Rower robot(kLeftCorners);
  robot.locomotion.walk(0, {.direction = direction, .heading_rad = 0, .speed = speed});
  robot.run(2 * cycle_s);
  const double from_m = robot.locomotion.distance_m();
  const std::uint32_t steps = robot.locomotion.steps();
  robot.run(3 * cycle_s);
  EXPECT_EQ(robot.locomotion.steps(), steps + 3);
  return (robot.locomotion.distance_m() - from_m) / (3 * cycle_s);
}

TEST(Rowing, TablesOfTheDocumentAreWhatTheCodeDoes) {
  std::ifstream file(LSS_GAIT_DOCUMENT);
  std::stringstream document;
  document << file.rdbuf();
  std::string wanted;
  char text[120];
  for (const LegSet isolated : rowing()) {
    PerLeg<bool> down{};
    for (std::size_t i = 0; i < kLegs; ++i) down[i] = !contains(isolated, i);
    std::snprintf(text, sizeof text, "| %s | %.1f | %.1f |", legs_text(isolated).c_str(),
                  static_margin_m(down, {}, kDefault.leg_diameter_m) * 1e3,
                  rowing_margin_m(isolated, kDefault) * 1e3);
    wanted += document.str().find(text) == std::string::npos ? std::string(text) + "\n" : "";
  }
  EXPECT_EQ(wanted, "");
  constexpr struct {
    Speed speed;
    double cycle_s;
  } kRows[] = {{Speed::high, 4.1}, {Speed::medium, 8.1}, {Speed::low, 16.1}};
  for (const auto& row : kRows) {
    const double ahead_m_s = rowed_m_s(1, row.speed, row.cycle_s);
    EXPECT_NEAR(rowed_m_s(-1, row.speed, row.cycle_s), -ahead_m_s, 0.07 * ahead_m_s);
    std::snprintf(text, sizeof text, "| %s | %.1f | %.1f |",
                  kSpeedNames[static_cast<std::size_t>(row.speed)], row.cycle_s, ahead_m_s * 1e3);
    EXPECT_NE(document.str().find(text), std::string::npos) << text;
  }
}

TEST(Rowing, TurnsOnTheSpotAndInCurvesToTheSideAskedFor) {
  for (const LegSet isolated : rowing()) {
    for (const double sign : {1.0, -1.0}) {
      Rower spot(isolated), curve(isolated);
      spot.locomotion.walk(0,
                           {.direction = 1, .heading_rad = sign * kPi / 2, .speed = Speed::high});
      spot.run(30);
      EXPECT_GT(spot.locomotion.yaw_rad() * sign, 3);
      EXPECT_NEAR(spot.locomotion.distance_m(), 0, 0.05);
      curve.locomotion.walk(0, {.direction = 1, .heading_rad = sign * 0.3, .speed = Speed::high});
      curve.run(30);
      EXPECT_GT(curve.locomotion.yaw_rad() * sign, 0.5);
      EXPECT_GT(curve.locomotion.distance_m(), 0.3);
    }
  }
}

// One side is late wherever in the cycle: all wait for it before the next stage.
RC_GTEST_PROP(Rowing, LateLegIsWaitedFor, ()) {
  Rower robot(*rc::gen::elementOf(rowing()));
  robot.locomotion.walk(0, {.direction = 1, .heading_rad = 0, .speed = Speed::high});
  robot.row(10 + *rc::gen::inRange(0, 400) * 0.01);
  std::size_t late = *rc::gen::inRange<std::size_t>(0, kLegs);
  while (robot.dead(late)) late = (late + 1) % kLegs;
  robot.legs[late].stuck_until_s = robot.now_s + 3;
  robot.run(3);
  const std::uint32_t steps = robot.locomotion.steps();
  robot.run(20);
  RC_ASSERT(robot.locomotion.progress() == Progress::running);
  RC_ASSERT(robot.locomotion.steps() >= steps + 3);
}

TEST(Rowing, StuckLegFailsTheWalk) {
  Rower robot(kLeftCorners);
  robot.locomotion.walk(0, {.direction = 1, .heading_rad = 0, .speed = Speed::high});
  robot.run(10);
  robot.legs[2].stuck_until_s = 1e9;
  ASSERT_TRUE(robot.finish(robot.parameters.late_limit_s + 4));
  EXPECT_EQ(robot.locomotion.progress(), Progress::failed);
}

// A step that ends while the body rises goes on up, and does not lie down first.
TEST(Rowing, FinishStepWhileItRisesEndsAtOnce) {
  Rower robot(kLeftCorners);
  robot.locomotion.walk(0, {.direction = 1, .heading_rad = 0, .speed = Speed::medium});
  const auto leg = [&] { return robot.theta_rad(2); };
  while (!(robot.now_s > 5 && leg() > 0.5 && leg() < 1.2 && !robot.locomotion.targets()[2].swing)) {
    robot.frame();
    ASSERT_LT(robot.now_s, 30);
  }
  robot.locomotion.finish_step(robot.now_s);
  ASSERT_TRUE(robot.finish(2));
  EXPECT_EQ(robot.locomotion.progress(), Progress::done);
  robot.expect_legs_at(0);
}

}  // namespace
}  // namespace lss::gnc::zebro::test
