#include "tests/ardito/gnc/rover.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace lss::gnc::ardito::test {
namespace {

double to(double value, double step) { return std::round(value / step) * step; }

// The reading of a sensor, from the truth and its last reading.
double sensed(Broken broken, double truth, double before) {
  if (broken == Broken::zero) return 0;
  return broken == Broken::stuck && std::isfinite(before) ? before : truth;
}

double no_load(double speed_rad_s) { return 0.05 + 0.01 * std::abs(speed_rad_s); }

}  // namespace

Rover::Rover(unsigned seed, const Parameters& parameters)
    : parameters_(parameters), redundant_(parameters), random_(seed) {
  request.speed_limit_m_s = 1;
  poses_ = wheel_poses({}, parameters_.geometry);
}

double Rover::gauss(double sigma) { return sigma * normal_(random_); }

double Rover::true_yaw_rate_rad_s() const {
  return yaw_rate_rad_s({direction_, v_m_s_}, parameters_.geometry);
}

void Rover::run(double seconds) {
  const int frames = static_cast<int>(std::lround(seconds / kFrame_s));
  for (int n = 0; n < frames; ++n) step();
}

bool Rover::settle(double seconds) {
  const double wanted = request.run ? request.speed * request.speed_limit_m_s : 0;
  for (double t = 0; t < seconds; t += kFrame_s) {
    step();
    double v = v_m_s_;
    double asked = wanted * (1 - std::abs(std::sin(5 * request.sigma_rad)));
    if (request.parking) {
      v = true_yaw_rate_rad_s() * parameters_.parking_length_m;
      asked = wanted;
    }
    if (command.busy == 0 && std::abs(v - asked) < 0.03) return true;
  }
  return false;
}

void Rover::step() {
  move();
  measure();
  if (tamper != nullptr) tamper(measured);
  command = redundant_.step(request, measured);
}

// Profile position: 0.5 rad/s and 2 rad/s2 at most, from the order to the next sample.
void Rover::steer(std::size_t i, double goal_rad) {
  constexpr double kStep_s = 0.001, kMost_rad_s = 0.5, kMost_rad_s2 = 2;
  for (double t = 0; t < 0.9 * kFrame_s; t += kStep_s) {
    const double way = goal_rad - steering_rad_[i];
    const double speed = std::min(std::sqrt(2 * kMost_rad_s2 * std::abs(way)), kMost_rad_s);
    const double change = std::copysign(speed, way) - steering_rad_s_[i];
    steering_rad_s_[i] += std::clamp(change, -kMost_rad_s2 * kStep_s, kMost_rad_s2 * kStep_s);
    steering_rad_[i] += steering_rad_s_[i] * kStep_s;
  }
}

void Rover::move() {
  const Geometry& g = parameters_.geometry;
  ++frame_;
  // suspension: the ground under a rover that moves
  const double way = std::min(std::abs(v_m_s_) / 0.4, 1.0);
  for (std::size_t i = 0; i < rocker_rad_.size(); ++i) {
    rocker_rate_rad_s_[i] = 0.9 * rocker_rate_rad_s_[i] + gauss(0.3 * noise.ground_rad);
    rocker_rad_[i] += way * (kFrame_s * rocker_rate_rad_s_[i] - 0.03 * rocker_rad_[i]);
  }
  const WheelPoses poses = wheel_poses({rocker_rad_[0], rocker_rad_[1], rocker_rad_[2]}, g);
  for (std::size_t i = 0; i < kWheels; ++i) {
    vx_m_s_[i] = (poses.x_m[i] - poses_.x_m[i]) / kFrame_s;
    vz_m_s_[i] = (poses.z_m[i] - poses_.z_m[i]) / kFrame_s;
  }
  poses_ = poses;

  // steering: 0.5 rad/s at most
  for (std::size_t i = 0; i < kSteered; ++i) {
    if (command.steering_known == 0 || steering_faults[i].motor) continue;
    steer(i, command.steering_rad[i]);
  }
  Direction sum{0, 0};
  for (std::size_t i = 0; i < kSteered; ++i) {
    Direction d = direction_from_steering(kWheelOfSteered[i], direction(steering_rad_[i]), g);
    if (d.sin * sum.sin + d.cos * sum.cos < 0) d = {-d.sin, -d.cos};
    sum = {sum.sin + d.sin, sum.cos + d.cos};
  }
  const double length = std::hypot(sum.sin, sum.cos);
  direction_ = {sum.sin / length, sum.cos / length};
  if (direction_.sin < -0.7) direction_ = {-direction_.sin, -direction_.cos};

  // rover speed from each drive; wheels that cannot turn slow it down a little
  PerWheel<bool> engaged{}, drives{};
  double v = 0, weight = 0;
  int dragged = 0;
  for (std::size_t i = 0; i < kWheels; ++i) {
    const WheelFaults& f = wheel_faults[i];
    engaged[i] = contains(command.clutches_engaged, i) && !f.clutch;
    const bool powered = !contains(command.motors_stopped, i) && !f.motor_dead;
    const bool held = f.motor_blocked || (f.reduction && engaged[i]);
    const double target = powered && !held ? command.wheel_rad_s[i] : 0;
    motor_rad_s_[i] += 0.97 * (target - motor_rad_s_[i]);
    if (held || !powered) motor_rad_s_[i] = 0;
    drives[i] = engaged[i] && powered && !held;
    if (f.reduction || (engaged[i] && f.motor_blocked)) ++dragged;
    if (!drives[i]) continue;
    const std::size_t s = kSteeredOfWheel[i];
    const Direction steering = s < kSteered ? direction(steering_rad_[s]) : Direction{};
    const double hub =
        plane_speed_m_s(motor_rad_s_[i] * g.wheel_radius_m, steering, vx_m_s_[i], vz_m_s_[i], 1);
    const double ratio = hub_ratio(i, direction_, g);
    v += hub * ratio;
    weight += ratio * ratio;
  }
  const double aim = weight > 0 ? v / weight * (1 - 0.02 * dragged) : 0;
  v_m_s_ += 0.7 * (aim - v_m_s_);

  const PlaneWheels rolling = ackermann({direction_, v_m_s_}, g);
  for (std::size_t i = 0; i < kWheels; ++i) {
    const WheelFaults& f = wheel_faults[i];
    const double along = rolling.hub_m_s[i] / g.wheel_radius_m;
    if (f.reduction) {
      wheel_rad_s_[i] = 0;
    } else if (engaged[i] && f.motor_dead) {
      wheel_rad_s_[i] = motor_rad_s_[i] = 0.97 * along;
    } else {
      wheel_rad_s_[i] = engaged[i] ? motor_rad_s_[i] : 0.97 * along;
    }
    // current: the share of the load that the ground puts on this wheel, more when it slips ahead
    load_[i] = 0.8 * load_[i] + 0.2 * (drive_load + gauss(noise.load * 3));
    const double sense = std::copysign(1.0, motor_rad_s_[i]);
    const double slip = (motor_rad_s_[i] - along) * sense;
    const bool moving = std::abs(motor_rad_s_[i]) > 0.05;
    current_[i] = moving ? no_load(motor_rad_s_[i]) : 0;
    if (drives[i] && moving) current_[i] += load_[i] + std::clamp(0.5 * slip, -0.4, 0.4);
    if (f.motor_blocked || (f.reduction && engaged[i])) current_[i] = 1.2;
    if (f.motor_dead || contains(command.motors_stopped, i)) current_[i] = 0;
    current_[i] *= sense;
  }
}

void Rover::measure() {
  const auto now = [](double value) { return Reading{value, 0.01}; };
  for (std::size_t i = 0; i < kWheels; ++i) {
    WheelMeasured& m = measured.wheels[i];
    const WheelFaults& f = wheel_faults[i];
    const double rpm = motor_rad_s_[i] / kRadPerSecondPerRpm;
    const double motor = to(rpm + gauss(noise.motor_rpm), 0.02) * kRadPerSecondPerRpm;
    const double hall = to(rpm + gauss(noise.motor_rpm), 0.02) * kRadPerSecondPerRpm;
    const double reduction =
        to(wheel_rad_s_[i] / kRadPerSecondPerRpm + gauss(noise.reduction_rpm), 0.01) *
        kRadPerSecondPerRpm;
    m.motor_rad_s = now(sensed(f.motor_encoder, motor, m.motor_rad_s.value));
    m.hall_rad_s = now(sensed(f.hall, hall, m.hall_rad_s.value));
    m.reduction_rad_s = now(sensed(f.reduction_encoder, reduction, m.reduction_rad_s.value));
    m.current = now(to(current_[i] + gauss(noise.current), 0.001));
    m.temperature_C = {30, 0.5};
  }
  for (std::size_t i = 0; i < kSteered; ++i) {
    SteeringMeasured& m = measured.steering[i];
    const SteeringFaults& f = steering_faults[i];
    const double motor = to(steering_rad_[i] + gauss(noise.steering_rad), 2e-6);
    const double reduction = to(steering_rad_[i] + gauss(noise.steering_rad), 1e-4);
    m.motor_rad = now(sensed(f.motor_encoder, motor, m.motor_rad.value));
    m.reduction_rad = now(sensed(f.reduction_encoder, reduction, m.reduction_rad.value));
    m.current = now(0.1);
  }
  measured.beta_rad = now(to(rocker_rad_[0] + gauss(noise.rocker_rad), 1e-4));
  measured.rho1_rad = now(to(rocker_rad_[1] + gauss(noise.rocker_rad), 1e-4));
  measured.rho2_rad = now(to(rocker_rad_[2] + gauss(noise.rocker_rad), 1e-4));
  const double forward = v_m_s_ * direction_.cos, right = v_m_s_ * direction_.sin;
  const double speed = std::copysign(std::hypot(forward, right), forward);
  measured.imu.speed_m_s = now(to(speed + gauss(noise.imu_m_s), 0.001));
  const double sigma = std::abs(speed) < 0.005 ? 0 : std::atan(right / forward);
  measured.imu.sigma_rad = now(std::clamp(sigma + gauss(0.01), -kPi / 2, kPi / 2));
  measured.imu.yaw_rate_rad_s = now(to(true_yaw_rate_rad_s() + gauss(0.004), 0.001));
  measured.imu.counter = frame_ % 65536;
}

Rover driving_rover(unsigned seed, double speed, double sigma_deg, double then_s) {
  Rover rover(seed);
  rover.request.run = true;
  rover.request.speed = speed;
  rover.request.sigma_rad = sigma_deg * kDegree;
  if (!rover.settle(30)) throw std::runtime_error("the rover does not settle");
  rover.run(then_s);
  return rover;
}

int frames_until(Rover& rover, int most, const std::function<bool(const Command&)>& condition) {
  for (int n = 1; n <= most; ++n) {
    rover.step();
    if (condition(rover.command)) return n;
  }
  return most + 1;
}

}  // namespace lss::gnc::ardito::test
