// Fans: the speed loop (TALARIS thesis 5.2.2) and the attitude loop with their lag.

#include "gnc/talaris/fans.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "gnc/talaris/altitude.h"

namespace lss::gnc::talaris {
namespace {

// Four fans, not quite as believed, with a sensor of 200 rpm.
struct Rig {
  Fans fans;
  PerFan rpm{};
  PerFan full{33000, 34500, 31500, 33800};
  double lag_s = 0.3;
  PerFan measured() const {
    PerFan m{};
    for (std::size_t i = 0; i < kFans; ++i) m[i] = 200 * std::floor(rpm[i] / 200);
    return m;
  }
  void frame(const PerFan& throttle) {
    const double a = std::exp(-kFrame_s / lag_s);
    for (std::size_t i = 0; i < kFans; ++i) rpm[i] = a * rpm[i] + (1 - a) * throttle[i] * full[i];
  }
};

TEST(TalarisFans, TheRampIsFollowedAndTheSteadyErrorIsWithinTheSensorsStep) {
  Rig rig;
  FanSpeed speed(rig.fans, Gains{});
  PerFan goal;
  goal.fill(20100);
  double worst_ramp = 0, worst_steady = 0;
  for (int n = 0; n < 150; ++n) {
    const PerFan measured = rig.measured();
    rig.frame(speed.ramp(goal, 4000, measured));
    for (std::size_t i = 0; i < kFans; ++i) {
      if (n > 5 && n < 25)
        worst_ramp = std::max(worst_ramp, std::abs(rig.rpm[i] - speed.reference_rpm()[i]));
      if (n >= 100) worst_steady = std::max(worst_steady, std::abs(rig.rpm[i] - 20100));
    }
  }
  EXPECT_LT(worst_ramp, 1000);  // fans 5 % off, and slower than believed
  EXPECT_LE(worst_steady, rig.fans.rpm_quantum);
  EXPECT_NEAR(speed.reference_rpm()[0], 20100, 1);
  goal.fill(0);
  const PerFan off = speed.ramp(goal, 4000, rig.measured());
  EXPECT_EQ(off, PerFan{});
}

TEST(TalarisFans, ThrottlesStayWithinTheirRangeWithAnyMeasurement) {
  FanSpeed speed(Fans{}, Gains{});
  const double odd[] = {kNaN, -1e9, 1e9, 0, HUGE_VAL};
  for (int n = 0; n < 200; ++n) {
    PerFan command, measured;
    for (std::size_t i = 0; i < kFans; ++i) {
      command[i] = odd[(static_cast<std::size_t>(n) + i) % 5];
      measured[i] = odd[(static_cast<std::size_t>(n) * 3 + i) % 5];
    }
    for (const PerFan& out :
         {speed.direct(command, measured), speed.ramp(command, 4000, measured)}) {
      for (const double t : out) ASSERT_TRUE(t >= 0 && t <= 1);
    }
  }
}

// The sampled loop that the gains were made for, built here by fine integration.
Eigen::Matrix4d closed_loop(double lag_s, const Eigen::Vector4d& k) {
  Eigen::Matrix4d A = Eigen::Matrix4d::Identity();
  Eigen::Vector4d B = Eigen::Vector4d::Zero();
  const int steps = 20000;
  const double dt = kFrame_s / steps;
  Eigen::Matrix3d F = Eigen::Matrix3d::Identity();
  Eigen::Vector3d G = Eigen::Vector3d::Zero();
  Eigen::Matrix3d f = Eigen::Matrix3d::Zero();
  f(0, 1) = f(1, 2) = 1;
  f(2, 2) = -1 / lag_s;
  const Eigen::Vector3d g(0, 0, 1 / lag_s);
  for (int n = 0; n < steps; ++n) {
    G += dt * (f * G + g);
    F += dt * (f * F).eval();
  }
  A.bottomRightCorner<3, 3>() = F;
  A(0, 1) = kFrame_s;
  B.tail<3>() = G;
  return A - B * k.transpose();
}

// Largest magnitude of an eigenvalue, by |A^n|^(1/n); within 0.3 %. Eigen's own solver takes 15 s
// to compile.
double spectral_radius(Eigen::Matrix4d A) {
  double log_norm = 0;  // of A^n, without the power that A is scaled to
  double n = 1;
  for (int doubling = 0; doubling < 12; ++doubling) {
    A = (A * A).eval();
    n *= 2;
    const double norm = A.norm();
    A /= norm;
    log_norm = 2 * log_norm + std::log(norm);
  }
  return std::exp(log_norm / n);
}

TEST(TalarisFans, TheAttitudeLoopIsStableWithLagsFarFromTheOneBelieved) {
  const Eigen::Vector4d k = fan_attitude_gains(0.25, Gains{}.fan_attitude_pole_rad_s);
  for (const double lag : {0.15, 0.2, 0.25, 0.3, 0.35}) {
    for (const double gain : {0.7, 1.0, 1.4}) {  // of the inertia
      Eigen::Vector4d scaled = k;
      scaled.head<3>() *= gain;
      EXPECT_LT(spectral_radius(closed_loop(lag, scaled)), 0.97) << lag << ' ' << gain;
    }
  }
  // All four poles are as fast as the configured one.
  const double pole = std::exp(-Gains{}.fan_attitude_pole_rad_s * kFrame_s);
  const Eigen::Matrix4d believed = closed_loop(0.25, k);
  EXPECT_LT(spectral_radius(believed), pole + 0.05);
  EXPECT_GT(1 / spectral_radius(believed.inverse()), pole - 0.05);
}

TEST(TalarisFans, MomentsComeFromDifferencesAndNeverFromMoreThanAFanHas) {
  const Parameters p;
  FanFlight flight(p, Gains{});
  PerFan hover;
  hover.fill(rpm_for(441.3, p.fans));
  const PerFan pitch = flight.step({1, 0}, 1, 0, 45, 0.05, 0, Vector3::Zero(), hover, 0.005);
  EXPECT_LT(pitch[1], pitch[0]);  // tilted about +y: the fans at +z push less
  EXPECT_LT(pitch[2], pitch[3]);
  EXPECT_NEAR(pitch[0], pitch[3], 1e-6);
  flight.begin();
  const PerFan level = flight.step({1, 0}, 1, 0, 45, kNaN, 0.1, Vector3::Zero(), hover, 0.005);
  for (const double rpm : level) EXPECT_DOUBLE_EQ(rpm, level[0]);  // no attitude: all alike
  flight.begin();
  for (const double rpm : flight.step({1, -5}, 1, 0, 45, 1, -1, {0, 3, 3}, hover, 0.005)) {
    EXPECT_GE(rpm, 0);
    EXPECT_LE(rpm, p.fans.max_rpm);
  }
}

}  // namespace
}  // namespace lss::gnc::talaris
