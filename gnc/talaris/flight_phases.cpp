// The sequence of phases, and the target of guidance in each.

#include <algorithm>
#include <cmath>

#include "gnc/math.h"
#include "gnc/talaris/flight.h"

namespace lss::gnc::talaris {
namespace {

constexpr double kStopping_m_s2 = 1.2;                // sideways, when a flight is cut short
constexpr double kContactBelow_m = 0.4;               // accelerations are ignored above
constexpr double kShock = 1.6, kShockBelow_m = 0.15;  // one frame of that is enough
constexpr double kJoltBelow_m = 0.2;  // a foot 0.4 m out, on a slope of 12 deg, and some error
// Speed that a shock takes away within two frames, and what is left of it: the ground, wherever the
// altimeter has it. A valve stuck open adds 0.5 m/s in that time, without a shock.
constexpr double kStruck_m_s = 0.55, kStopped_m_s = 0.35, kRises_m_s = 0.1;
constexpr double kImpact_m_s = 0.25;    // then what pushes it up is the ground, too
constexpr double kOverdue_s = 4;        // then a lost altimeter is not waited for
constexpr double kGivenUp_s = 12;       // so low and so long overdue it must stand
constexpr double kSlowEnd_s = 4;        // by fans: until it sinks, and slower near the ground
constexpr double kStandingTime_s = 12;  // on the ground, at most
constexpr double kLastLimit_s = 40;     // in the air, beyond the time that the fans may run
constexpr double kLongestHold_s = 4;
// Sideways: so fast it waits, so slow it goes on; heights at which it waits, and how long in all.
constexpr double kGust_m_s = 0.3, kCalm_m_s = 0.15, kKnown_m_s = 0.1;
constexpr double kWaitAbove_m = 0.2, kWaitBelow_m = 0.6, kLongestWait_s = 4;
constexpr double kThere_m = 0.12;
constexpr double kStill_m_s = 0.085;  // more than half the change by the shortest pulse of two jets

Vector3 along(double roll_rad) noexcept { return {0, -math::sin(roll_rad), math::cos(roll_rad)}; }

}  // namespace

void Flight::advance(const FlightInputs& inputs) noexcept {
  if (phase_ == Phase::touchdown) {
    note_touchdown();
    if (phase_s_ < parameters_.limits.run_down_s) return;
    judge_landing();
    enter(Phase::landed);
    return;
  }
  if (airborne_) {
    // pulses shake it in the air
    const bool pulsed = plan_.request.program == Program::hop && (faults_ & kValvesLost) == 0;
    if (pulsed && !by_fans() && touchdown_.stands()) {
      const bool down = phase_ == Phase::descend || phase_ == Phase::escape;
      if (!down) fall_short(Shortfall::no_lift_off);
      note_contact();
      return;
    }
    if (fans_s_ > parameters_.fans.max_run_s + kLastLimit_s) return all_stop();
    if ((phase_ == Phase::descend || phase_ == Phase::escape || phase_ == Phase::parachute) &&
        touches(inputs)) {
      note_contact();
    } else {
      advance_in_air();
    }
    const double turns_m_s = kFoot_m * state_.rate_B_rad_s.tail<2>().norm();
    before_ = {before_[1], {state_.velocity_N_m_s, falls_m_s(), turns_m_s, swing()}};
    return;
  }
  if (phase_ == Phase::spin_up && silent_s_ > 0) return;  // begins when its position is known
  if (phase_ == Phase::spin_up && plan_.flies) {
    bool there = true;
    for (std::size_t i = 0; i < kFans; ++i) {
      there = there && std::abs(inputs.rpm[i] - fan_goal_rpm_) <= parameters_.fans.settled_rpm;
    }
    settle_s_ = there ? settle_s_ + kFrame_s : 0;
    if (there && settle_s_ >= parameters_.fans.settled_s) leave_ground();
    return;
  }
  advance_on_ground();
}

// By which it may come down faster before the next state: as it accelerates now for a whole frame,
// and half a gap between two pulses. A pulse of all lift valves is in the middle of its frame: at
// the end of one the vehicle is in the middle of the gap.
double Flight::falls_m_s() const noexcept {
  const double up_m_s2 = expected_m_s2_ + bias_m_s2_;
  const double on_s = lift_N_ * kFrame_s / (4 * parameters_.thrusters.force_N);
  const double gap_m_s2 = lift_N_ / gas_.mass_kg(parameters_.body.mass_kg) - up_m_s2;
  const double gap_s = lift_N_ > 0 ? std::max(kFrame_s - on_s, 0.0) : 0;
  return std::max(-up_m_s2, 0.0) * kFrame_s + std::max(gap_m_s2, 0.0) * gap_s / 2;
}

void Flight::leave_ground() noexcept {
  airborne_ = true;
  fan_height_m_ = 0;
  fan_flight_.begin(true);
  Target target;
  target.position_m = start_m_ + Vector3(plan_.request.height_m, 0, 0);
  target.time_to_go_s = plan_.climb_s;
  leg_m_ = goal_m_ = target.position_m;
  corridor_.begin(start_m_, leg_m_, target.time_to_go_s);
  guidance_.aim(target);
  enter(Phase::ascend);
}

void Flight::begin_leg() noexcept {
  Target target;
  if (!plan_.flies) leg_m_ = state_.position_N_m;
  target.position_m = leg_m_ + plan_.request.distance_m * along(roll_rad_);
  target.time_to_go_s = traverse_s_;
  corridor_.begin(leg_m_, target.position_m, traverse_s_);
  goal_m_ = target.position_m;
  guidance_.aim(target);
  enter(Phase::traverse);
}

// Of the traverse from a standstill at `from_m`: the shorter way has the same peak of acceleration.
double Flight::leg_left_s(const Vector3& from_m) const noexcept {
  const double left_m = (goal_m_ - from_m).tail<2>().norm();
  const double whole_m = std::max(std::abs(plan_.request.distance_m), 0.1);
  return std::max(plan_.traverse_s * std::sqrt(std::min(left_m / whole_m, 1.0)),
                  2 * kMinTimeToGo_s);
}

// Keep and descent, as planned.
double Flight::after_traverse_s() const noexcept {
  return plan_.total_s - plan_.climb_s - plan_.hover_s - plan_.turn_s - plan_.traverse_s;
}

// Gas for a hold that begins now: to stop, and for the rest of the way after it.
double Flight::hold_gas_s() const noexcept {
  const Vector3 v(0, state_.velocity_N_m_s.y(), state_.velocity_N_m_s.z());
  const double stop_s = std::max(v.norm() / kStopping_m_s2, kMinTimeToGo_s);
  const double way_s = leg_left_s(state_.position_N_m + stop_s / 2 * v) + after_traverse_s();
  return hover_thrusters(parameters_) * stop_s +
         parameters_.body.mass_kg * v.norm() / parameters_.thrusters.force_N +
         plan_.gas_s * way_s / plan_.total_s;
}

// The traverse, after a hold: from here, at the planned mean speed.
void Flight::resume() noexcept {
  Target target;
  target.position_m = goal_m_;
  const double waited_s = flown_s_;
  target.time_to_go_s = leg_left_s(state_.position_N_m);
  leg_m_ = target.position_m;
  traverse_s_ = target.time_to_go_s;
  extra_s_ = std::max(waited_s + traverse_s_ + after_traverse_s() - plan_.total_s, 0.0);
  corridor_.begin(state_.position_N_m, goal_m_, traverse_s_);
  guidance_.aim(target);
  enter(Phase::traverse);
}

// After the turn, or instead of it.
void Flight::next_leg() noexcept {
  if (plan_.traverse_s > 0) {
    begin_leg();
  } else if (plan_.flies) {
    enter(Phase::brake);
  } else {
    enter(Phase::landed);
  }
}

void Flight::turn_or_go() noexcept {
  if (!(plan_.turn_s > 0)) return next_leg();
  roll_rad_ = wrapped(start_roll_rad_ + plan_.request.turn_rad);
  settle_s_ = 0;
  enter(Phase::turn);
}

bool Flight::turned() noexcept {
  const Profile& profile = parameters_.profile;
  const double error = wrapped(attitude_of(state_.q_NB).roll_rad - roll_rad_);
  const bool still = std::abs(error) <= profile.settle_angle_rad &&
                     std::abs(state_.rate_B_rad_s.x()) <= profile.settle_rate_rad_s;
  settle_s_ = still ? settle_s_ + kFrame_s : 0;
  if (settle_s_ >= profile.settle_s) return true;
  if (phase_s_ < plan_.turn_s + profile.turn_timeout_s) return false;
  settled_ = false;
  return true;
}

void Flight::advance_in_air() noexcept {
  switch (phase_) {
    case Phase::ascend:
      if (phase_s_ >= plan_.climb_s) enter(Phase::hover);
      return;
    case Phase::hover:
      if (phase_s_ >= plan_.hover_s) turn_or_go();
      return;
    case Phase::turn:
      if (turned()) next_leg();
      return;
    case Phase::traverse:
      if (phase_s_ >= traverse_s_) enter(Phase::brake);
      return;
    case Phase::hold:
      if ((now_judged_.back && guidance_.time_to_go_s() <= 0) || phase_s_ >= kLongestHold_s)
        resume();
      return;
    case Phase::brake:
      if (phase_s_ < brake_s_) return;
      if (plan_.request.program == Program::parachute) {
        fan_flight_.begin();
        enter(Phase::parachute);
      } else {
        if (plan_.uses_gas) {
          descend_to(guidance_.target().position_m);
          corridor_.begin(corridor_.place_N_m(), leg_m_, guidance_.time_to_go_s());
        }
        enter(Phase::descend);
      }
      return;
    case Phase::descend: return wait_for_calm();
    default: return;
  }
}

void Flight::advance_on_ground() noexcept {
  const Program program = plan_.request.program;
  switch (phase_) {
    case Phase::spin_up:  // without fans: begins at once
      if (program == Program::attitude) {
        enter(Phase::keep);
      } else {
        turn_or_go();
      }
      return;
    case Phase::turn:
      if (turned()) next_leg();
      return;
    case Phase::traverse:
      if (phase_s_ < plan_.traverse_s) return;
      settle_s_ = 0;
      enter(Phase::brake);
      return;
    case Phase::brake: {
      const Vector3 way = guidance_.target().position_m - state_.position_N_m;
      const bool there = std::abs(way.dot(along(roll_rad_))) <= kThere_m;
      const bool still = std::abs(state_.velocity_N_m_s.dot(along(roll_rad_))) <= kStill_m_s;
      settle_s_ = there && still ? settle_s_ + kFrame_s : 0;
      if (settle_s_ < parameters_.profile.settle_s && phase_s_ < kStandingTime_s) return;
      settled_ = settled_ && there;
      enter(Phase::landed);
      return;
    }
    case Phase::keep:
      if (phase_s_ >= plan_.keep_s) enter(Phase::landed);
      return;
    default: return;
  }
}

void Flight::stop_here() noexcept {
  Target target;
  const Vector3 v(0, state_.velocity_N_m_s.y(), state_.velocity_N_m_s.z());
  target.time_to_go_s = std::max(v.norm() / kStopping_m_s2, kMinTimeToGo_s);
  target.position_m = state_.position_N_m + v * (target.time_to_go_s / 2);
  leg_m_ = target.position_m;
  guidance_.aim(target);
}

// Near the ground a gust is waited for, as long as the gas lasts: it stops, then comes down again.
void Flight::wait_for_calm() noexcept {
  if (plan_.request.program != Program::hop || by_fans()) return;
  const Vector3 v = state_.velocity_N_m_s;
  const double side_m_s = math::hypot(v.y(), v.z());
  if (waits_) waited_s_ += kFrame_s;
  // An error of its speed only grows meanwhile.
  const bool known = state_.velocity_sigma_m_s.tail<2>().maxCoeff() < kKnown_m_s;
  const bool may = known && reaction_ <= Reaction::hold && waited_s_ < kLongestWait_s &&
                   gas_.left_s() > landing_gas_s() + parameters_.gas.reserve_s / 2;
  if (waits_) {
    if (side_m_s > kCalm_m_s && may) return;
    waits_ = false;
    descend_to(leg_m_);
    return;
  }
  if (side_m_s < kGust_m_s || height_m_ < kWaitAbove_m || height_m_ > kWaitBelow_m || !may) return;
  waits_ = true;
  const Vector3 place = leg_m_;
  stop_here();
  Target target = guidance_.target();
  target.position_m.tail<2>() = place.tail<2>();  // blown off by the gust, it comes back
  target.position_m.x() += std::max(v.x() * kMinTimeToGo_s / 3, kWaitAbove_m - height_m_);
  leg_m_ = target.position_m;
  guidance_.aim(target);
}

// A controlled descent: at its planned position.
void Flight::descend_to(const Vector3& place_m) noexcept {
  const Vector3 place = place_m;  // of the target that come_down() replaces
  come_down(parameters_.profile.descend_m_s2, parameters_.profile.touchdown_speed_m_s,
            parameters_.profile.touchdown_height_m);
  Target target = guidance_.target();
  target.position_m.tail<2>() = place.tail<2>();
  leg_m_ = target.position_m;
  guidance_.aim(target);
}

// From here to `end_height_m` above the start, there with `end_speed_m_s` down, 0 sideways.
void Flight::come_down(double peak_m_s2, double end_speed_m_s, double end_height_m) noexcept {
  const Vector3 v = state_.velocity_N_m_s;
  const Vector3 sideways(0, v.y(), v.z());
  const double way = std::max(height_m_ - end_height_m, 0.0);
  const double down =
      std::max(std::sqrt(6 * way / peak_m_s2), kMinTimeToGo_s) + std::max(v.x(), 0.0) / peak_m_s2;
  Target target;
  target.time_to_go_s = std::max(down, sideways.norm() / kStopping_m_s2);
  target.position_m = state_.position_N_m + sideways * (target.time_to_go_s / 2);
  // already below: continues down with that speed
  const double end = std::min(end_height_m, height_m_ - end_speed_m_s * target.time_to_go_s / 2);
  target.position_m.x() = start_m_.x() + end;
  target.velocity_m_s.x() = -end_speed_m_s;
  leg_m_ = target.position_m;
  below_s_ = -target.time_to_go_s - std::max(end, 0.0) / end_speed_m_s;
  guidance_.aim(target);
}

// Ground contact in descent: low and slow, or pushed up by more than the commanded lift.
bool Flight::touches(const FlightInputs& inputs) noexcept {
  const Limits& limits = parameters_.limits;
  const bool blind = (faults_ & kAltimeterLost) != 0;
  const bool low =
      height_m_ < limits.contact_height_m && std::abs(climb_m_s_) < limits.contact_speed_m_s;
  low_frames_ = low && !blind ? low_frames_ + 1 : 0;
  const double more = state_.acceleration_N_m_s2.x() - expected_m_s2_ - bias_m_s2_;
  // What the ground takes of its speed, whatever height and speed navigation has.
  const bool felt = heard_ && silent_s_ <= 0;
  const double taken_m_s = felt ? (more + more_m_s2_) * kFrame_s : 0;
  if (taken_m_s > impact_m_s_) {
    impact_m_s_ = taken_m_s;
    before_impact_ = before_;
  }
  const bool stopped =
      inputs.shock && std::abs(climb_m_s_) < kStopped_m_s && (faults_ & kFansLost) == 0;
  const bool struck = stopped && taken_m_s > kStruck_m_s;
  impacted_ = impacted_ || (stopped && taken_m_s > kImpact_m_s);
  // without a known height, only once the ground is due
  const bool near = impacted_ || (blind ? below_s_ > -kGuidancePeriod_s - kMinTimeToGo_s
                                        : height_m_ < kContactBelow_m);
  more_m_s2_ = felt ? std::max(more, 0.0) : 0;
  const bool asked = imu_usable() && silent_s_ <= 0 && near;
  const bool held = asked && more > limits.contact_m_s2;
  const bool shock =
      asked && more > kShock * limits.contact_m_s2 && (blind || height_m_ < kShockBelow_m);
  contact_frames_ = held ? contact_frames_ + 1 : 0;
  // without IMU the direction of the altimeter is unknown: the vehicle may lie on its side
  const bool high = !blind && imu_usable() && height_m_ > kContactBelow_m;
  if (high && (by_fans() || below_s_ > 0)) {
    below_s_ = -ground_due_s();  // slower than planned
  } else if (!brakes()) {
    below_s_ += kFrame_s;
  }
  // Pulses turn it as much when one of the valves failed. No foot comes down while it climbs.
  const bool jolt = asked && inputs.jolt && !blind && height_m_ < kJoltBelow_m &&
                    climb_m_s_ < kRises_m_s && watch_.good() && !by_fans();
  const bool knocks = inputs.contact || inputs.shock || jolt;
  if (low_frames_ >= 2 || contact_frames_ >= 2 || shock || (near && knocks)) return true;
  if (imu_usable() && (struck || touchdown_.supported())) return true;
  // Fans and valves are never cut by the clock while it is known to be high.
  return !high && below_s_ > (blind ? kOverdue_s : kGivenUp_s);
}

// From here, as slowly as allowed: the IMU may be lost on the way.
double Flight::ground_due_s() const noexcept {
  const double high = std::isfinite(height_m_) ? std::max(height_m_, 0.0) : 0;
  if (!by_fans()) return high / parameters_.profile.touchdown_speed_m_s;
  const Limits& limits = parameters_.limits;
  const double speed = phase_ != Phase::parachute ? gain().height_rate_m_s
                       : imu_usable()             ? std::min(limits.parachute_m_s, limits.level_m_s)
                                                  : limits.level_m_s;
  return high / speed + kSlowEnd_s;
}

double Flight::landing_gas_s() const noexcept {
  const Vector3 v = state_.velocity_N_m_s;
  const double sideways = math::hypot(v.y(), v.z());
  const double down = std::sqrt(6 * std::max(height_m_, 0.0) / parameters_.limits.escape_m_s2) + 1;
  return hover_thrusters(parameters_) * std::max(down, sideways / kStopping_m_s2) +
         parameters_.body.mass_kg * sideways / parameters_.thrusters.force_N;
}

double Flight::needed_gas_s() const noexcept {
  if (!plan_.uses_gas || phase_ == Phase::touchdown || phase_ == Phase::parachute) return 0;
  if (phase_ == Phase::escape || phase_ == Phase::descend) return landing_gas_s();
  if (plan_.total_s <= 0) return 0;
  // by time; the traverse is what costs more than hovering
  const double elapsed = airborne_ ? flown_s_ - extra_s_ : 0;
  return plan_.gas_s * std::clamp(1 - elapsed / plan_.total_s, 0.0, 1.0);
}

}  // namespace lss::gnc::talaris
