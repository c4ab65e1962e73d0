// Pulses: off-pulsing keeps the lift, every pulse is one that the valves can do, phase plane,
// sigma-delta of the side jets.

#include "gnc/talaris/pwm.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <cmath>
#include <numeric>

#include "gnc/talaris/lateral.h"
#include "gnc/talaris/phase_plane.h"

namespace lss::gnc::talaris {
namespace {

double any(int range) { return *rc::gen::inRange(-1000 * range, 1000 * range + 1) * 0.001; }

RC_GTEST_PROP(TalarisPwm, OffPulsingKeepsTheAggregateOnTime, ()) {
  const Thrusters t;
  const double lift = 20 + std::abs(any(250)), my = any(60), mz = any(60);
  const LiftPulses p = allocate_lift(lift, my, mz, t);
  const double sum = std::accumulate(p.on_s.begin(), p.on_s.end(), 0.0);
  RC_ASSERT(std::abs(sum - 4 * p.mean_s) < 1e-15);
  for (const double on : p.on_s) RC_ASSERT(on >= t.min_on_s && on <= t.max_on_s);
  // the lift itself gives way only at the valves' limits
  const double asked = kFrame_s * lift / (4 * t.force_N);
  if (asked >= t.min_on_s + t.attitude_room_s && asked <= t.max_on_s - t.attitude_room_s) {
    RC_ASSERT(p.mean_s == asked);
  }
  // moments in their direction, scaled by the same share
  const double F = t.force_N / kFrame_s;
  double y = 0, z = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    y += kLiftZ[i] * t.lift_z_m * F * p.on_s[i];
    z -= kLiftY[i] * t.lift_y_m * F * p.on_s[i];
  }
  RC_ASSERT(std::abs(y - p.share * my) < 1e-9 && std::abs(z - p.share * mz) < 1e-9);
}

TEST(TalarisPwm, AMomentAboutPlusZLengthensValves1And3) {
  const LiftPulses p = allocate_lift(73.5, 0, 1, Thrusters{});
  EXPECT_GT(p.on_s[0], p.mean_s);
  EXPECT_GT(p.on_s[1], p.mean_s);
  EXPECT_LT(p.on_s[2], p.mean_s);
  EXPECT_LT(p.on_s[3], p.mean_s);
}

TEST(TalarisPwm, LiftGoesFrom46To186NewtonWith58) {
  const Thrusters t;
  const double F = 4 * t.force_N / kFrame_s;
  EXPECT_NEAR(F * allocate_lift(0, 0, 0, t).mean_s, 46.4, 0.01);
  EXPECT_NEAR(F * allocate_lift(1e9, 0, 0, t).mean_s, 185.6, 0.01);
  EXPECT_NEAR(F * allocate_lift(1e9, 0, 0, t, true).mean_s, 232, 0.01);
  EXPECT_NEAR(F * allocate_lift(kNaN, kNaN, 0, t).mean_s, 46.4, 0.01);
}

TEST(TalarisPwm, PulsesAreCentredAndWhatIsLeftAtTheBoundaryIsKnown) {
  for (double on = 0.04; on <= 0.2; on += 0.01) {
    const Pulse p = centred(on);
    EXPECT_NEAR(2 * p.delay_s + p.on_s, kFrame_s, 1e-15);
    EXPECT_LE(p.delay_s + p.on_s, kFrame_s + 1e-15);
  }
  EXPECT_DOUBLE_EQ(centred(0).on_s, 0);
  EXPECT_NEAR(remaining_s(centred(0.2), 0.005, 0.008), 0.013, 1e-12);
  EXPECT_NEAR(remaining_s(centred(0.16), 0.05, 0.008), 0.038, 1e-12);
  EXPECT_DOUBLE_EQ(remaining_s(centred(0.06), 0.005, 0.008), 0);
}

TEST(TalarisPhasePlane, TheSmallestPulsesHaveTheRateOfTheThesisThruster) {
  const Thrusters t;
  const Body body;
  const double couple = 2 * t.force_N * t.side_y_m / body.inertia_x_kg_m2 * t.min_on_s;
  EXPECT_NEAR(couple / kDegree, 17.7, 0.05);
  EXPECT_NEAR(2 * 40 * t.side_y_m / body.inertia_x_kg_m2 * t.min_on_s / kDegree, 12.2, 0.05);
  const Gains g;
  // one jet for less than a couple's smallest pulse, two for more
  RollFire fire = phase_plane(0, 10 * kDegree, t.force_N, body, t, g);
  EXPECT_FALSE(fire.couple);
  EXPECT_LT(fire.on_s, 0);
  EXPECT_GE(-fire.on_s, t.min_on_s);
  fire = phase_plane(0, -25 * kDegree, t.force_N, body, t, g);
  EXPECT_TRUE(fire.couple);
  EXPECT_GT(fire.on_s, 0);
  EXPECT_EQ(phase_plane(kDegree, 2 * kDegree, t.force_N, body, t, g).on_s, 0);  // dead band
}

RC_GTEST_PROP(TalarisPhasePlane, EveryPulseIsOneAValveCanDoAndTurnsBack, ()) {
  const Thrusters t;
  const double e = any(4), w = any(2);
  const Gains g;
  const RollFire fire = phase_plane(e, w, t.force_N, Body{}, t, g);
  const double on = std::abs(fire.on_s);
  RC_ASSERT(on == 0 || (on >= t.min_on_s && on <= t.max_on_s) || on == t.long_on_s);
  const double a = 2 * t.force_N * t.side_y_m / Body{}.inertia_x_kg_m2;
  if (on > 0) RC_ASSERT(fire.on_s * (wanted_roll_rate(e, a, g) - w) > 0);
  RC_ASSERT(e * wanted_roll_rate(e, a, g) <= 0);
  RC_ASSERT(std::abs(wanted_roll_rate(e, a, g)) <= g.roll_rate_limit_rad_s);
}

TEST(TalarisLateral, PulsesTooShortToFireAreCarriedOverUntilTheyMakeOne) {
  SideJets jets;
  const Thrusters t;
  const Body body;
  const Gains g;
  double given = 0;
  int fired = 0;
  for (int n = 0; n < 200; ++n) {
    const auto on = jets.step(5, 0, {}, body, t, g);  // 1 N s a frame; the least pulse is 4.6 N s
    for (std::size_t i = 0; i < 4; ++i) {
      if (on[i] > 0) {
        EXPECT_GE(on[i], t.min_on_s);
        EXPECT_EQ(kSidePush[i], 1);
        ++fired;
      }
      given += kSidePush[i] * t.force_N * on[i];
    }
  }
  EXPECT_EQ(fired, 80);  // every fifth frame
  EXPECT_NEAR(given + jets.carry_N_s(), 200, 1e-9);
}

TEST(TalarisLateral, WhileThePairFiresRollGoesByDifferential) {
  SideJets jets;
  const auto plus = jets.step(60, 1, {}, Body{}, Thrusters{}, Gains{});
  EXPECT_GT(plus[3], plus[0]);  // 8 longer than 2: +roll
  EXPECT_GT(plus[0], 0);
  EXPECT_EQ(plus[1], 0);
  EXPECT_NEAR(plus[0] + plus[3], 60 * kFrame_s / 58, 1e-12);
  jets.reset();
  const auto minus = jets.step(-60, 1, {}, Body{}, Thrusters{}, Gains{});
  EXPECT_GT(minus[1], minus[2]);  // 4 longer than 6
}

// Otherwise roll would fire first, whenever it asks for more than the longest pulse leaves.
TEST(TalarisLateral, AtItsLongestPulseThePairKeepsRoomForRoll) {
  const Thrusters t;
  const Body body;
  Gains g;
  g.lateral_carry_N_s = 50;
  for (int n = 1; n <= 100; ++n) {
    const double d_s = 0.0005 * n;
    const double roll_rad_s2 = d_s * 2 * t.force_N * t.side_y_m / (kFrame_s * body.inertia_x_kg_m2);
    SideJets jets;
    const auto on = jets.step(100, roll_rad_s2, {0.05, true}, body, t, g);
    EXPECT_NEAR(on[3] - on[0], d_s, 1e-9);
    EXPECT_NEAR(on[3], t.max_on_s, 1e-9);
    EXPECT_EQ(on[1], 0);
  }
}

RC_GTEST_PROP(TalarisLateral, PulsesForAnyDemandCanBeExecuted, ()) {
  SideJets jets;
  const Thrusters t;
  for (int n = 0; n < 20; ++n) {
    RollFire fire;
    if (*rc::gen::arbitrary<bool>()) fire = {0.04 + 0.001 * *rc::gen::inRange(0, 121), true};
    fire.couple = *rc::gen::arbitrary<bool>();
    const auto on = jets.step(any(300), any(20), fire, Body{}, t, Gains{});
    for (const double s : on) RC_ASSERT(s == 0 || (s >= t.min_on_s && s <= t.long_on_s));
    RC_ASSERT(std::abs(jets.carry_N_s()) <= Gains{}.lateral_carry_N_s);
  }
}

TEST(TalarisLateral, TiltBringsTheVehicleBackAndIsLimited) {
  const Gains g;
  EXPECT_LT(tilt_for_y(1, 0, g), 0);
  EXPECT_DOUBLE_EQ(tilt_for_y(-100, 0, g), g.lateral_max_tilt_rad);
  EXPECT_DOUBLE_EQ(tilt_for_y(kNaN, 0, g), 0);
}

}  // namespace
}  // namespace lss::gnc::talaris
