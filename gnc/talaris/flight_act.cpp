// Orders to the actuators in each phase.

#include <algorithm>
#include <cmath>

#include "gnc/math.h"
#include "gnc/talaris/flight.h"

namespace lss::gnc::talaris {
namespace {

constexpr double kBiasShare = 0.15, kBiasShareLost = 0.5;  // of the difference, each frame
constexpr double kMaxBias_m_s2 = 0.6, kMaxBiasLost_m_s2 = 12;
constexpr double kObserveAbove_m = 0.03, kObserveFirstAbove_m = 0.05;
constexpr double kWindShare = 0.15, kMaxWind_m_s2 = 3, kWindAbove_m = 0.2;
constexpr double kLeanStep_rad = 0.03;                 // of the commanded tilt, each frame
constexpr double kDownDamping = 1.7;                   // of the speed along y, near the ground
constexpr double kDampedBelow_m = 0.6;                 // there
constexpr double kLeanLag_s = 0.5;                     // attitude behind its command
constexpr double kProbeAfter_s = 0.4;                  // level
constexpr double kProbe_1_s = 0.04, kMostProbe = 0.1;  // of the weight, each second; at most
constexpr double kOverTime_s = 15, kSinks_1_s = 0.02;  // after max_run_s; lift lost each second
constexpr double kSinks_m_s = 0.1;
// By a speed of that sigma it goes back to its place along y as fast as that, also at the ground,
// when it is that near to it: else it would lean far just above the ground.
constexpr double kWellKnown_m_s = 0.03, kKnownWn_rad_s = 1.32, kNearPlace_m = 0.5;
constexpr double kRest_m = 0.06, kRest_m_s = 0.085;
constexpr double kFanStart = 0.8;  // of the weight, on the ground, before height is controlled
// Fans with too much or too little thrust are corrected: dead band of the weight share that is left
// to the gas, and speed and limit of the correction, as shares of the vehicle's weight.
constexpr double kShareOff = 0.15, kTrimShare = 0.1, kTrimShareFresh = 0.4, kMaxTrim = 0.08;
constexpr double kMostYield = 0.15;  // of the weight, less lift of the fans: 1.5 m/s2
constexpr double kMomentOff_Nm = 1, kMomentShare = 0.1, kMostMoment_Nm = 8;  // the same of moments
constexpr double kFresh_s = 2;                                               // after lift-off
constexpr double kBrakeSpeed_m_s = 0.6, kBrakeTime_s = 6;  // parachute: sideways first, then down
constexpr double kApproach_1_s = 0.8;
constexpr double kMaxLead_m = 0.1;
constexpr double kVelocityTime_s = 2.5;
constexpr double kLevelBelow_m = 0.4;
constexpr double kSoftSpeed_m_s = 0.2, kSoftSlope_1_s = 0.5;  // near the ground, by the fans

// Just off the ground.
bool fresh(Phase phase, double phase_s) noexcept {
  return phase == Phase::ascend && phase_s < kFresh_s;
}

}  // namespace

bool Flight::by_fans() const noexcept {
  return phase_ == Phase::parachute || (plan_.uses_fans && !plan_.uses_gas);
}

bool Flight::brakes() const noexcept {
  const Vector3& v = state_.velocity_N_m_s;
  return phase_ == Phase::parachute && imu_usable() && phase_s_ < kBrakeTime_s &&
         math::hypot(v.y(), v.z()) > kBrakeSpeed_m_s;
}

void Flight::act(const FlightInputs& inputs, FlightOutput& output) noexcept {
  if (allocates() || (airborne_ && by_fans())) fan_yield_N_ = fan_yield_step_N_ = 0;
  if (allocates()) {
    act_allocated(inputs, output);
  } else if (airborne_ && by_fans()) {
    fly_by_fans(inputs, output);
  } else {
    if (plan_.uses_fans && phase_ != Phase::touchdown) {
      trim_fans();
      trim_moments();
    }
    const bool fires = phase_ != Phase::spin_up && phase_ != Phase::touchdown &&
                       phase_ != Phase::landed && !by_fans();
    if (fires) {
      act_gas(output);
    } else {
      lift_before_N_ = lift_N_;
      lift_N_ = fan_yield_N_ = 0;
    }
    act_fans(inputs, output);
  }
  const auto& throttle = output.actuation.fan_throttle;
  const bool running = throttle[0] + throttle[1] + throttle[2] + throttle[3] > 0;
  fans_s_ = running ? fans_s_ + kFrame_s : 0;
}

// Compares the frame that just ended with its expectation: an error of thrust, mass or fans that
// control then takes into account.
void Flight::observe(const PerFan& rpm) noexcept {
  fans_before_N_ = fans_N_;
  if ((faults_ & kFansLost) == 0) fans_N_ = fan_thrust_N(watch_.usable(rpm), parameters_.fans);
  const Thrusters& t = parameters_.thrusters;
  const auto late = [&](double lift_N) {  // share of a frame's lift that comes in the next
    const double on = lift_N * kFrame_s / (4 * t.force_N);
    return on > 0 ? remaining_s(centred(on), parameters_.offset_s, t.lag_s) / on : 0.0;
  };
  const double lift = lift_N_ * (1 - late(lift_N_)) + lift_before_N_ * late(lift_before_N_);
  const double mass = gas_.mass_kg(parameters_.body.mass_kg);
  const double cosine = std::max(attitude_of(state_.q_NB).cosine, 0.0);
  const double total_N = lift + (fans_N_ + fans_before_N_) / 2;
  expected_m_s2_ = total_N * cosine / mass - kGravity_m_s2;
  observe_wind(total_N, mass);
  if (!airborne_ || impacted_ || !imu_usable() || silent_s_ > 0 || inputs_unheard_) return;
  const bool lost = (faults_ & kFansLost) != 0;
  // contact with the ground is no bias
  const bool blind = (faults_ & kAltimeterLost) != 0 && guidance_.time_to_go_s() < kMinTimeToGo_s;
  if (height_m_ < (observed_ ? kObserveAbove_m : kObserveFirstAbove_m) || blind) return;
  const double most = lost ? kMaxBiasLost_m_s2 : kMaxBias_m_s2;
  const double difference = state_.acceleration_N_m_s2.x() - expected_m_s2_ - bias_m_s2_;
  // the first value off the ground is as good as any
  const double share = lost ? kBiasShareLost : !observed_ ? 1 : kBiasShare;
  bias_m_s2_ = std::clamp(bias_m_s2_ + share * difference, -most, most);
  observed_ = true;
}

// Acceleration sideways that tilt and jets do not explain: wind, and the drag of the own speed.
void Flight::observe_wind(double lift_N, double mass_kg) noexcept {
  const bool known = airborne_ && heard_ && silent_s_ <= 0 && (faults_ & kFansLost) == 0;
  if (!known || height_m_ < kWindAbove_m || plan_.request.program != Program::hop) return;
  // the mean attitude of the frame
  const Quaternion half(1, -state_.rate_B_rad_s.x() * kFrame_s / 4,
                        -state_.rate_B_rad_s.y() * kFrame_s / 4,
                        -state_.rate_B_rad_s.z() * kFrame_s / 4);
  const Vector3 up = (state_.q_NB * half).normalized() * Vector3::UnitX();
  const double roll = attitude_of(state_.q_NB).roll_rad;
  const double side = by_fans() ? 0 : control_.side_N();
  Vector3 unexplained = state_.acceleration_N_m_s2 - lift_N / mass_kg * up -
                        side / mass_kg * Vector3(0, -math::sin(roll), math::cos(roll));
  unexplained.x() = 0;
  wind_m_s2_ += kWindShare * (unexplained - wind_m_s2_);
  if (const double size = wind_m_s2_.norm(); size > kMaxWind_m_s2)
    wind_m_s2_ *= kMaxWind_m_s2 / size;
}

// On rails or sled at the target: the smallest impulse of a jet would only move it away again.
bool Flight::rests() const noexcept {
  if (plan_.flies || phase_ != Phase::brake) return false;
  const Vector3 way = guidance_.target().position_m - state_.position_N_m;
  const Vector3 along(0, -math::sin(roll_rad_), math::cos(roll_rad_));
  return std::abs(way.dot(along)) < kRest_m &&
         std::abs(state_.velocity_N_m_s.dot(along)) < kRest_m_s;
}

// A vehicle that is light for its fans cannot descend: four shortest pulses a frame lift more than
// the fans leave. A heavy one runs out of gas.
void Flight::trim_fans() noexcept {
  const bool known = airborne_ && imu_usable() && silent_s_ <= 0 && (faults_ & kFansLost) == 0;
  if (!known || height_m_ < kObserveAbove_m) return;
  const double mass = gas_.mass_kg(parameters_.body.mass_kg);
  const double weight = parameters_.body.mass_kg * kGravity_m_s2;
  const double steady_N = fans_N_ - fan_yield_N_;
  const double left = mass * (kGravity_m_s2 - bias_m_s2_) - steady_N;  // to the gas
  const double wanted = (1 - parameters_.fans.weight_share) * weight;
  // at once and wholly when it has just left the ground: it would rise too high
  const bool now = fresh(phase_, phase_s_);
  const double off = now ? 0 : kShareOff, share = now ? kTrimShareFresh : kTrimShare;
  const double over = left - std::clamp(left, (1 - off) * wanted, (1 + off) * wanted);
  fan_trim_N_ = std::clamp(fan_trim_N_ + share * over, -kMaxTrim * weight, kMaxTrim * weight);
}

// At the end of a climb and the begin of a descent the shortest pulses of four valves lift more
// than guidance wants: the fans, which follow within a frame, give way before.
void Flight::yield_fans(double later_m_s2) noexcept {
  const double before_N = fan_yield_N_;
  const bool known = airborne_ && imu_usable() && (faults_ & kFansLost) == 0;
  const double mass = gas_.mass_kg(parameters_.body.mass_kg);
  const double weight = parameters_.body.mass_kg * kGravity_m_s2;
  const double steady_N = parameters_.fans.weight_share * weight + fan_trim_N_;
  const double left = mass * (kGravity_m_s2 + later_m_s2 - bias_m_s2_) - steady_N;  // to the gas
  const double least = (1 - kShareOff) * (1 - parameters_.fans.weight_share) * weight;
  fan_yield_N_ = known ? std::clamp(left - least, -kMostYield * weight, 0.0) : 0;
  fan_yield_step_N_ = fan_yield_N_ - before_N;
}

// What turns it all the time is left to the fans: the pulses have their room for the rest.
void Flight::trim_moments() noexcept {
  const bool known = airborne_ && heard_ && silent_s_ <= 0 && (faults_ & kFansLost) == 0;
  if (!known || height_m_ < kObserveAbove_m || impacted_) return;
  const auto trim = [](double& moment_Nm, double turns_Nm) {
    const double over_Nm = turns_Nm - std::clamp(turns_Nm, -kMomentOff_Nm, kMomentOff_Nm);
    moment_Nm = std::clamp(moment_Nm - kMomentShare * over_Nm, -kMostMoment_Nm, kMostMoment_Nm);
  };
  trim(fan_y_Nm_, parameters_.body.inertia_y_kg_m2 * control_.disturbance_y());
  trim(fan_z_Nm_, parameters_.body.inertia_z_kg_m2 * control_.disturbance_z());
}

void Flight::act_fans(const FlightInputs& inputs, FlightOutput& output) noexcept {
  const Fans& fans = parameters_.fans;
  if (!plan_.uses_fans) return;
  const double weight = parameters_.body.mass_kg * kGravity_m_s2;
  if (phase_ != Phase::touchdown) {
    // On the way down it takes lift away as long as that has no effect: the ground shows itself.
    const bool down = phase_ == Phase::descend || phase_ == Phase::escape;
    const bool carried = down && (touchdown_.level_s() >= kProbeAfter_s || impacted_);
    fan_probe_N_ =
        carried ? std::min(fan_probe_N_ + kProbe_1_s * kFrame_s * weight, kMostProbe * weight)
                : fan_probe_N_ / 2;
    const double planned =
        parameters_.fans.weight_share * weight + fan_trim_N_ + fan_yield_N_ - fan_probe_N_;
    fan_goal_rpm_ = rpm_for(plan_.uses_gas ? planned : kFanStart * weight, fans);
  }
  PerFan goal{};
  const double each_N = fan_thrust_N(fan_goal_rpm_, fans);
  const double y_N = fan_y_Nm_ / (kFans * fans.z_m), z_N = fan_z_Nm_ / (kFans * fans.y_m);
  for (std::size_t i = 0; i < kFans; ++i) {
    const double force_N = each_N + kLiftZ[i] * y_N - kLiftY[i] * z_N;
    goal[i] = std::min(std::sqrt(std::max(force_N, 0.0) / fans.thrust_N_per_rpm2), fans.max_rpm);
  }
  PerFan throttle{};
  if (phase_ == Phase::touchdown) {
    // one valve open and light on its legs it would turn over
    const double left = watch_.good() ? 1 - phase_s_ / parameters_.limits.run_down_s : 0;
    goal.fill(std::max(std::min(fan_goal_rpm_, plan_.fan_rpm) * left, 0.0));
    throttle = (faults_ & kFansLost) != 0 ? PerFan{} : fan_speed_.direct(goal, inputs.rpm);
  } else if ((faults_ & kFansLost) != 0) {
    throttle = fan_speed_.blind(goal);
  } else {
    throttle = fan_speed_.ramp(goal, fans.ramp_rpm_s, inputs.rpm);
  }
  output.rpm_target = goal;
  output.actuation.fan_throttle = throttle;
}

void Flight::act_gas(FlightOutput& output) noexcept {
  const Program program = plan_.request.program;
  const Thrusters& t = parameters_.thrusters;
  const double mass = gas_.mass_kg(parameters_.body.mass_kg);
  const double ahead = parameters_.offset_s + kFrame_s / 2;

  // the fans are where they shall be at the end of the frame
  const double later = ahead + kFrame_s / 2;
  double later_m_s2 = 0;

  ControlTarget target;
  target.roll_rad = roll_rad_;
  Vector3 acceleration = Vector3::Zero();
  const bool guided = phase_ != Phase::turn || plan_.flies;
  if (guided && phase_ != Phase::keep) {
    acceleration = guidance_.step(state_.position_N_m, state_.velocity_N_m_s, ahead);
    later_m_s2 = guidance_.wanted_m_s2(later).x();
  }
  if (plan_.flies && phase_ == Phase::traverse) {
    // the traverse has many seconds to go, the height has not: it is controlled in every frame
    const Coefficients up =
        e_guidance(state_.position_N_m, state_.velocity_N_m_s, guidance_.target(), kMinTimeToGo_s);
    acceleration.x() = up.c0_m_s2.x() + up.c1_m_s3.x() * ahead;
    later_m_s2 = up.c0_m_s2.x() + up.c1_m_s3.x() * later;
  }
  if (plan_.flies) yield_fans(later_m_s2);
  const Attitude attitude = attitude_of(state_.q_NB);
  const double cosine = std::max(attitude.cosine, 0.5);
  const double fans_N = fans_N_ + fan_yield_step_N_ / 2;  // in the middle of the frame
  target.force_N =
      gas_force_N(acceleration - Vector3(bias_m_s2_, 0, 0), mass, Vector3(fans_N * cosine, 0, 0));
  const bool stand = program == Program::altitude || program == Program::attitude;
  target.lift = plan_.flies || program == Program::attitude;
  target.side = guided && !stand && !rests();
  target.roll = !stand && program != Program::traverse;
  target.full = (faults_ & kFansLost) != 0;
  target.fresh = fresh(phase_, phase_s_);
  target.unheard = inputs_unheard_;
  if (program == Program::attitude) {
    target.force_N = Vector3(4 * t.force_N * parameters_.profile.stand_on_s / kFrame_s, 0, 0);
  }
  if (program == Program::hop) {
    // along y there is no jet
    const double c = math::cos(roll_rad_), s = math::sin(roll_rad_);
    const Vector3 off = state_.position_N_m - leg_m_, v = state_.velocity_N_m_s;
    // against the wind it leans, which costs no gas
    const double push_y = c * wind_m_s2_.y() + s * wind_m_s2_.z();
    const double push_z = c * wind_m_s2_.z() - s * wind_m_s2_.y();
    const double most = gain().lateral_max_tilt_rad;
    const auto lean = [](double& now, double wanted) {
      now += std::clamp(wanted - now, -kLeanStep_rad, kLeanStep_rad);
    };
    const bool known = phase_ == Phase::descend && reaction_ <= Reaction::hold &&
                       state_.velocity_sigma_m_s.tail<2>().maxCoeff() < kWellKnown_m_s &&
                       std::abs(c * off.y() + s * off.z()) < kNearPlace_m;
    Gains gains = gain();
    if (known) gains.lateral_wn_rad_s = std::max(gains.lateral_wn_rad_s, kKnownWn_rad_s);
    // at the ground the speed counts, not the place, unless the speed is known
    const bool low = phase_ == Phase::descend && height_m_ < kDampedBelow_m;
    const bool down = (low && !known) || phase_ == Phase::escape;
    // the attitude follows late: with the speed that it has by then
    const double soon_m_s =
        c * v.y() + s * v.z() + kLeanLag_s * (kGravity_m_s2 * attitude.tilt_z_rad + push_y);
    lean(lean_z_rad_, tilt_for_y(c * off.y() + s * off.z(), (down ? kDownDamping : 1) * soon_m_s,
                                 gains, push_y));
    // Not against what pushes it the way it wants to go: the drag that brakes it is gone when it
    // stands, and a lean against it would push it on.
    const double wanted_z = c * acceleration.z() - s * acceleration.y();
    const double helps = push_z * wanted_z > 0 ? std::min(std::abs(wanted_z / push_z), 1.0) : 0;
    lean(lean_y_rad_, std::clamp((1 - helps) * push_z / kGravity_m_s2, -most, most));
    target.tilt_y_rad = lean_y_rad_;
    target.tilt_z_rad = lean_z_rad_;
  }
  const ControlOutput out = control_.step(state_, target);
  output.actuation.valve = out.valve;
  output.attitude_error_rad = out.error_rad;
  output.force_N = target.force_N;
  lift_before_N_ = lift_N_;
  lift_N_ = out.lift_N;
}

void Flight::fly_by_fans(const FlightInputs& inputs, FlightOutput& output) noexcept {
  const Limits& limits = parameters_.limits;
  lift_before_N_ = lift_N_;
  lift_N_ = 0;
  const Attitude attitude = attitude_of(state_.q_NB);
  double tilt_y = attitude.tilt_y_rad, tilt_z = attitude.tilt_z_rad;
  const bool held = plan_.request.program == Program::fan_altitude;  // by the stand
  double speed = 0, height = kNaN;

  if (phase_ == Phase::parachute) {
    const double c = math::cos(attitude.roll_rad), s = math::sin(attitude.roll_rad);
    const Vector3 v = state_.velocity_N_m_s;
    const double vy = c * v.y() + s * v.z(), vz = -s * v.y() + c * v.z();
    if (imu_usable() && height_m_ > kLevelBelow_m) {
      const double most = gain().fan_max_tilt_rad * kGravity_m_s2;
      tilt_y += std::clamp(-vz / kVelocityTime_s, -most, most) / kGravity_m_s2;
      tilt_z -= std::clamp(-vy / kVelocityTime_s, -most, most) / kGravity_m_s2;
    }
    // without attitude the tilt grows every second
    const bool hot = (faults_ & kRunTime) != 0;
    const double most = imu_usable() && !hot ? limits.parachute_m_s : limits.level_m_s;
    const double soft = std::max(kSoftSpeed_m_s + kSoftSlope_1_s * height_m_, kSoftSpeed_m_s);
    speed = brakes() ? 0 : -std::min(soft, most);
  } else {
    const double step = gain().height_rate_m_s * kFrame_s;
    const double goal = phase_ == Phase::descend ? -1 : plan_.request.height_m;
    // slows down before the goal: the fans' lag would make it overshoot
    const double moved = std::clamp(kApproach_1_s * kFrame_s * (goal - fan_height_m_), -step, step);
    fan_height_m_ += moved;
    // waits for a vehicle that does not follow yet: its integral would only wind up
    if (std::isfinite(height_m_)) {
      fan_height_m_ = std::clamp(fan_height_m_, height_m_ - kMaxLead_m, height_m_ + kMaxLead_m);
    }
    height = fan_height_m_;
    speed = moved / kFrame_s;
  }
  if (held || !imu_usable()) tilt_y = tilt_z = kNaN;

  const double mass = gas_.mass_kg(parameters_.body.mass_kg);
  PerFan rpm =
      fan_flight_.step({height_m_, climb_m_s_, bias_m_s2_}, height, speed, mass, tilt_y, tilt_z,
                       state_.rate_B_rad_s, inputs.rpm, parameters_.offset_s,
                       control_.disturbance_y() - fan_y_Nm_ / parameters_.body.inertia_y_kg_m2,
                       control_.disturbance_z() - fan_z_Nm_ / parameters_.body.inertia_z_kg_m2);
  // Much too long in the air: it has to come down whatever the sensors say, but not to fall.
  const bool sinks = climb_m_s_ < -kSinks_m_s && (faults_ & kAltimeterLost) == 0;
  const bool over = fans_s_ > parameters_.fans.max_run_s + kOverTime_s;
  weak_s_ = over && !sinks ? weak_s_ + kFrame_s : 0;
  if (weak_s_ > 0) {
    const double weight = mass * kGravity_m_s2;
    const double most_rpm =
        rpm_for(std::max(1 - kSinks_1_s * weak_s_, 0.0) * weight, parameters_.fans);
    for (double& each : rpm) each = std::min(each, most_rpm);
  }
  output.rpm_target = rpm;
  output.actuation.fan_throttle = fan_speed_.direct(rpm, inputs.rpm);
  output.attitude_error_rad =
      Vector3(0, std::isfinite(tilt_y) ? tilt_y : 0, std::isfinite(tilt_z) ? tilt_z : 0);
  fan_goal_rpm_ = (rpm[0] + rpm[1] + rpm[2] + rpm[3]) / kFans;
}

}  // namespace lss::gnc::talaris
