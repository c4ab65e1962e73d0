// The suspension's kinematics against products of homogeneous matrices, and back.

#include "gnc/ardito/rocker_bogie.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>

#include "gnc/math.h"

namespace lss::gnc::ardito::test {
namespace {

// About y, by an angle that lifts the front (z is down).
Point turned(const Direction& angle, const Point& p) {
  return {angle.cos * p.x_m + angle.sin * p.z_m, -angle.sin * p.x_m + angle.cos * p.z_m};
}

// The bogie's own angle, from the place of its middle wheel: E6.
double bogie_rad(double rocker_rad, double x_m, double z_m, const Linkage& l, const Geometry& g) {
  const Point bogie = turned(direction(rocker_rad), l.bogie_on_rocker);
  const double x = x_m - l.pivot_x_m - bogie.x_m, z = z_m - bogie.z_m;
  // the arm points k3 below the bogie's x axis; turning by an angle lifts it by as much
  return std::remainder(g.k3_rad - rocker_rad - math::atan2(z, x), 2 * kPi);
}

// From wheels 1, 3 and 4 (13.3); any pose that wheel_poses() can make, no singular one.
RockerAngles rocker_angles(const WheelPoses& poses, const Geometry& geometry) {
  // E4, E5
  const Linkage l = linkage(geometry);
  const Point& arm = l.front_on_rocker;
  const double x = poses.x_m[0] - l.pivot_x_m, z = poses.z_m[0];
  RockerAngles angles;
  angles.beta_rad = math::atan2(arm.z_m * x - arm.x_m * z, arm.x_m * x + arm.z_m * z);
  angles.rho1_rad = bogie_rad(angles.beta_rad, poses.x_m[2], poses.z_m[2], l, geometry);
  angles.rho2_rad = bogie_rad(-angles.beta_rad, poses.x_m[3], poses.z_m[3], l, geometry);
  return angles;
}

constexpr Geometry kGeometry;

TEST(RockerBogie, NominalPoseIsTheThesisTable) {
  const WheelPoses poses = wheel_poses({}, kGeometry);
  const double x_mm[] = {465.12, 465.12, -99.14, -99.14, -635, -635};
  const double z_mm[] = {377.38, 377.38, 374.92, 374.92, 375, 375};
  for (std::size_t i = 0; i < kWheels; ++i) {
    EXPECT_NEAR(poses.x_m[i] * 1000, x_mm[i], 0.02) << i;
    EXPECT_NEAR(poses.z_m[i] * 1000, z_mm[i], 0.02) << i;
  }
}

TEST(RockerBogie, PositiveBetaLiftsTheLeftFrontWheelAndLowersTheRight) {
  const WheelPoses flat = wheel_poses({}, kGeometry),
                   up = wheel_poses({.beta_rad = 0.1}, kGeometry);
  EXPECT_LT(up.z_m[0], flat.z_m[0] - 0.04);
  EXPECT_GT(up.z_m[1], flat.z_m[1] + 0.04);
}

Eigen::Isometry3d frame(double x_m, double z_m, double angle_rad) {
  return Eigen::Translation3d(x_m, 0, z_m) *
         Eigen::Isometry3d(Eigen::AngleAxisd(angle_rad, Eigen::Vector3d::UnitY()));
}

// E2, E3: chains of frames as in 13.2, with the corrected signs.
Eigen::Vector3d by_matrices(std::size_t wheel, const RockerAngles& q) {
  const Geometry& g = kGeometry;
  const bool left = is_left(wheel);
  const auto rocker = frame(-g.f_m, 0, left ? q.beta_rad : -q.beta_rad);
  const auto bogie = rocker * frame(-g.l2_m, g.l3_m, left ? q.rho1_rad : q.rho2_rad);
  if (wheel < 2) {
    return rocker *
           Eigen::Vector3d(g.l1_m * std::cos(g.k1_rad), 0, g.l6_m + g.l1_m * std::sin(g.k1_rad));
  }
  if (wheel < 4) {
    return bogie * Eigen::Vector3d(g.l4_m * std::cos(g.k3_rad), 0, g.l4_m * std::sin(g.k3_rad));
  }
  return bogie * Eigen::Vector3d(-g.l5_m, 0, g.l6_m);
}

double angle(double most_deg) {
  return *rc::gen::inRange(-10000, 10001) * 1e-4 * most_deg * kPi / 180;
}

RC_GTEST_PROP(RockerBogie, PosesAreTheProductsOfTheMatrices, ()) {
  const RockerAngles q{angle(60), angle(60), angle(60)};
  const WheelPoses poses = wheel_poses(q, kGeometry);
  for (std::size_t i = 0; i < kWheels; ++i) {
    const Eigen::Vector3d p = by_matrices(i, q);
    RC_ASSERT(std::abs(poses.x_m[i] - p.x()) < 1e-12);
    RC_ASSERT(std::abs(poses.z_m[i] - p.z()) < 1e-12);
  }
}

TEST(RockerBogie, InverseGivesBackThreeThousandPoses) {
  std::srand(1);
  const auto any = [] { return (std::rand() / (RAND_MAX + 1.0) - 0.5) * 2 * 60 * kPi / 180; };
  for (int n = 0; n < 3000; ++n) {
    const RockerAngles q{any(), any(), any()};
    const RockerAngles back = rocker_angles(wheel_poses(q, kGeometry), kGeometry);
    ASSERT_NEAR(back.beta_rad, q.beta_rad, 1e-13);
    ASSERT_NEAR(back.rho1_rad, q.rho1_rad, 1e-13);
    ASSERT_NEAR(back.rho2_rad, q.rho2_rad, 1e-13);
  }
}

// E6: printed, the quotients are singular where k3 = +-beta
TEST(RockerBogie, InverseIsNotSingularWhereTheBogieArmPointsAlongTheRocker) {
  for (const double beta : {kGeometry.k3_rad, -kGeometry.k3_rad}) {
    const RockerAngles q{beta, 0.2, -0.3};
    const RockerAngles back = rocker_angles(wheel_poses(q, kGeometry), kGeometry);
    EXPECT_NEAR(back.rho1_rad, 0.2, 1e-13);
    EXPECT_NEAR(back.rho2_rad, -0.3, 1e-13);
  }
}

TEST(Correction, FlatGroundChangesNothing) {
  // E1: 0.3 m/s at the rim of a wheel stay 0.3 m/s
  EXPECT_DOUBLE_EQ(rim_speed_m_s(0.3, direction(0), 0, 0, 1), 0.3);
  EXPECT_DOUBLE_EQ(rim_speed_m_s(-0.3, direction(0.4), 0, 0, 1), -0.3);
  EXPECT_EQ(rim_speed_m_s(0, direction(0.4), 0.1, 0.1, 1), 0);
}

RC_GTEST_PROP(Correction, FromThePlaneToTheGroundAndBack, ()) {
  const double u = *rc::gen::inRange(-1000, 1001) * 1e-3;
  const double vx = *rc::gen::inRange(-300, 301) * 1e-3, vz = *rc::gen::inRange(-300, 301) * 1e-3;
  const Direction alpha = direction(angle(57.5));
  const double sign = *rc::gen::element(1.0, -1.0);
  // a hub that suspension moves faster than the rover drives turns the wheel's direction over
  RC_PRE(std::abs(u) > std::abs(vx) || u == 0);
  const double rim = rim_speed_m_s(u, alpha, vx, vz, sign);
  RC_ASSERT(std::abs(plane_speed_m_s(rim, alpha, vx, vz, sign) - u) < 1e-6);
}

RC_GTEST_PROP(Correction, SlippingWheelsGiveNumbersToo, ()) {
  const double rim = *rc::gen::inRange(-1000, 1001) * 1e-3;
  const double v =
      plane_speed_m_s(rim, direction(angle(57.5)), *rc::gen::inRange(-3000, 3001) * 1e-3,
                      *rc::gen::inRange(-3000, 3001) * 1e-3, 1);
  RC_ASSERT(std::isfinite(v));
}

}  // namespace
}  // namespace lss::gnc::ardito::test
