// Flight with failed valves or fans: detection, and a landing with what is left, by control
// allocation over all actuators.

#include <algorithm>
#include <cmath>

#include "gnc/math.h"
#include "gnc/talaris/flight.h"

namespace lss::gnc::talaris {
namespace {

constexpr double kSpeedsOld_s = 0.06;  // rpm that old says nothing of this frame
constexpr double kJitter_s = 0.03;     // of a frame's length
constexpr double kFresh_s = 1;         // off the ground, until its baseline is known
constexpr double kWatchAbove_m = 0.05;
constexpr double kWatchAboveDown_m = 0.25;  // the ground is no failure
// The way down: speed at the ground, more with height, at most; how it is controlled.
constexpr double kSoft_m_s = 0.25;
constexpr double kFaster_1_s = 0.4;
constexpr double kFastest_m_s = 1.0;
constexpr double kBlind_m_s = 0.4;
constexpr double kSpeed_1_s = 1.8;
constexpr double kMostDown_m_s2 = 3;
constexpr double kMostUp_m_s2 = 4;
constexpr double kBrake_1_s = 1.2;
constexpr double kBrake_m_s2 = 3;
constexpr double kLean_rad = 0.3;
constexpr double kLowBelow_m = 0.5;
constexpr double kLowTilt_rad = 0.05;
constexpr double kWn_rad_s = 2.5;
constexpr double kZeta = 0.9;
constexpr double kRoll_1_s = 1.8;
constexpr double kRollStill_rad_s = 3 * kDegree;
// Weights of the squared errors, in N and N m: attitude first, then lift, roll and the way
// sideways; and of the squared newtons off the equilibrium: fans move last.
constexpr double kTiltWeight = 1;
constexpr double kLiftWeight = 5e-4;
constexpr double kRollWeight = 0.05;
constexpr double kSideWeight = 5e-5;
constexpr double kValveCost = 5e-6;
constexpr double kFanCost = 5e-5;
constexpr double kFanCostAtRest = 2.5e-6;
constexpr double kFanShare = 0.95;  // of its most thrust, in the equilibrium

WrenchB weights() noexcept {
  WrenchB weight;
  weight << kLiftWeight, kSideWeight, kRollWeight, kTiltWeight, kTiltWeight;
  return weight;
}

}  // namespace

// Time that each valve was open in the frame that just ended.
std::array<double, kValves> Flight::open_in_frame_s() const noexcept {
  const double offset_s = parameters_.offset_s, lag_s = parameters_.thrusters.lag_s;
  std::array<double, kValves> open_s{};
  for (std::size_t i = 0; i < kValves; ++i) {
    open_s[i] = fired_[i].on_s - remaining_s(fired_[i], offset_s, lag_s) +
                remaining_s(fired_before_[i], offset_s, lag_s);
  }
  return open_s;
}

void Flight::watch_actuators(const FlightInputs& inputs) noexcept {
  if (plan_.request.program != Program::hop) return;  // stands carry and turn it, too
  const bool known = heard_ && silent_s_ <= 0;
  const bool down =
      phase_ == Phase::descend || phase_ == Phase::escape || phase_ == Phase::parachute;
  const bool clear = height_m_ > (down ? kWatchAboveDown_m : kWatchAbove_m) && !inputs.shock &&
                     !inputs.contact && !impacted_;
  WatchFrame frame;
  frame.speeds = inputs.fan_age_s < kSpeedsOld_s && (faults_ & kFansLost) == 0;
  frame.measured = known && known_before_ && airborne_ && clear &&
                   (faults_ & (kValvesLost | kPressureLost)) == 0;
  // a frame that was skipped: the pulses before came twice
  const double apart_s = static_cast<double>(inputs.time_ns - watched_ns_) * 1e-9;
  frame.unheard = inputs.unheard || std::abs(apart_s - kFrame_s) > kJitter_s;
  watched_ns_ = inputs.time_ns;
  frame.fresh = phase_ == Phase::ascend && phase_s_ < kFresh_s;
  frame.rate_B_rad_s = state_.rate_B_rad_s;
  frame.rate_before_B_rad_s = rate_before_B_rad_s_;
  const Vector3 half = -state_.rate_B_rad_s * (kFrame_s / 4);
  const Quaternion middle =
      (state_.q_NB * Quaternion(1, half.x(), half.y(), half.z())).normalized();
  frame.force_B_m_s2 =
      middle.conjugate() * Vector3(state_.acceleration_N_m_s2 + kGravity_m_s2 * Vector3::UnitX());
  frame.mass_kg = gas_.mass_kg(parameters_.body.mass_kg);
  frame.open_s = open_in_frame_s();
  frame.rpm = inputs.rpm;
  frame.rpm_before = rpm_before_;
  frame.rpm_expected = airborne_ ? fan_speed_.reference_rpm() : PerFan{};
  watch_.step(frame);
  known_before_ = known;
  rate_before_B_rad_s_ = state_.rate_B_rad_s;
  rpm_before_ = inputs.rpm;
}

bool Flight::allocates() const noexcept {
  return airborne_ && !watch_.good() && imu_usable() && (faults_ & kFansLost) == 0;
}

// Down, here, with what is left.
void Flight::act_allocated(const FlightInputs& inputs, FlightOutput& output) noexcept {
  const Thrusters& t = parameters_.thrusters;
  const Fans& fans = parameters_.fans;
  const Body& body = parameters_.body;
  const double mass = gas_.mass_kg(body.mass_kg);
  const Attitude attitude = attitude_of(state_.q_NB);
  const double cosine = std::max(attitude.cosine, 0.5);
  const bool gas = (faults_ & (kValvesLost | kPressureLost)) == 0;
  const Healths& health = watch_.health();

  // where to
  const Vector3 v = state_.velocity_N_m_s;
  const bool high = std::isfinite(height_m_);
  const double speed_m_s =
      high ? -std::min(kSoft_m_s + kFaster_1_s * std::max(height_m_, 0.0), kFastest_m_s)
           : -kBlind_m_s;
  const double climb = std::isfinite(climb_m_s_) ? climb_m_s_ : 0;
  const double up_m_s2 =
      std::clamp(kSpeed_1_s * (speed_m_s - climb), -kMostDown_m_s2, kMostUp_m_s2);
  Vector3 stop_m_s2 = -kBrake_1_s * Vector3(0, v.y(), v.z());
  if (const double size = stop_m_s2.norm(); size > kBrake_m_s2) stop_m_s2 *= kBrake_m_s2 / size;
  const double c = math::cos(attitude.roll_rad), s = math::sin(attitude.roll_rad);
  const double stop_y = c * stop_m_s2.y() + s * stop_m_s2.z();
  const double stop_z = -s * stop_m_s2.y() + c * stop_m_s2.z();
  const double most_rad = high && height_m_ < kLowBelow_m ? kLowTilt_rad : kLean_rad;
  lean_z_rad_ = std::clamp(stop_y / kGravity_m_s2, -most_rad, most_rad);
  lean_y_rad_ = std::clamp(-stop_z / kGravity_m_s2, -most_rad, most_rad);

  // how it will be in the middle of the pulses
  const double ahead = parameters_.offset_s + kFrame_s / 2;
  const Effect effect = effect_of(t, fans);
  Forces late = Forces::Zero();
  for (std::size_t i = 0; i < kValves; ++i) {
    if (health[i] == Health::good)
      late[static_cast<Eigen::Index>(i)] =
          t.force_N * remaining_s(fired_[i], parameters_.offset_s, t.lag_s);
  }
  const WrenchB pending = effect * late;
  const Vector3 inertia(body.inertia_x_kg_m2, body.inertia_y_kg_m2, body.inertia_z_kg_m2);
  const Vector3 rate = state_.rate_B_rad_s + Vector3(pending.tail<3>()).cwiseQuotient(inertia);
  const double error_y = attitude.tilt_y_rad + rate.y() * ahead - lean_y_rad_;
  const double error_z = attitude.tilt_z_rad + rate.z() * ahead - lean_z_rad_;
  const auto turn = [](double error, double w) {
    return -kWn_rad_s * kWn_rad_s * error - 2 * kZeta * kWn_rad_s * w;
  };
  const double still = std::clamp(rate.x(), -kRollStill_rad_s, kRollStill_rad_s);

  WrenchB rest;  // in the equilibrium
  rest << mass * kGravity_m_s2 / cosine, 0, 0, 0, 0;
  rest -= watch_.unexplained();
  WrenchB wanted = rest;
  wanted[kLiftRow] += mass * up_m_s2 / cosine;
  wanted[kSideRow] += mass * (stop_z + kGravity_m_s2 * attitude.tilt_y_rad);
  wanted[kRollRow] += -inertia.x() * kRoll_1_s * (rate.x() - still);
  wanted[kPitchRow] += inertia.y() * turn(error_y, rate.y());
  wanted[kYawRow] += inertia.z() * turn(error_z, rate.z());

  // the equilibrium
  AllocationProblem problem;
  problem.effect = effect;
  problem.weight = weights();
  problem.wanted = rest;
  const double most_fan_N = fan_thrust_N(fans.max_rpm, fans);
  for (Eigen::Index i = 0; i < kActuators; ++i) {
    const Health is = health[static_cast<std::size_t>(i)];
    const bool valve = i < static_cast<Eigen::Index>(kValves);
    const double full_N = valve ? (gas ? t.force_N : 0) : kFanShare * most_fan_N;
    problem.most[i] = is == Health::good || is == Health::open ? full_N : 0;
    problem.least[i] = is == Health::open ? full_N : 0;
    problem.preferred[i] = valve ? 0 : mass * kGravity_m_s2 / kFans;
    problem.cost[i] = valve ? kValveCost : kFanCostAtRest;
  }
  problem.preferred = allocate(problem).force_N;

  // this frame: a fan's thrust at its end is what is chosen, its mean is part of the old one
  const double old = math::exp(-kFrame_s / fans.lag_s);
  const double gone = fans.lag_s / kFrame_s * (1 - old);  // mean share of the old speed, unforced
  const double fresh_share = (1 - gone) / (1 - old);
  problem.wanted = wanted;
  for (std::size_t i = 0; i < kFans; ++i) {
    const auto at = static_cast<Eigen::Index>(kValves + i);
    const Health is = health[kValves + i];
    const double rpm = inputs.rpm[i];
    const double now_N = is == Health::weak ? 0 : fan_thrust_N(rpm, fans);
    const double least_N = is == Health::weak ? 0 : fan_thrust_N(old * rpm, fans);
    const double most_N = fan_thrust_N(old * rpm + (1 - old) * fans.max_rpm, fans);
    problem.wanted -= (1 - fresh_share) * now_N * effect.col(at);
    problem.effect.col(at) = fresh_share * effect.col(at);
    problem.least[at] = least_N;
    problem.most[at] = is == Health::good ? std::max(most_N, least_N) : least_N;
    problem.cost[at] = kFanCost;
  }
  Allocation allocation = allocate(problem);

  // pulses are possible ones; all others make up for the difference
  const double frame_N_s = t.force_N / kFrame_s;  // mean force of each second open
  const auto on_s = [&](Eigen::Index i) { return allocation.force_N[i] / frame_N_s; };
  for (Eigen::Index i = 0; i < static_cast<Eigen::Index>(kValves); ++i) {
    if (problem.least[i] >= problem.most[i]) continue;
    const double wants_s = on_s(i);
    if (wants_s < t.min_on_s) {
      problem.least[i] = problem.most[i] = wants_s < t.min_on_s / 2 ? 0 : frame_N_s * t.min_on_s;
    } else if (wants_s > t.max_on_s) {
      const bool whole = wants_s > (t.max_on_s + kFrame_s) / 2;
      problem.least[i] = problem.most[i] = frame_N_s * (whole ? kFrame_s : t.max_on_s);
    } else {
      problem.least[i] = frame_N_s * t.min_on_s;
      problem.most[i] = frame_N_s * t.max_on_s;
    }
  }
  allocation = allocate(problem);

  lift_before_N_ = lift_N_;
  lift_N_ = 0;
  for (std::size_t i = 0; i < kValves; ++i) {
    const auto at = static_cast<Eigen::Index>(i);
    if (i % 2 == 0) lift_N_ += allocation.force_N[at];
    if (health[i] == Health::good && gas)
      output.actuation.valve[i] = spaced(on_s(at), fired_[i], t.min_on_s);
  }
  PerFan goal{};
  for (std::size_t i = 0; i < kFans; ++i) {
    const double force_N = allocation.force_N[static_cast<Eigen::Index>(kValves + i)];
    if (health[kValves + i] == Health::good)
      goal[i] = std::min(std::sqrt(std::max(force_N, 0.0) / fans.thrust_N_per_rpm2), fans.max_rpm);
  }
  output.rpm_target = goal;
  output.actuation.fan_throttle = fan_speed_.ramp(goal, fans.max_rpm / kFrame_s, inputs.rpm);
  output.attitude_error_rad = Vector3(0, error_y, error_z);
  output.force_N = Vector3(wanted[kLiftRow], 0, wanted[kSideRow]);
  fan_goal_rpm_ = (goal[0] + goal[1] + goal[2] + goal[3]) / kFans;
}

}  // namespace lss::gnc::talaris
