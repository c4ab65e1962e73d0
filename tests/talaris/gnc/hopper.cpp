#include "tests/talaris/gnc/hopper.h"

#include <algorithm>
#include <cmath>

namespace lss::gnc::talaris::test {
namespace {

constexpr double kStep_s = 0.001;
constexpr double kFootStiffness = 15000, kFootDamping = 900, kFriction = 0.6;
constexpr double kFootY = 0.3, kFootZ = 0.4;

// Axes along and about which it can move: 1, or 0.
struct Freedom {
  Vector3 along, about;
};
Freedom freedom(Stand stand) {
  switch (stand) {
    case Stand::free: break;
    case Stand::rails: return {{0, 0, 1}, {0, 0, 0}};
    case Stand::sled: return {{0, 1, 1}, {1, 0, 0}};
    case Stand::attitude_y: return {{0, 0, 0}, {0, 1, 0}};
    case Stand::attitude_z: return {{0, 0, 0}, {0, 0, 1}};
    case Stand::altitude: return {{1, 0, 0}, {0, 1, 0}};
    case Stand::height: return {{1, 0, 0}, {0, 0, 0}};
  }
  return {{1, 1, 1}, {1, 1, 1}};
}

}  // namespace

double Log::rms_height_m() const {
  return height_frames > 0 ? std::sqrt(height_square / height_frames) : 0;
}

Hopper::Hopper(const World& w, const Parameters& p)
    : world(w), parameters(p), flight(p), random_(w.seed) {
  const bool stands =
      world.stand == Stand::free || world.stand == Stand::altitude || world.stand == Stand::height;
  rest_x_ = stands ? -world.mass_kg * kGravity_m_s2 / (4 * kFootStiffness) : 0;
  position.x() = rest_x_;
  tilt_offset_ = Vector3(0, normal(0.002), normal(0.002)) * world.noise;
}

double Hopper::normal(double sigma) { return sigma * std::normal_distribution<double>()(random_); }

double Hopper::tilt() const {
  return std::acos(std::clamp((q_NB * Vector3::UnitX()).x(), -1.0, 1.0));
}

void Hopper::sense() {
  const double n = world.noise;
  const auto noise = [&](double sigma) -> Vector3 {
    return Vector3(normal(sigma), normal(sigma), normal(sigma)) * n;
  };
  inputs.time_ns = static_cast<std::int64_t>(std::llround(time_s * 1e9));
  drift_v_ += world.drift_m_s2 * kFrame_s;
  drift_p_ += drift_v_ * kFrame_s;
  imu_age_ = imu_silent ? imu_age_ + kFrame_s : 0.002;
  if (!imu_silent) {
    NavState& nav = inputs.nav;
    nav.time_ns = inputs.time_ns;
    nav.valid = true;
    const Vector3 p = noise(0.006);
    nav.position_N_m = position - Vector3(rest_x_, 0, 0) + drift_p_ + Vector3(p.x(), 0, 0);
    nav.velocity_N_m_s = velocity + drift_v_ + noise(0.01);
    nav.velocity_least_N_m_s = nav.velocity_most_N_m_s = nav.velocity_N_m_s;
    const Vector3 a = tilt_offset_ + noise(0.0005);
    nav.q_NB = (q_NB * Quaternion(1, a.x() / 2, a.y() / 2, a.z() / 2)).normalized();
    nav.rate_B_rad_s = rate_B + noise(0.002);
    nav.foot_down_m_s = kFoot_m * nav.rate_B_rad_s.tail<2>().norm() - nav.velocity_N_m_s.x();
    nav.acceleration_N_m_s2 = (velocity - velocity_before_) / kFrame_s + noise(0.02);
  } else {
    inputs.nav.valid = imu_age_ < 0.25;
  }
  velocity_before_ = velocity;
  inputs.imu_age_s = imu_age_;
  range_age_ = range_silent ? range_age_ + kFrame_s : 0.05;
  if (!range_silent)
    inputs.range_m = 0.15 + (position.x() - rest_x_) / std::cos(tilt()) + normal(0.003) * n;
  inputs.range_age_s = range_age_;
  valve_age_ = valves_dead ? valve_age_ + kFrame_s : 0.1;
  inputs.valve_age_s = valve_age_;
  fan_age_ = fans_silent ? fan_age_ + kFrame_s : 0.01;
  inputs.fan_age_s = fan_age_;
  if (!fans_silent) {
    for (std::size_t i = 0; i < kFans; ++i) {
      inputs.rpm[i] =
          parameters.fans.rpm_quantum * std::round(rpm[i] / parameters.fans.rpm_quantum);
    }
  }
  inputs.regulated_kPa = pressure_gone ? 200 : regulated_kPa;
  const Gas& gas = parameters.gas;
  inputs.tank_kPa = gas.full_kPa - (gas.full_kPa - gas.empty_kPa) * gas_s_ / gas.budget_s;
  inputs.faults = told;
}

void Hopper::physics(double dt) {
  if (time_s >= release_s_) {
    release_s_ = 1e18;
    window_ = next_;
    throttle_ = pending_.fan_throttle;
  }
  Vector3 force_B = Vector3::Zero(), moment_B = Vector3::Zero();
  const Thrusters& t = parameters.thrusters;
  const double mass =
      world.mass_kg - parameters.gas.mass_kg * std::min(gas_s_ / parameters.gas.budget_s, 1.0);
  for (std::size_t v = 0; v < kValves; ++v) {
    const double at = time_s - world.valve_lag_s;
    if (!(at >= window_[v].from && at < window_[v].to) || valves_dead || pressure_gone) continue;
    gas_s_ += dt;
    const std::size_t i = v / 2;
    const Vector3 f = v % 2 == 0 ? Vector3(world.force_N[v], 0, 0)
                                 : Vector3(0, 0, kSidePush[i] * world.force_N[v]);
    const Vector3 r = v % 2 == 0 ? Vector3(0, kLiftY[i] * t.lift_y_m, kLiftZ[i] * t.lift_z_m)
                                 : Vector3(0, kSideY[i] * t.side_y_m, 0);
    force_B += f;
    moment_B += r.cross(f);
  }
  for (std::size_t i = 0; i < kFans; ++i) {
    const double throttle = fans_dead ? 0 : throttle_[i];
    rpm[i] +=
        dt / world.fan_lag_s * (throttle * parameters.fans.max_rpm * world.fan_speed[i] - rpm[i]);
    const Vector3 f(world.fan_scale * fan_thrust_N(rpm[i], parameters.fans), 0, 0);
    force_B += f;
    moment_B +=
        Vector3(0, kLiftY[i] * parameters.fans.y_m, kLiftZ[i] * parameters.fans.z_m).cross(f);
  }
  Vector3 force = q_NB * force_B + Vector3(-mass * kGravity_m_s2, 0, 0);
  const bool ground =
      world.stand == Stand::free || world.stand == Stand::altitude || world.stand == Stand::height;
  bool contact = false;
  if (ground) {
    for (std::size_t i = 0; i < 4; ++i) {
      const Vector3 r_B(0, kLiftY[i] * kFootY, kLiftZ[i] * kFootZ);
      const Vector3 r = q_NB * r_B;
      const Vector3 v = velocity + q_NB * rate_B.cross(r_B);
      const double depth = -(position.x() + r.x());
      if (depth <= 0) continue;
      contact = true;
      const double up = std::max(kFootStiffness * depth - kFootDamping * v.x(), 0.0);
      const double slide = std::hypot(v.y(), v.z());
      const double drag = kFriction * up / std::max(slide, 0.02);
      const Vector3 f(up, -drag * v.y(), -drag * v.z());
      force += f;
      moment_B += q_NB.conjugate() * r.cross(f);
    }
  }
  if (!contact) moment_B += world.moment_N_m;
  if (world.stand == Stand::sled || world.stand == Stand::rails) {
    force -= world.sled_friction_N_s_m * velocity;
  }
  if (contact && was_up_ && !log.landed) {
    log.landed = true;
    log.landing_speed_m_s = -velocity.x();
    log.landing_tilt_rad = tilt();
    log.landing_drift_m_s = std::hypot(velocity.y(), velocity.z());
  }
  if (position.x() > 0.1) was_up_ = true;

  const auto [move, turn] = freedom(world.stand);
  const Vector3& I = world.inertia_kg_m2;
  const Vector3 gyro = rate_B.cross(I.cwiseProduct(rate_B).eval());
  velocity += dt * force.cwiseProduct(move) / mass;
  rate_B += dt * (moment_B - gyro).cwiseQuotient(I).cwiseProduct(turn);
  position += dt * velocity;
  const Vector3 a = rate_B * dt;
  q_NB = (q_NB * Quaternion(1, a.x() / 2, a.y() / 2, a.z() / 2)).normalized();
  time_s += dt;
}

void Hopper::count(const FlightOutput& o) {
  log.max_height_m = std::max(log.max_height_m, position.x());
  if ((!o.airborne && o.phase != Phase::keep) || log.landed) return;
  log.max_tilt_rad = std::max(log.max_tilt_rad, tilt());
  if (o.phase_s > 4) log.settled_tilt_rad = std::max(log.settled_tilt_rad, tilt());
  const double roll = wrapped(attitude_of(q_NB).roll_rad - o.target_roll_rad);
  if (o.phase != Phase::turn)
    log.max_roll_error_rad = std::max(log.max_roll_error_rad, std::abs(roll));
  if (o.phase == Phase::hover || o.phase == Phase::traverse || o.phase == Phase::brake ||
      o.phase == Phase::turn) {
    const double e = position.x() - flight.planned().request.height_m;
    log.max_height_error_m = std::max(log.max_height_error_m, std::abs(e));
    log.height_square += e * e;
    ++log.height_frames;
  }
}

void Hopper::frame() {
  sense();
  out = flight.step(inputs);
  count(out);
  pending_ = out.actuation;
  release_s_ = time_s + parameters.offset_s - 1e-9;
  for (std::size_t i = 0; i < kValves; ++i) {
    const Pulse& p = out.actuation.valve[i];
    const double from = time_s + parameters.offset_s + p.delay_s;
    next_[i] = p.on_s > 0 ? Window{from, from + p.on_s} : Window{};
  }
  const int steps = static_cast<int>(std::lround(kFrame_s / kStep_s));
  for (int n = 0; n < steps; ++n) physics(kStep_s);
}

bool Hopper::run(double seconds) {
  const double end = time_s + seconds;
  while (time_s < end) {
    frame();
    if (out.finished) return true;
  }
  return false;
}

bool Hopper::fly(const PlanRequest& request, double seconds) {
  return flight.plan(request).feasible() && flight.execute() && run(seconds);
}

}  // namespace lss::gnc::talaris::test
