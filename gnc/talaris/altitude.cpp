#include "gnc/talaris/altitude.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "gnc/math.h"
#include "gnc/talaris/pwm.h"

namespace lss::gnc::talaris {
namespace {

constexpr double kMinLiftShare = 0.7;    // of the lift for height, when attitude needs some of it
constexpr double kStandsBelow_m = 0.03;  // and m/s
constexpr double kMaxIntegral_m_s2 = 1.5;
// On the ground: how far below hovering the lift begins, and how fast it rises.
constexpr double kBelowHover_m_s2 = 0.6, kLiftOff_m_s3 = 0.3;

// Angle, rate, acceleration after `dt` of the constant command u.
struct Axis {
  double angle = 0, rate = 0, acceleration = 0;
};
Axis after(const Axis& x, double u, double dt, double lag) noexcept {
  const double a = math::exp(-dt / lag), b = lag * (1 - a);
  return {x.angle + dt * x.rate + (lag * dt - lag * b) * x.acceleration +
              (dt * dt / 2 - lag * dt + lag * b) * u,
          x.rate + b * x.acceleration + (dt - b) * u, a * x.acceleration + (1 - a) * u};
}

}  // namespace

Eigen::Vector4d fan_attitude_gains(double lag_s, double pole_rad_s) noexcept {
  // columns of A and B by the response to each state and to the command
  Eigen::Matrix4d A = Eigen::Matrix4d::Zero();
  Eigen::Vector4d B;
  const auto column = [&](const Axis& x, double u) {
    const Axis y = after(x, u, kFrame_s, lag_s);
    return Eigen::Vector4d(0, y.angle, y.rate, y.acceleration);
  };
  A(0, 0) = 1;
  A.col(1) = column({1, 0, 0}, 0);
  A.col(2) = column({0, 1, 0}, 0);
  A.col(3) = column({0, 0, 1}, 0);
  A(0, 1) = kFrame_s;
  B = column({}, 1);

  Eigen::Matrix4d controllable, polynomial = Eigen::Matrix4d::Identity();
  Eigen::Vector4d c = B;
  for (int i = 0; i < 4; ++i) {
    controllable.col(i) = c;
    c = A * c;
    polynomial = polynomial * (A - math::exp(-pole_rad_s * kFrame_s) * Eigen::Matrix4d::Identity());
  }
  const Eigen::RowVector4d last(0, 0, 0, 1);
  const Eigen::Matrix4d inverse = controllable.inverse();
  return (last * inverse * polynomial).transpose();
}

FanFlight::FanFlight(const Parameters& parameters, const Gains& gains) noexcept
    : body_(parameters.body), fans_(parameters.fans), gains_(gains) {
  set_gains(gains);
}

void FanFlight::set_gains(const Gains& gains) noexcept {
  gains_ = gains;
  attitude_gains_ = fan_attitude_gains(fans_.lag_s, gains.fan_attitude_pole_rad_s);
}

void FanFlight::begin(bool on_ground) noexcept {
  ground_m_s2_ = on_ground ? -kBelowHover_m_s2 : 0;
  height_integral_ = integral_y_ = integral_z_ = command_y_ = command_z_ = 0;
}

PerFan FanFlight::step(const FanHeight& now, double target_height_m, double target_speed_m_s,
                       double mass_kg, double tilt_y_rad, double tilt_z_rad,
                       const Vector3& rate_B_rad_s, const PerFan& measured_rpm, double offset_s,
                       double disturbance_y, double disturbance_z) noexcept {
  const double most = fan_thrust_N(fans_.max_rpm, fans_);
  PerFan thrust{};
  for (std::size_t i = 0; i < kFans; ++i) thrust[i] = fan_thrust_N(measured_rpm[i], fans_);
  const double lift = thrust[0] + thrust[1] + thrust[2] + thrust[3];

  // height, at the time when the lag has passed
  const double ahead = offset_s + kFrame_s / 2 + fans_.lag_s;
  // a standing vehicle does not fall
  const bool stands = now.height_m < kStandsBelow_m && std::abs(now.speed_m_s) < kStandsBelow_m;
  const double acceleration =
      std::clamp(lift / mass_kg - kGravity_m_s2 + now.bias_m_s2, stands ? 0.0 : -3.0, 3.0);
  const double height = now.height_m + now.speed_m_s * ahead;
  const double speed = now.speed_m_s + acceleration * ahead;
  const bool place = std::isfinite(target_height_m);
  const double speed_error = target_speed_m_s - speed;
  const double height_error = place ? target_height_m + target_speed_m_s * ahead - height : 0;
  double wanted = gains_.height_kp_1_s2 * height_error + gains_.height_kd_1_s * speed_error +
                  height_integral_ - now.bias_m_s2;
  if (!std::isfinite(wanted)) wanted = -0.4;  // no height known: sinks slowly
  const double ceiling = kFans * most / mass_kg - kGravity_m_s2;
  const double e = place ? gains_.height_ki_1_s3 * (target_height_m - now.height_m)
                         : 2 * gains_.height_ki_1_s3 * (target_speed_m_s - now.speed_m_s);
  const bool leaves = stands && place && target_height_m > now.height_m;
  if (leaves)
    wanted = ground_m_s2_ = std::min(ground_m_s2_ + kLiftOff_m_s3 * kFrame_s, kMaxIntegral_m_s2);
  const bool stuck = leaves || (wanted >= ceiling && e > 0) || (wanted <= -3 && e < 0);
  if (std::isfinite(e) && !stuck) {
    height_integral_ =
        std::clamp(height_integral_ + e * kFrame_s, -kMaxIntegral_m_s2, kMaxIntegral_m_s2);
  }
  wanted = std::clamp(wanted, -3.0, ceiling);
  double each = mass_kg * (wanted + kGravity_m_s2) / kFans;

  // attitude
  double moment_y = -body_.inertia_y_kg_m2 * disturbance_y;
  double moment_z = -body_.inertia_z_kg_m2 * disturbance_z;
  const double wy = rate_B_rad_s.y(), wz = rate_B_rad_s.z();
  const bool attitude = std::isfinite(tilt_y_rad + tilt_z_rad + wy + wz);
  if (attitude) {
    double my = 0, mz = 0;
    for (std::size_t i = 0; i < kFans; ++i) {
      my += kLiftZ[i] * fans_.z_m * thrust[i];
      mz -= kLiftY[i] * fans_.y_m * thrust[i];
    }
    const auto command = [&](double angle, double rate, double accel, double before,
                             double& integral) {
      const Axis x = after({angle, rate, accel}, before, offset_s, fans_.lag_s);
      integral = std::clamp(integral + kFrame_s * angle, -0.3, 0.3);
      return -attitude_gains_.dot(Eigen::Vector4d(integral, x.angle, x.rate, x.acceleration));
    };
    moment_y = body_.inertia_y_kg_m2 *
               command(tilt_y_rad, wy, my / body_.inertia_y_kg_m2, command_y_, integral_y_);
    moment_z = body_.inertia_z_kg_m2 *
               command(tilt_z_rad, wz, mz / body_.inertia_z_kg_m2, command_z_, integral_z_);
  }
  double y = moment_y / (kFans * fans_.z_m), z = moment_z / (kFans * fans_.y_m);
  // a moment needs room above and below the mean; the lift is reduced, but not completely
  const double difference = std::abs(y) + std::abs(z);
  const double lowest = kMinLiftShare * std::min(each, most);
  each = std::clamp(std::min(each, most - difference), lowest, most);
  const double room = std::min(each, most - each);
  if (difference > room) {
    y *= room / difference;
    z *= room / difference;
  }
  command_y_ = attitude ? y * kFans * fans_.z_m / body_.inertia_y_kg_m2 : 0;
  command_z_ = attitude ? z * kFans * fans_.y_m / body_.inertia_z_kg_m2 : 0;

  PerFan rpm{};
  for (std::size_t i = 0; i < kFans; ++i) {
    const double force = each + kLiftZ[i] * y - kLiftY[i] * z;
    rpm[i] = std::min(std::sqrt(std::max(force, 0.0) / fans_.thrust_N_per_rpm2), fans_.max_rpm);
  }
  return rpm;
}

}  // namespace lss::gnc::talaris
