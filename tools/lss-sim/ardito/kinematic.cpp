#include "tools/lss-sim/ardito/kinematic.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace lss::sim::ardito {
namespace {

using namespace dimensions;

constexpr double kFriction = 0.3;
constexpr double kFollow_s = 0.02;  // time constant of the body's velocity
constexpr double kLeastWeight = 1e-6;
constexpr double kResting_rad_s = 1e-3;
constexpr double kHeight_m =
    0.525;  // of the body's origin: height above the axles, plus the wheel radius
constexpr double kSteeringStop_rad = 1.3;

// Relative to the centre of mass, x ahead, y left.
constexpr std::array<double, 3> kAxles_m = {kFront_m - kCentre_m, -kCentre_m, -kRear_m - kCentre_m};
constexpr double wheel_x_m(std::size_t wheel) { return kAxles_m[wheel / 2]; }
constexpr double wheel_y_m(std::size_t wheel) {
  return wheel % 2 == 0 ? kTrack_m / 2 : -kTrack_m / 2;
}

}  // namespace

KinematicRover::KinematicRover(double gravity_m_s2) : load_N_(kMass_kg * gravity_m_s2 / kWheels) {
  loads_N_.fill(load_N_);
}

double KinematicRover::steering_rad(std::size_t wheel) const {
  const auto* at = std::ranges::find(kSteeredWheels, wheel);
  return at == kSteeredWheels.end()
             ? 0
             : steering_[static_cast<std::size_t>(at - kSteeredWheels.begin())].angle_rad;
}

double KinematicRover::ground_m_s(std::size_t wheel) const {
  const double angle = steering_rad(wheel);
  const double ahead = rate_.x() - rate_.z() * wheel_y_m(wheel);
  const double left = rate_.y() + rate_.z() * wheel_x_m(wheel);
  return ahead * std::cos(angle) + left * std::sin(angle);
}

// The body motion that fits the treads best. No wheel slips sideways.
void KinematicRover::agree(const std::array<ShaftDrive, kWheels>& wheels) {
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  const double traction_Nm = kFriction * load_N_ * kWheelRadius_m;
  for (std::size_t i = 0; i < kWheels; ++i) {
    const double angle = steering_rad(i), c = std::cos(angle), s = std::sin(angle);
    const double pulls = std::min(wheels[i].torque_limit_Nm / traction_Nm, 1.0);
    const double weight = std::max(pulls * pulls * pulls, kLeastWeight);
    const Eigen::Vector3d along(c, s, -wheel_y_m(i) * c + wheel_x_m(i) * s);
    const Eigen::Vector3d across(-s, c, wheel_y_m(i) * s + wheel_x_m(i) * c);
    normal += weight * along * along.transpose() + across * across.transpose();
    right += weight * wheels[i].velocity_rad_s * kWheelRadius_m * along;
  }
  const Eigen::Vector3d wanted = normal.ldlt().solve(right);
  const Eigen::Vector3d before = rate_;
  rate_ += (wanted - rate_) * (kStep_s / kFollow_s);
  pull_Nm_ = kMass_kg * (rate_.x() - before.x()) / kStep_s * kWheelRadius_m / kWheels;
}

void KinematicRover::step(const std::array<ShaftDrive, kWheels>& wheels,
                          const std::array<ShaftDrive, kSteered>& steering) {
  for (std::size_t i = 0; i < kSteered; ++i) {
    ShaftState& shaft = steering_[i];
    shaft.velocity_rad_s = steering[i].velocity_rad_s;
    shaft.angle_rad = std::clamp(shaft.angle_rad + shaft.velocity_rad_s * kStep_s,
                                 -kSteeringStop_rad, kSteeringStop_rad);
    const bool turns = std::abs(shaft.velocity_rad_s) > kResting_rad_s;
    shaft.torque_Nm = turns ? std::copysign(kPatchRadius_m * load_N_, shaft.velocity_rad_s) : 0;
  }
  agree(wheels);
  x_m_ += (rate_.x() * std::cos(yaw_rad_) - rate_.y() * std::sin(yaw_rad_)) * kStep_s;
  y_m_ += (rate_.x() * std::sin(yaw_rad_) + rate_.y() * std::cos(yaw_rad_)) * kStep_s;
  yaw_rad_ += rate_.z() * kStep_s;

  const double traction_Nm = kFriction * load_N_ * kWheelRadius_m;
  for (std::size_t i = 0; i < kWheels; ++i) {
    ShaftState& wheel = wheels_[i];
    const double along_rad_s = ground_m_s(i) / kWheelRadius_m;
    const bool holds = wheels[i].torque_limit_Nm > traction_Nm / 2;
    wheel.velocity_rad_s = holds ? wheels[i].velocity_rad_s : along_rad_s;
    wheel.angle_rad += wheel.velocity_rad_s * kStep_s;
    const bool rolls = std::abs(along_rad_s) > kResting_rad_s;
    const double rolling_Nm =
        rolls ? std::copysign(kRollingResistance * load_N_ * kWheelRadius_m, along_rad_s) : 0;
    wheel.torque_Nm = holds ? std::clamp(rolling_Nm + pull_Nm_, -wheels[i].torque_limit_Nm,
                                         wheels[i].torque_limit_Nm)
                            : 0;
  }
}

double KinematicRover::slip_m_s(std::size_t wheel) const {
  return wheels_[wheel].velocity_rad_s * kWheelRadius_m - ground_m_s(wheel);
}

BodyState KinematicRover::body() const {
  const Eigen::Quaterniond attitude(Eigen::AngleAxisd(yaw_rad_, Eigen::Vector3d::UnitZ()));
  const Eigen::Vector3d velocity_B(rate_.x(), rate_.y(), 0);
  return {.position_m = {x_m_, y_m_, kHeight_m},
          .attitude = attitude,
          .velocity_m_s = attitude * velocity_B,
          .velocity_B_m_s = velocity_B,
          .yaw_rate_rad_s = rate_.z()};
}

}  // namespace lss::sim::ardito
