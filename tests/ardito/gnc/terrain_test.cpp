// Which sign of the 3-D correction is right (E7): the left side of the rover climbs a smooth step,
// its true hub speeds come from geometry alone, and the correction is judged by how close it gets.

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <Eigen/LU>
#include <cmath>
#include <cstdio>

#include "gnc/ardito/rocker_bogie.h"

namespace lss::gnc::ardito::test {
namespace {

constexpr Geometry kGeometry;
constexpr double kSpeed_m_s = 0.5;

struct Step {
  double height_m;
  double width_m;  // of the logistic curve
  double operator()(double x_m) const { return height_m / (1 + std::exp(-x_m / width_m)); }
};

// Height of the left pivot, absolute pitch of left rocker and bogie when the pivot is at x.
struct LeftSide {
  double height_m = 0;
  double rocker_rad = 0;
  double bogie_rad = 0;
};

// The kinematics of wheel_poses() with the left rocker at 2 beta against the ground: the chassis
// pitches by half of it, so the right side stays level.
WheelPoses poses_of(const LeftSide& left) {
  return wheel_poses({.beta_rad = left.rocker_rad / 2,
                      .rho1_rad = left.bogie_rad - left.rocker_rad,
                      .rho2_rad = 0},
                     kGeometry);
}

struct World {
  PerWheel<double> x_m{};
  PerWheel<double> z_m{};  // up
};

World in_world(const LeftSide& left, double pivot_x_m) {
  // rocker turned by its absolute pitch: as if it were beta of a chassis that stays level
  const WheelPoses p = wheel_poses(
      {.beta_rad = left.rocker_rad, .rho1_rad = left.bogie_rad - left.rocker_rad}, kGeometry);
  World world;
  for (const std::size_t i : {0U, 2U, 4U}) {
    world.x_m[i] = pivot_x_m + p.x_m[i] + kGeometry.f_m;
    world.z_m[i] = left.height_m - p.z_m[i];
    world.x_m[i + 1] = pivot_x_m;  // the right side rolls on flat ground
  }
  return world;
}

LeftSide settle(const Step& step, double pivot_x_m, LeftSide guess) {
  const auto errors = [&](const LeftSide& left) {
    const World w = in_world(left, pivot_x_m);
    return Eigen::Vector3d(w.z_m[0] - step(w.x_m[0]), w.z_m[2] - step(w.x_m[2]),
                           w.z_m[4] - step(w.x_m[4]));
  };
  for (int n = 0; n < 50; ++n) {
    const Eigen::Vector3d e = errors(guess);
    if (e.norm() < 1e-13) break;
    Eigen::Matrix3d j;
    constexpr double kStep = 1e-7;
    j.col(0) = (errors({guess.height_m + kStep, guess.rocker_rad, guess.bogie_rad}) - e) / kStep;
    j.col(1) = (errors({guess.height_m, guess.rocker_rad + kStep, guess.bogie_rad}) - e) / kStep;
    j.col(2) = (errors({guess.height_m, guess.rocker_rad, guess.bogie_rad + kStep}) - e) / kStep;
    const Eigen::Vector3d d = j.inverse() * e;
    guess = {guess.height_m - d[0], guess.rocker_rad - d[1], guess.bogie_rad - d[2]};
  }
  return guess;
}

// Root mean square of (corrected - true) hub speed over the climbing wheels and the whole step.
double error_mm_s(const Step& step, double sign) {
  constexpr double kDt = 0.01;
  double sum = 0;
  int count = 0;
  LeftSide left = settle(step, -1, {0.37, 0, 0});
  WheelPoses before = poses_of(left);
  World world_before = in_world(left, -1);
  for (double x = -1; x < 1; x += kSpeed_m_s * kDt) {
    left = settle(step, x, left);
    const WheelPoses now = poses_of(left);
    const World world = in_world(left, x);
    if (x > -1) {
      for (const std::size_t i : {0U, 2U, 4U}) {
        const double truth =
            std::hypot(world.x_m[i] - world_before.x_m[i], world.z_m[i] - world_before.z_m[i]) /
            kDt;
        const double guess =
            sign == 0 ? kSpeed_m_s
                      : rim_speed_m_s(kSpeed_m_s, direction(0), (now.x_m[i] - before.x_m[i]) / kDt,
                                      (now.z_m[i] - before.z_m[i]) / kDt, sign);
        sum += (guess - truth) * (guess - truth);
        ++count;
      }
    }
    before = now;
    world_before = world;
  }
  return std::sqrt(sum / count) * 1000;
}

TEST(Terrain, PlusHalvesTheErrorOfNoCorrectionAndMinusIsWorseThanNone) {
  std::printf("hub speed error, mm/s:  none   minus   plus\n");
  for (const double height_m : {0.10, 0.15, 0.20}) {
    const Step step{height_m, 0.06};
    const double none = error_mm_s(step, 0), minus = error_mm_s(step, -1),
                 plus = error_mm_s(step, 1);
    std::printf("step of %3.0f mm:       %6.1f  %6.1f  %6.1f\n", height_m * 1000, none, minus,
                plus);
    EXPECT_GT(none, 10);
    EXPECT_GT(minus, 1.2 * none) << height_m;
    EXPECT_LT(plus, 0.6 * none) << height_m;
  }
}

}  // namespace
}  // namespace lss::gnc::ardito::test
