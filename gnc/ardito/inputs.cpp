#include "gnc/ardito/inputs.h"

#include <algorithm>
#include <cmath>

#include "idl/angles.h"

namespace lss::gnc::ardito {
namespace {

// No healthy sensor reports more.
constexpr double kMaxWheel_rad_s = 30;
constexpr double kMaxSteering_rad = 100 * kDegree;
constexpr double kMaxCurrent = 100;
constexpr double kMaxTemperature_C = 1000;
constexpr double kMaxImu = 1e6;
constexpr double kMaxRocker_rad = 60 * kDegree;
constexpr double kMaxImuSpeed_m_s = 3;
constexpr double kMaxImuYaw_rad_s = 3;
constexpr double kMaxImuStep_m_s = 1;  // in a frame: 10 m/s2

// Rejects values that are not numbers, too.
Sensor fresh(const Reading& reading, double age_limit_s, double most) noexcept {
  const bool usable =
      std::abs(reading.value) <= most && reading.age_s >= 0 && reading.age_s <= age_limit_s;
  return {usable ? reading.value : 0, usable};
}

void read_wheel(const WheelMeasured& m, std::uint32_t lost, const Parameters& p,
                WheelInputs& in) noexcept {
  WheelSensors& s = in.sensors;
  s.motor = fresh(m.motor_rad_s, p.drive_age_s, kMaxWheel_rad_s);
  s.hall = fresh(m.hall_rad_s, p.drive_age_s, kMaxWheel_rad_s);
  s.reduction = fresh(m.reduction_rad_s, p.drive_age_s, kMaxWheel_rad_s);
  in.current = fresh(m.current, p.drive_age_s, kMaxCurrent);
  in.temperature_C = fresh(m.temperature_C, p.temperature_age_s, kMaxTemperature_C);
  in.stale = !s.motor.usable || !s.hall.usable || !s.reduction.usable || !in.current.usable ||
             !in.temperature_C.usable;
  in.drive_fault = m.drive_fault;
  if ((lost & kMotorEncoder) != 0) s.motor = {};
  if ((lost & kHall) != 0) s.hall = {};
  if ((lost & kReductionEncoder) != 0) s.reduction = {};
}

void read_steering(const SteeringMeasured& m, std::uint32_t lost, const Parameters& p,
                   SteeringInputs& in) noexcept {
  in.motor = fresh(m.motor_rad, p.drive_age_s, kMaxSteering_rad);
  in.reduction = fresh(m.reduction_rad, p.drive_age_s, kMaxSteering_rad);
  in.current = fresh(m.current, p.drive_age_s, kMaxCurrent);
  in.stale = !in.motor.usable || !in.reduction.usable;
  in.drive_fault = m.drive_fault;
  if ((lost & 1U) != 0) in.motor = {};
  if ((lost & 2U) != 0) in.reduction = {};
}

// Lowest and highest order of the last frames.
template <std::size_t N, std::size_t Frames>
Ordered ordered(const std::array<std::array<double, N>, Frames>& orders, std::size_t i) noexcept {
  Ordered all{orders[0][i], orders[0][i]};
  for (std::size_t frame = 1; frame < Frames; ++frame) {
    all.low = std::min(all.low, orders[frame][i]);
    all.high = std::max(all.high, orders[frame][i]);
  }
  return all;
}

ImuInputs read_imu(const ImuMeasured& m, const Parameters& p, State& state) noexcept {
  ImuInputs in;
  in.speed_m_s = fresh(m.speed_m_s, p.imu_age_s, kMaxImu);
  in.sigma_rad = fresh(m.sigma_rad, p.imu_age_s, kMaxImu);
  in.yaw_rate_rad_s = fresh(m.yaw_rate_rad_s, p.imu_age_s, kMaxImu);
  const bool heard = in.speed_m_s.usable && in.sigma_rad.usable && in.yaw_rate_rad_s.usable;
  const bool known = state.started != 0 && state.imu_frozen < p.imu_frozen_frames;
  const bool news = heard && (state.started == 0 || m.counter != state.imu_counter);
  state.imu_frozen = news ? 0 : std::min(state.imu_frozen + 1, p.imu_frozen_frames);
  state.imu_counter = m.counter;
  in.silent = !heard || state.imu_frozen >= p.imu_frozen_frames;
  if (!in.silent) {
    const bool jumped =
        known && std::abs(in.speed_m_s.value - state.imu_speed_m_s) > kMaxImuStep_m_s;
    in.implausible = jumped || std::abs(in.speed_m_s.value) > kMaxImuSpeed_m_s ||
                     std::abs(in.sigma_rad.value) > kPi / 2 + 0.01 ||
                     std::abs(in.yaw_rate_rad_s.value) > kMaxImuYaw_rad_s;
    state.imu_speed_m_s = in.speed_m_s.value;
  }
  in.usable = !in.silent && !in.implausible;
  return in;
}

// True: an angle changed faster than a rocker or bogie can turn, now or a short while ago.
bool jumps(const std::array<double, 3>& angles_rad, const Parameters& p, State& state) noexcept {
  bool far = false;
  for (std::size_t i = 0; i < angles_rad.size() && state.rocker_known != 0; ++i) {
    far = far || std::abs(angles_rad[i] - state.rocker_rad[i]) > p.rocker_step_rad;
  }
  state.rocker_rad = angles_rad;
  state.rocker_known = 1;
  if (far) {
    state.rocker_distrust = p.rocker_frames;
  } else if (state.rocker_distrust > 0) {
    --state.rocker_distrust;
  }
  return state.rocker_distrust > 0;
}

void read_rocker(const Measured& m, const Parameters& p, const Linkage& linkage, State& state,
                 Inputs& in) noexcept {
  const Sensor angles[] = {fresh(m.beta_rad, p.rocker_age_s, kMaxRocker_rad),
                           fresh(m.rho1_rad, p.rocker_age_s, kMaxRocker_rad),
                           fresh(m.rho2_rad, p.rocker_age_s, kMaxRocker_rad)};
  const bool usable =
      std::all_of(std::begin(angles), std::end(angles), [](const Sensor& s) { return s.usable; });
  in.rocker_stale = !usable;
  in.rocker_jumped = usable ? jumps({angles[0].value, angles[1].value, angles[2].value}, p, state)
                            : state.rocker_distrust > 0;
  if (!usable) state.rocker_known = 0;
  if (!usable || in.rocker_jumped || state.rocker_watch.off != 0) {
    state.poses_known = 0;
    return;
  }
  const WheelPoses poses =
      wheel_poses({angles[0].value, angles[1].value, angles[2].value}, linkage);
  in.rocker = state.poses_known != 0;
  if (in.rocker) {
    for (std::size_t i = 0; i < kWheels; ++i) {
      in.vx_m_s[i] = (poses.x_m[i] - state.poses.x_m[i]) / kFrame_s;
      in.vz_m_s[i] = (poses.z_m[i] - state.poses.z_m[i]) / kFrame_s;
    }
  }
  state.poses = poses;
  state.poses_known = 1;
}

// Of three the median; of two that contradict each other the one that follows the orders. At least
// one must exist.
double best_of(const WheelInputs& in, const Parameters& p) noexcept {
  const Sensor &m = in.sensors.motor, &h = in.sensors.hall, &r = in.sensors.reduction;
  if (m.usable && h.usable && r.usable) {
    return std::max(std::min(m.value, h.value), std::min(std::max(m.value, h.value), r.value));
  }
  const Sensor &one = m.usable ? m : h, &other = r.usable ? r : h;
  if (!one.usable) return other.value;
  if (!other.usable) return one.value;
  if (agree(one.value, other.value, p)) return (one.value + other.value) / 2;
  return distance(in.ordered, one.value) <= distance(in.ordered, other.value) ? one.value
                                                                              : other.value;
}

// No sensor reports the wheel's speed; behind an open clutch only that of the reduction does.
bool speed_unknown(const WheelSensors& s, WheelService service) noexcept {
  if (service != WheelService::engaged) return !s.reduction.usable;
  return !s.motor.usable && !s.hall.usable && !s.reduction.usable;
}

double wheel_feedback(const WheelInputs& in, WheelService service, const Parameters& p) noexcept {
  return service != WheelService::engaged ? in.sensors.reduction.value : best_of(in, p);
}

bool angle_unknown(const SteeringInputs& in) noexcept {
  return !in.motor.usable && !in.reduction.usable;
}

double steering_feedback(const SteeringInputs& in, const Parameters& p) noexcept {
  if (in.motor.usable && in.reduction.usable) {
    if (std::abs(in.motor.value - in.reduction.value) < p.steering_agree_rad) {
      return in.reduction.value;
    }
    return distance(in.ordered, in.reduction.value) <= distance(in.ordered, in.motor.value)
               ? in.reduction.value
               : in.motor.value;
  }
  return in.reduction.usable ? in.reduction.value : in.motor.value;
}

}  // namespace

Inputs read_inputs(const Measured& measured, const Parameters& parameters, const Linkage& linkage,
                   State& state) noexcept {
  Inputs in;
  for (std::size_t i = 0; i < kWheels; ++i) {
    read_wheel(measured.wheels[i], state.wheels[i].lost, parameters, in.wheels[i]);
    in.wheels[i].ordered = ordered(state.wheels_ordered, i);
    in.wheels[i].load = load_current(in.wheels[i], parameters);
  }
  for (std::size_t i = 0; i < kSteered; ++i) {
    read_steering(measured.steering[i], state.steering[i].lost, parameters, in.steering[i]);
    in.steering[i].ordered = ordered(state.steering_ordered, i);
  }
  in.imu = read_imu(measured.imu, parameters, state);
  read_rocker(measured, parameters, linkage, state, in);
  return in;
}

Request sane(const Request& request, const Parameters& parameters) noexcept {
  Request r = request;
  if (!std::isfinite(r.speed) || !std::isfinite(r.sigma_rad) || !std::isfinite(r.speed_limit_m_s) ||
      r.speed_limit_m_s < 0) {
    r.run = false;
    r.speed = 0;
    r.sigma_rad = 0;
    r.speed_limit_m_s = 0;
  }
  r.sigma_rad = std::clamp(r.sigma_rad, -parameters.max_sigma_rad, parameters.max_sigma_rad);
  r.speed_limit_m_s = std::min(r.speed_limit_m_s, parameters.top_speed_m_s);
  r.speed = r.run ? std::clamp(r.speed, -1.0, 1.0) : 0;
  r.enable_correction = r.enable_correction && parameters.correction_sign != 0;
  return r;
}

Feedback choose_feedback(const Inputs& inputs, const Parameters& parameters, bool correction,
                         const State& state) noexcept {
  // without a sensor: from the rover's motion in the frame before
  Feedback feedback;
  const PlaneMotion motion = estimated_motion(state);
  for (std::size_t i = 0; i < kSteered; ++i) {
    const std::size_t wheel = kWheelOfSteered[i];
    const SteeringInputs& in = inputs.steering[i];
    feedback.steering_rad[wheel] =
        angle_unknown(in) ? steering_angle_rad(wheel, motion.direction, parameters.geometry)
                          : steering_feedback(in, parameters);
    feedback.steering[wheel] = direction(feedback.steering_rad[wheel]);
  }
  for (std::size_t i = 0; i < kWheels; ++i) {
    const WheelInputs& in = inputs.wheels[i];
    const WheelService service = state.wheels[i].service;
    if (speed_unknown(in.sensors, service)) {
      const double hub = motion.v_m_s * hub_ratio(i, motion.direction, parameters.geometry);
      feedback.wheel_rad_s[i] =
          wheel_speed_rad_s(i, hub, feedback.steering[i], inputs, correction, parameters);
    } else {
      feedback.wheel_rad_s[i] = wheel_feedback(in, service, parameters);
    }
  }
  return feedback;
}

double wheel_speed_rad_s(std::size_t wheel, double hub_m_s, const Direction& steering,
                         const Inputs& inputs, bool correction,
                         const Parameters& parameters) noexcept {
  double rim = hub_m_s;
  if (correction && inputs.rocker) {
    rim = rim_speed_m_s(hub_m_s, steering, inputs.vx_m_s[wheel], inputs.vz_m_s[wheel],
                        parameters.correction_sign);
    const double most = std::abs(hub_m_s) * parameters.max_correction;
    rim = std::clamp(rim, hub_m_s - most, hub_m_s + most);
  }
  return rim / parameters.geometry.wheel_radius_m;
}

}  // namespace lss::gnc::ardito
