// E-guidance: exact at the target, once a second, and never with less than 1.5 s to go.

#include "gnc/talaris/guidance.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

namespace lss::gnc::talaris {
namespace {

Vector3 any_vector(int range) {
  const auto one = [&] { return *rc::gen::inRange(-100 * range, 100 * range + 1) * 0.01; };
  const double x = one(), y = one(), z = one();
  return {x, y, z};
}

RC_GTEST_PROP(TalarisGuidance, ThePolynomialTakesPositionAndVelocityToTheTarget, ()) {
  const Vector3 r = any_vector(50), v = any_vector(5);
  const double T = *rc::gen::inRange(10, 300) * 0.1;
  const Target target{any_vector(50), any_vector(5), T};
  const Coefficients c = e_guidance(r, v, target, T);
  const Vector3 v_end = v + c.c0_m_s2 * T + c.c1_m_s3 * (T * T / 2);
  const Vector3 r_end = r + v * T + c.c0_m_s2 * (T * T / 2) + c.c1_m_s3 * (T * T * T / 6);
  RC_ASSERT((v_end - target.velocity_m_s).norm() < 1e-9);
  RC_ASSERT((r_end - target.position_m).norm() < 1e-9);
}

TEST(TalarisGuidance, RestToRestBeginsWithSixTimesTheWayOverTimeSquared) {
  const Coefficients c =
      e_guidance(Vector3::Zero(), Vector3::Zero(), {{0, 0, 30}, Vector3::Zero(), 10}, 10);
  EXPECT_DOUBLE_EQ(c.c0_m_s2.z(), 1.8);
  EXPECT_DOUBLE_EQ(c.c1_m_s3.z(), -0.36);
}

TEST(TalarisGuidance, IsComputedOnceASecondAndItsGainStaysBoundedAtTheTarget) {
  Guidance guidance;
  guidance.aim({{2, 0, 0}, Vector3::Zero(), 4});
  const double first = guidance.step(Vector3::Zero(), Vector3::Zero(), 0).x();
  EXPECT_NEAR(first, 6 * 2 / 16.0, 1e-12);
  for (int n = 1; n < 5; ++n) {  // a step of the position is not seen before the second is over
    EXPECT_NEAR(guidance.step({1, 0, 0}, Vector3::Zero(), 0).x(), first * (1 - 2 * n * 0.2 / 4),
                1e-9);
  }
  EXPECT_NEAR(guidance.step({1, 0, 0}, Vector3::Zero(), 0).x(), 6 * 1 / 9.0, 1e-9);
  for (int n = 0; n < 100; ++n) guidance.step({2, 0, 0}, Vector3::Zero(), 0);
  guidance.aim({{2, 0, 0}, Vector3::Zero(), 0.01});
  EXPECT_NEAR(guidance.step({1, 0, 0}, Vector3::Zero(), 0).x(), 6 / (1.5 * 1.5), 0.02);
}

TEST(TalarisGuidance, AMovingTargetIsFollowedBeyondItsTime) {
  Guidance guidance;
  guidance.aim({{0.15, 0, 0}, {-0.15, 0, 0}, 2});
  Vector3 r(1, 0, 0), v(-0.4, 0, 0);
  for (int n = 0; n < 60; ++n) {
    const Vector3 a = guidance.step(r, v, 0.1);
    r += v * kFrame_s + a * (kFrame_s * kFrame_s / 2);
    v += a * kFrame_s;
  }
  EXPECT_NEAR(v.x(), -0.15, 0.002);
  EXPECT_NEAR(r.x(), 0.15 - 0.15 * 10, 0.02);
}

TEST(TalarisGuidance, ThrustIsWhatGravityAndFansLeave) {
  const Vector3 hover = gas_force_N(Vector3::Zero(), 45, {367.9, 0, 0});
  EXPECT_NEAR(hover.x(), 73.4, 0.05);
  const Vector3 lift_off = gas_force_N({1, 0, 0}, 45, Vector3::Zero());
  EXPECT_NEAR(lift_off.x(), 486.4, 0.15);  // TALARIS thesis 2.3.3
}

}  // namespace
}  // namespace lss::gnc::talaris
