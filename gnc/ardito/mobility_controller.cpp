#include "gnc/ardito/mobility_controller.h"

#include <algorithm>
#include <cmath>

#include "gnc/ardito/decision.h"
#include "gnc/ardito/ratio.h"
#include "gnc/ardito/slip.h"
#include "idl/angles.h"

namespace lss::gnc::ardito {
namespace {

PerSteered<double> steered(const PerWheel<double>& all) noexcept {
  PerSteered<double> some{};
  for (std::size_t i = 0; i < kSteered; ++i) some[i] = all[kWheelOfSteered[i]];
  return some;
}

// sin(5 x) from sin(x).
double sine_of_five(double sine) noexcept {
  const double square = sine * sine;
  return sine * ((16 * square - 20) * square + 5);
}

constexpr double kFurthest_rad = 65 * kDegree;  // 11.2.1

// Angles to keep while steering is held: the present ones, within the limits.
PerSteered<double> angles_to_hold(const Feedback& feedback) noexcept {
  PerSteered<double> angles = steered(feedback.steering_rad);
  for (double& angle : angles) angle = std::clamp(angle, -kFurthest_rad, kFurthest_rad);
  return angles;
}

}  // namespace

Command MobilityController::step(const Request& asked, const Measured& measured) noexcept {
  Command command;
  const Request request = sane(asked, parameters_);
  retry(request);

  const Inputs inputs = read_inputs(measured, parameters_, linkage_, state_);
  const bool correction = request.enable_correction;
  const Feedback feedback = choose_feedback(inputs, parameters_, correction, state_);

  PerWheel<WheelLook> looks;
  for (std::size_t i = 0; i < kWheels; ++i) {
    looks[i] = look_at_wheel(inputs.wheels[i], state_.wheels[i], parameters_);
  }
  const Motion motion = estimate(request, inputs, feedback, looks, command);
  diagnose(request, inputs, feedback, looks, motion, command);
  watch_slip(inputs, motion, command);
  watch_yaw(inputs, motion, command);
  watch_imu(inputs, motion, command);
  watch_rocker(motion, command);
  measure_slip(inputs, motion, command);
  watch_sinking(inputs, motion, command);
  const bool stop = error(request, command) || request.error || !request.powered;

  find_steering(inputs, feedback);
  const PlaneMotion target = asked_motion(request);
  const PerSteered<double> asked_rad =
      steered(steering_angles_rad(target.direction, parameters_.geometry));
  if (request.powered) {
    decide(request, feedback, stop, asked_rad);
    slow_by_slip(target);
    const bool ready =
        state_.phase == StopPhase::rover_steer || state_.phase == StopPhase::rover_stop;
    steer(request.run && !stop && state_.steering_known != 0 && (drives(state_.mode) || ready),
          feedback, asked_rad);
    drive(request, target, inputs, feedback, motion);
  } else {
    stand(feedback);
    state_.slip_speed = {};
  }
  state_.sigma_rad = request.sigma_rad;
  state_.started = 1;
  report(inputs, feedback, motion, command);
  return command;
}

void MobilityController::retry(const Request& request) noexcept {
  for (std::size_t i = 0; i < kWheels; ++i) {
    if (!contains(request.retry_wheels, i)) continue;
    state_.wheels[i] = {};
    // of an isolated wheel only the speed it was expected to roll with
    for (PerWheel<double>& orders : state_.wheels_ordered) orders[i] = 0;
  }
  for (std::size_t i = 0; i < kSteered; ++i) {
    if (contains(request.retry_steering, i)) state_.steering[i] = {};
  }
}

WheelSet MobilityController::wheels_in(WheelService service) const noexcept {
  WheelSet set = 0;
  for (std::size_t i = 0; i < kWheels; ++i) {
    if (state_.wheels[i].service == service) set |= only(i);
  }
  return set;
}

WheelSet MobilityController::probed_wheels() const noexcept {
  WheelSet set = 0;
  for (std::size_t i = 0; i < kWheels; ++i) {
    if (state_.wheels[i].test == ClutchTest::probe) set |= only(i);
  }
  return set;
}

Motion MobilityController::estimate(const Request& request, const Inputs& inputs,
                                    const Feedback& feedback, const PerWheel<WheelLook>& looks,
                                    Command& command) noexcept {
  // angles substitute for each other, so steering is judged first
  SteeringSet trusted_steering = 0;
  for (std::size_t i = 0; i < kSteered; ++i) {
    command.steering_suspect[i] =
        update_steering(state_.steering[i], inputs.steering[i],
                        request.powered && state_.steering_known != 0, parameters_);
    if (command.steering_suspect[i] <= SteeringFailure::reduction_encoder) {
      trusted_steering |= only(i);
    }
  }
  WheelSet trusted = 0;
  for (std::size_t i = 0; i < kWheels; ++i) {
    const bool fit = looks[i].verdict.failure <= WheelFailure::reduction_encoder &&
                     state_.wheels[i].service == WheelService::engaged &&
                     state_.wheels[i].test == ClutchTest::watch;
    if (fit) trusted |= only(i);
  }
  const Motion motion = estimate_motion(feedback, inputs, trusted, trusted_steering,
                                        request.enable_correction, parameters_);
  state_.v_m_s = motion.mean.v_m_s;
  state_.direction_sin = motion.mean.direction.sin;
  state_.direction_cos = motion.mean.direction.cos;
  return motion;
}

void MobilityController::diagnose(const Request& request, const Inputs& inputs,
                                  const Feedback& feedback, const PerWheel<WheelLook>& looks,
                                  const Motion& motion, Command& command) noexcept {
  PerWheel<double> works{};  // the load of the motors that drive
  double total = 0;
  int working = 0;
  for (std::size_t i = 0; i < kWheels; ++i) {
    const Sensor& load = inputs.wheels[i].load;
    const bool engaged = state_.wheels[i].service == WheelService::engaged;
    works[i] = load.usable && engaged ? load.value : 0;
    if (works[i] != 0) ++working;
    total += works[i];
  }
  WheelSet probed = probed_wheels();
  for (std::size_t i = 0; i < kWheels; ++i) {
    const int others = working - (works[i] != 0 ? 1 : 0);
    const Sensor& reduction = inputs.wheels[i].sensors.reduction;
    WheelEvidence evidence;
    evidence.counts = request.powered;
    evidence.incoherent = incoherent(motion, i, parameters_);
    evidence.imu_contradicts = (looks[i].fresh_parts & kClutch) != 0 && inputs.imu.usable &&
                               reduction.usable &&
                               !imu_confirms(motion, i, reduction.value, feedback, inputs,
                                             request.enable_correction, parameters_);
    evidence.rover_drives = drives(state_.mode);
    evidence.others_loaded = others > 0 && total - works[i] > parameters_.loaded_current * others;
    evidence.other_probe = (probed & ~only(i)) != 0;
    command.wheel_suspect[i] =
        update_wheel(state_.wheels[i], looks[i], inputs.wheels[i], evidence, parameters_);
    probed &= ~only(i);
    if (state_.wheels[i].test == ClutchTest::probe) probed |= only(i);
  }
}

void MobilityController::watch_imu(const Inputs& inputs, const Motion& motion,
                                   Command& command) noexcept {
  if (inputs.rocker_stale) command.faults |= kRockerStale;
  if (inputs.rocker_jumped) command.faults |= kRockerJump;
  if (motion.slip) command.faults |= kSlip;
  if (motion.incoherent_speed) command.faults |= kIncoherentSpeed;
  if (motion.incoherent_sigma) command.faults |= kIncoherentSigma;
  if (inputs.imu.silent) command.faults |= kImuSilent;
  // wheels that agree with each other for long and not with the IMU (7.7)
  const bool contradicts =
      motion.imu_contradicts && !motion.incoherent_speed && (command.faults & kWheelsSlip) == 0;
  state_.imu_contradiction =
      contradicts ? std::min(state_.imu_contradiction + 1, parameters_.imu_frames) : 0;
  if (inputs.imu.implausible || state_.imu_contradiction >= parameters_.imu_frames) {
    command.faults |= kImuImplausible;
  }
}

// All wheels of a side roll over the same ground: over a long way the mean slopes of rocker and
// bogie, and of both sides, are equal, and so the angles between them are 0 on average, on any
// ground. Beyond the limit one of their encoders is wrong, by a constant. Not in a curve, where
// they do not, nor where the rover turns back or on the spot: the same place again is no average.
// The way is the lesser of the IMU's and the wheels': either may be wrong.
void MobilityController::watch_rocker(const Motion& motion, Command& command) noexcept {
  constexpr double kGood = 0.8;                  // of the limit: then it is trusted again
  constexpr double kStraight_rad = 1 * kDegree;  // sigma: a circle of 4 m
  const Parameters& p = parameters_;
  RockerWatch& w = state_.rocker_watch;
  const bool measured = state_.rocker_known != 0 && state_.rocker_distrust == 0;
  const double wheels_m_s = motion.mean.v_m_s, ground_m_s = motion.ground_m_s;
  const bool moves = std::min(std::abs(ground_m_s), std::abs(wheels_m_s)) > p.slip_speed_m_s;
  const bool straight = state_.mode == Mode::running && std::abs(motion.sigma_rad) < kStraight_rad;
  if (state_.mode == Mode::parking) w.way_m = 0;
  if (measured && moves && straight && (command.faults & kImuImplausible) == 0) {
    const double way_m =
        std::abs(wheels_m_s) < std::abs(ground_m_s) ? wheels_m_s * kFrame_s : ground_m_s * kFrame_s;
    if (way_m * w.way_m < 0) w.way_m = 0;
    w.way_m = std::clamp(w.way_m + way_m, -p.rocker_way_m, p.rocker_way_m);
    const std::array limits_rad = {p.rocker_mean_rad, p.bogie_mean_rad, p.bogie_mean_rad};
    double most = 0;  // of its limit
    for (std::size_t i = 0; i < limits_rad.size(); ++i) {
      w.mean_rad[i] += (state_.rocker_rad[i] - w.mean_rad[i]) * way_m / w.way_m;
      most = std::max(most, std::abs(w.mean_rad[i]) / limits_rad[i]);
    }
    if (std::abs(w.way_m) >= p.rocker_way_m) w.off = most > (w.off != 0 ? kGood : 1) ? 1 : 0;
  }
  if (w.off != 0) command.faults |= kRockerOff;
}

// 7.2.1: a bent bracket shows in how the rover turns, if at all.
void MobilityController::watch_yaw(const Inputs& inputs, const Motion& motion,
                                   Command& command) noexcept {
  const bool judged = inputs.imu.usable && state_.mode == Mode::running && !motion.slip &&
                      !motion.incoherent_speed &&
                      std::abs(motion.mean.v_m_s) > parameters_.slip_speed_m_s;
  if (judged) {
    const double error =
        inputs.imu.yaw_rate_rad_s.value - yaw_rate_rad_s(motion.mean, parameters_.geometry);
    state_.yaw_error_rad_s +=
        (error - state_.yaw_error_rad_s) * kFrame_s / parameters_.yaw_filter_s;
  }
  if (std::abs(state_.yaw_error_rad_s) > parameters_.yaw_agree_rad_s) {
    command.faults |= kYawDisagrees;
  }
}

bool MobilityController::error(const Request& request, Command& command) const noexcept {
  std::uint32_t lost_wheels = 0;
  for (std::size_t i = 0; i < kWheels; ++i) {
    const WheelHealth& h = state_.wheels[i];
    if (h.service == WheelService::isolated) ++lost_wheels;
    if (h.error != 0 && !contains(request.accept_lost_wheels, i)) command.error = 1;
  }
  for (const SteeringHealth& h : state_.steering) {
    if (h.error != 0) command.error = 1;
  }
  if (lost_wheels > parameters_.max_lost_wheels) {
    command.faults |= kTooFewWheels;
    command.error = 1;
  }
  return command.error != 0;
}

void MobilityController::decide(const Request& request, const Feedback& feedback, bool stop,
                                const PerSteered<double>& asked_rad) noexcept {
  // Stop is left only by angles that fit the request of this frame
  const bool stopped = state_.mode == Mode::stop;
  if (stopped) follow_chart(request, feedback, stop, asked_rad);
  const bool is_busy = stopped && busy(state_.phase);
  const double delta =
      request.parking || state_.started == 0 ? 0 : std::abs(request.sigma_rad - state_.sigma_rad);
  state_.mode =
      next_mode(state_.mode, {request.speed, request.parking, is_busy, stop, delta}, parameters_);
  if (!stopped && state_.mode == Mode::stop) follow_chart(request, feedback, stop, asked_rad);
}

void MobilityController::follow_chart(const Request& request, const Feedback& feedback, bool stop,
                                      const PerSteered<double>& asked_rad) noexcept {
  // steering motors that no longer follow cannot be waited for
  StopInputs in;
  for (std::size_t i = 0; i < kWheels; ++i) {
    const bool driven = state_.wheels[i].service == WheelService::engaged;
    if (driven) in.fastest_rad_s = std::max(in.fastest_rad_s, std::abs(feedback.wheel_rad_s[i]));
    const std::size_t s = kSteeredOfWheel[i];
    const bool waits = s < kSteered && request.run && !stop &&
                       failure_of(state_.steering[s]) < SteeringFailure::critical;
    if (waits) {
      in.largest_angle_rad =
          std::max(in.largest_angle_rad, std::abs(asked_rad[s] - feedback.steering_rad[i]));
    }
  }
  if (state_.steering_known != 0) state_.phase = next_phase(state_.phase, in, parameters_);
}

// Requested motion in the plane; at standstill, the motion to steer for (11.2.1 to 11.2.3).
PlaneMotion MobilityController::asked_motion(const Request& request) const noexcept {
  const double speed_m_s = request.speed * request.speed_limit_m_s;
  if (request.parking) {
    return {kOnTheSpot, speed_m_s * parameters_.geometry.f_m / parameters_.parking_length_m};
  }
  const Direction d = direction(request.sigma_rad);
  return {d, speed_m_s * (1 - std::abs(sine_of_five(d.sin)))};
}

// Steering starts from the present angles: until every angle was measured nothing is ordered.
void MobilityController::find_steering(const Inputs& inputs, const Feedback& feedback) noexcept {
  if (state_.steering_known != 0) return;
  for (const SteeringInputs& in : inputs.steering) {
    if (!in.motor.usable && !in.reduction.usable) return;
  }
  state_.steering_held = angles_to_hold(feedback);
  state_.steering_integral = state_.steering_held;
  state_.steering_ordered.fill(state_.steering_held);
  state_.steering_known = 1;
}

void MobilityController::steer(bool moves, const Feedback& feedback,
                               const PerSteered<double>& asked_rad) noexcept {
  PerSteered<double> orders = state_.steering_held;
  if (moves) {
    const PerSteered<double> now = angles_to_hold(feedback);
    PerSteered<double> errors{};
    std::uint32_t skip = 0;
    for (std::size_t i = 0; i < kSteered; ++i) {
      errors[i] = asked_rad[i] - feedback.steering_rad[kWheelOfSteered[i]];
      if (failure_of(state_.steering[i]) >= SteeringFailure::critical) skip |= only(i);
    }
    const auto cut = equal_settling(errors, parameters_.steering_saturation_rad, skip);
    for (std::size_t i = 0; i < kSteered; ++i) {
      if (contains(skip, i)) continue;
      orders[i] = pi_step(cut[i], kFurthest_rad, state_.steering_integral[i], parameters_);
      state_.steering_held[i] = now[i];
    }
  } else {
    state_.steering_integral = state_.steering_held;
  }
  std::copy_backward(state_.steering_ordered.begin(), state_.steering_ordered.end() - 1,
                     state_.steering_ordered.end());
  state_.steering_ordered[0] = orders;
}

void MobilityController::drive(const Request& request, const PlaneMotion& target,
                               const Inputs& inputs, const Feedback& feedback,
                               const Motion& motion) noexcept {
  const auto speed_rad_s = [&](std::size_t i, double hub_m_s) {
    return wheel_speed_rad_s(i, hub_m_s, feedback.steering[i], inputs, request.enable_correction,
                             parameters_);
  };
  const PerWheel<double> hubs = hubs_m_s(request, target, feedback, motion);
  const WheelSet isolated = wheels_in(WheelService::isolated);
  const WheelSet probed = probed_wheels();

  PerWheel<double> wanted{}, errors{};
  double fastest = 0;
  for (std::size_t i = 0; i < kWheels; ++i) {
    wanted[i] = speed_rad_s(i, hubs[i]);
    errors[i] = wanted[i] - feedback.wheel_rad_s[i];
    if (!contains(isolated, i)) fastest = std::max(fastest, std::abs(feedback.wheel_rad_s[i]));
  }
  const auto cut = equal_settling(errors, parameters_.wheel_saturation_rad_s, isolated | probed);
  const bool stands = !drives(state_.mode) && fastest < parameters_.standing_rad_s;

  const PerWheel<double> last = state_.wheels_ordered[0];
  state_.wheels_ordered[1] = last;
  if (!drives(state_.mode)) slow_down(isolated);
  for (std::size_t i = 0; i < kWheels; ++i) {
    double& integral = state_.wheel_integral[i];
    double& order = state_.wheels_ordered[0][i];
    if (contains(isolated, i)) {
      // not driven: compared with the speed at which it would roll with the rover
      integral = 0;
      order = speed_rad_s(
          i, motion.mean.v_m_s * hub_ratio(i, motion.mean.direction, parameters_.geometry));
    } else if (stands) {
      integral = 0;
      order = 0;
    } else if (!drives(state_.mode)) {
      integral = order;
    } else if (contains(probed, i)) {
      const double limit = std::abs(wanted[i]);
      order = probe_speed_rad_s(std::clamp(integral, -limit, limit), parameters_);
    } else {
      // never faster than requested, and never faster than before while that is too fast
      const double limit = std::max(std::abs(wanted[i]), std::abs(last[i]));
      order = pi_step(cut[i], limit, integral, parameters_);
    }
  }
}

// Of all hubs. While the steering is under way, the rover moves where its wheels point, and each
// hub rolls along its wheel: speeds for the requested angles would push it sideways and forward.
PerWheel<double> MobilityController::hubs_m_s(const Request& request, const PlaneMotion& target,
                                              const Feedback& feedback,
                                              const Motion& motion) const noexcept {
  PerWheel<double> hubs{};
  if (!drives(state_.mode)) return hubs;
  PlaneMotion now = target;
  if (state_.mode == Mode::running) {
    constexpr double kNarrowest = 0.309;  // sine of 18 deg: 5 sigma is 90 deg
    const Direction& d = motion.mean.direction;
    const double measured = std::min(std::abs(d.sin), kNarrowest);
    const double asked = std::abs(target.direction.sin);
    now.direction = d;
    now.v_m_s = request.speed * request.speed_limit_m_s *
                (1 - std::abs(sine_of_five(std::max(measured, asked))));
  }
  now.v_m_s *= state_.slip_speed.factor;
  for (std::size_t i = 0; i < kWheels; ++i) {
    hubs[i] = hub_speed_m_s(i, now, feedback.steering[i], parameters_.geometry);
  }
  return hubs;
}

// All wheels together, at the configured deceleration.
void MobilityController::slow_down(WheelSet isolated) noexcept {
  double fastest = 0;
  for (std::size_t i = 0; i < kWheels; ++i) {
    if (!contains(isolated, i)) fastest = std::max(fastest, std::abs(state_.wheels_ordered[0][i]));
  }
  const double step =
      parameters_.deceleration_m_s2 * kFrame_s / parameters_.geometry.wheel_radius_m;
  const double left = fastest > step ? 1 - step / fastest : 0;
  for (double& order : state_.wheels_ordered[0]) order *= left;
}

void MobilityController::stand(const Feedback& feedback) noexcept {
  state_.mode = Mode::stop;
  state_.phase = StopPhase::begin;
  state_.wheel_integral = {};
  state_.wheels_ordered = {};
  state_.steering_held = angles_to_hold(feedback);
  state_.steering_integral = state_.steering_held;
  state_.steering_ordered.fill(state_.steering_held);
}

void MobilityController::report(const Inputs& inputs, const Feedback& feedback,
                                const Motion& motion, Command& command) const noexcept {
  const WheelSet isolated = wheels_in(WheelService::isolated);
  for (std::size_t i = 0; i < kWheels; ++i) {
    const WheelHealth& h = state_.wheels[i];
    const WheelInputs& in = inputs.wheels[i];
    if (!contains(isolated, i)) command.wheel_rad_s[i] = state_.wheels_ordered[0][i];
    command.wheel_failure[i] = failure_of(h.lost);
    command.sensors_lost[i] = h.lost & kSensors;
    if (in.stale) command.stale_wheels |= only(i);
    if (in.temperature_C.usable && in.temperature_C.value > parameters_.warm_temperature_C) {
      command.hot_motors |= only(i);
    }
    if (h.inconclusive >= parameters_.inconclusive_frames) command.inconclusive_wheels |= only(i);
  }
  for (std::size_t i = 0; i < kSteered; ++i) {
    command.steering_failure[i] = failure_of(state_.steering[i]);
    command.encoders_lost[i] = state_.steering[i].lost;
    if (inputs.steering[i].stale) command.stale_steering |= only(i);
  }
  command.steering_rad = state_.steering_ordered[0];
  command.steering_known = state_.steering_known;
  command.clutches_engaged = wheels_in(WheelService::engaged);
  command.motors_stopped = isolated;
  command.mode = state_.mode;
  command.phase = state_.phase;
  command.busy = state_.mode == Mode::stop && busy(state_.phase) ? 1 : 0;
  command.probing = probed_wheels();
  const SlipSpeed& slip = state_.slip_speed;
  Estimate& e = command.estimate;  // slip and load: watch_slip()
  e.slip_share = slip_share(slip, parameters_);
  e.speed_share = slip.factor;
  e.speed_m_s = motion.mean.v_m_s;
  e.sigma_rad = motion.sigma_rad;
  e.yaw_rate_rad_s = yaw_rate_rad_s(motion.mean, parameters_.geometry);
  e.ground_m_s = (command.faults & kWheelsSlip) != 0 ? motion.ground_m_s : motion.mean.v_m_s;
  e.wheel_rad_s = feedback.wheel_rad_s;
  e.steering_rad = steered(feedback.steering_rad);
  e.wheel_speed_m_s = motion.v_m_s;
}

}  // namespace lss::gnc::ardito
