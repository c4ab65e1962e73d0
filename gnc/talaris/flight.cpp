#include "gnc/talaris/flight.h"

#include <algorithm>
#include <cmath>

#include "gnc/math.h"

namespace lss::gnc::talaris {
namespace {

constexpr double kRangeLead_s = 0.5;  // time constant of the altimeter's own speed
constexpr double kMaxGap_s = 0.1;     // 20 packets: more is a gap
constexpr double kEscape_s = 10;      // after max_run_s; then by the fans alone, ever less lift
constexpr int kMostHolds = 2;
constexpr double kSettled_s = 0.4;

bool finite(const NavState& s) noexcept {
  return std::isfinite(s.position_N_m.sum() + s.velocity_N_m_s.sum() + s.rate_B_rad_s.sum() +
                       s.acceleration_N_m_s2.sum() + s.q_NB.coeffs().sum()) &&
         std::abs(s.q_NB.norm() - 1) < 1e-3 && s.position_N_m.cwiseAbs().maxCoeff() < 1e4 &&
         s.velocity_N_m_s.cwiseAbs().maxCoeff() < 1e3 &&
         s.rate_B_rad_s.cwiseAbs().maxCoeff() < 1e2 &&
         s.acceleration_N_m_s2.cwiseAbs().maxCoeff() < 1e4;
}

}  // namespace

Flight::Flight(const Parameters& parameters) noexcept
    : parameters_(parameters),
      gas_(parameters.gas),
      control_(parameters, parameters.gains[0]),
      fan_speed_(parameters.fans, parameters.gains[0]),
      fan_flight_(parameters, parameters.gains[0]),
      watch_(parameters) {}

bool Flight::active() const noexcept {
  return begun_ && phase_ != Phase::none && phase_ != Phase::ready && phase_ != Phase::landed;
}

bool Flight::select_gains(std::size_t set) noexcept {
  if (active() || set < 1 || set > parameters_.gain_sets) return false;
  set_ = set - 1;
  control_.set_gains(gain());
  fan_speed_.set_gains(gain());
  fan_flight_.set_gains(gain());
  return true;
}

bool Flight::configure(const Parameters& parameters) noexcept {
  if (active()) return false;
  parameters_ = parameters;
  drop_plan();
  return select_gains(gains());
}

PlanResult Flight::plan(const PlanRequest& request) noexcept {
  if (active()) {
    PlanResult refused;
    refused.guard = Guard::request;
    return refused;
  }
  const PlanResult result = make_plan(request, parameters_, gas_.left_s());
  if (result.feasible()) {
    plan_ = result.plan;
    begun_ = stopped_ = false;
    enter(Phase::ready);
  }
  return result;
}

void Flight::drop_plan() noexcept {
  if (!active()) enter(Phase::none);
}

bool Flight::execute() noexcept {
  if (phase_ != Phase::ready) return false;
  begun_ = settled_ = true;
  stopped_ = airborne_ = observed_ = impacted_ = start_known_ = false;
  reaction_ = Reaction::none;
  faults_ = 0;
  flown_s_ = fans_s_ = settle_s_ = silent_s_ = below_s_ = 0;
  lift_N_ = lift_before_N_ = bias_m_s2_ = expected_m_s2_ = fans_N_ = fan_trim_N_ = 0;
  fan_yield_N_ = fan_yield_step_N_ = 0;
  fan_y_Nm_ = fan_z_Nm_ = 0;
  low_frames_ = contact_frames_ = 0;
  range_height_m_ = kNaN;
  range_climb_m_s_ = 0;
  start_range_m_ = kNaN;
  touchdown_.reset();
  fan_probe_N_ = weak_s_ = more_m_s2_ = impact_m_s_ = 0;
  wind_m_s2_.setZero();
  lean_y_rad_ = lean_z_rad_ = 0;
  judgement_ = now_judged_ = {};
  traverse_s_ = plan_.traverse_s;
  brake_s_ = plan_.keep_s;
  extra_s_ = 0;
  holds_ = 0;
  waits_ = false;
  waited_s_ = 0;
  shortfall_ = Shortfall::none;
  off_m_ = off_sigma_m_ = 0;
  for (Speeds* each : {&before_, &before_impact_, &before_contact_}) *each = {};
  moved_frames_ = 0;
  speed_noted_ = false;
  touchdown_m_s_ = touchdown_side_m_s_ = 0;
  control_.begin();
  fan_flight_.begin();
  fan_speed_.reset();
  watch_.begin();
  fired_ = fired_before_ = {};
  known_before_ = false;
  enter(Phase::spin_up);
  phase_s_ = -kFrame_s;  // step() counts the frame before its phase
  return true;
}

void Flight::land() noexcept {
  if (!active()) return;
  if (reaction_ < Reaction::land) respond(Reaction::land);
}

void Flight::all_stop() noexcept {
  stopped_ = begun_;
  airborne_ = false;
  if (begun_) reaction_ = Reaction::all_stop;
  fan_speed_.reset();
  enter(Phase::none);
}

void Flight::count_gas(const std::array<double, kValves>& open_s) noexcept { gas_.count(open_s); }

void Flight::enter(Phase phase) noexcept {
  phase_ = phase;
  phase_s_ = 0;
  const bool down = phase == Phase::parachute || phase == Phase::descend;
  if (down && by_fans()) below_s_ = -ground_due_s();
}

FlightOutput Flight::step(const FlightInputs& measured) noexcept {
  FlightInputs inputs = measured;
  // A speed that no fan reaches, whose square may be infinite, is none.
  for (double& rpm : inputs.rpm) {
    if (!(std::abs(rpm) <= 2 * parameters_.fans.max_rpm)) rpm = kNaN;
  }
  FlightOutput out;
  gas_.pressure(inputs.tank_kPa);
  if (active()) {
    phase_s_ += kFrame_s;
    take_state(inputs);
    inputs_unheard_ = inputs.unheard;
    if (phase_ == Phase::spin_up && silent_s_ <= 0) {
      // Light on its legs it slides and turns on a slope: the target stays where it was planned.
      if (!start_known_) {
        start_m_ = leg_m_ = state_.position_N_m;
        start_roll_rad_ = roll_rad_ = attitude_of(state_.q_NB).roll_rad;
        start_known_ = true;
      }
      start_m_.x() = leg_m_.x() = state_.position_N_m.x();
    }
    const FaultSet lasting = faults_ & ~static_cast<FaultSet>(kImuGap | kOffTrack);
    watch_actuators(inputs);
    faults_ = lasting | find_faults(inputs);
    observe(inputs.rpm);
    touchdown_.step(state_, heard_, expected_m_s2_);
    watch_corridor();
    respond(react(faults_, airborne_, plan_.uses_fans, plan_.uses_gas));
    if (active()) advance(inputs);
    if (active()) act(inputs, out);
    flown_s_ += airborne_ ? kFrame_s : 0;
  }
  gas_.count(out.actuation.valve);
  fired_before_ = fired_;
  fired_ = out.actuation.valve;

  const bool gap = active() && (faults_ & kImuGap) != 0 && reaction_ == Reaction::hold;
  out.phase = gap ? Phase::hold : phase_;
  out.reaction = reaction_;
  out.faults = faults_;
  out.airborne = airborne_;
  out.all_stop = stopped_;
  out.finished = begun_ && !active();
  if (out.finished) {
    if (phase_ != Phase::landed || reaction_ > Reaction::hold) fall_short(Shortfall::cut_short);
    if (!settled_) fall_short(Shortfall::unsettled);
  }
  out.succeeded = out.finished && shortfall_ == Shortfall::none;
  out.still = active() && touchdown_.still_s() >= kSettled_s;
  out.stands = phase_ == Phase::touchdown && speed_noted_;
  out.shortfall = shortfall_;
  out.judgement = judgement_;
  out.off_target_m = off_m_;
  out.off_target_sigma_m = off_sigma_m_;
  out.touchdown_m_s = touchdown_m_s_;
  out.touchdown_side_m_s = touchdown_side_m_s_;
  out.phase_s = std::max(phase_s_, 0.0);
  out.height_m = std::isfinite(height_m_) ? height_m_ : 0;
  out.lift_m_s2 = expected_m_s2_ + bias_m_s2_ + kGravity_m_s2;
  if (begun_) {
    out.target_N_m = guidance_.target().position_m;
    out.target_N_m_s = guidance_.target().velocity_m_s;
  }
  out.target_roll_rad = roll_rad_;
  out.health = watch_.health();
  out.verdict = watch_.verdict();
  out.suspicion = watch_.score() / ActuatorWatch::limit();
  out.gas_used_s = gas_.used_s();
  out.gas_left_s = gas_.left_s();
  out.gas_needed_s = active() ? needed_gas_s() : 0;
  return out;
}

// Navigation's state when valid; else its last one, extrapolated by rates and speeds.
void Flight::take_state(const FlightInputs& inputs) noexcept {
  const bool heard = inputs.nav.valid && finite(inputs.nav);
  if (heard) {
    state_ = inputs.nav;
  } else {
    state_.position_N_m += state_.velocity_N_m_s * kFrame_s;
    const Vector3 turn = state_.rate_B_rad_s * kFrame_s;
    if (const double angle = turn.norm(); angle > 0) {
      const Vector3 axis = math::sin(angle / 2) / angle * turn;
      const Quaternion turned(math::cos(angle / 2), axis.x(), axis.y(), axis.z());
      state_.q_NB = (state_.q_NB * turned).normalized();
    }
    state_.acceleration_N_m_s2.setZero();
  }
  heard_ = heard;
  const bool silent = !heard || !(inputs.imu_age_s <= kMaxGap_s);
  silent_s_ = silent ? silent_s_ + kFrame_s : 0;

  // the altimeter alone, when the IMU is lost
  if (inputs.range_age_s < kFrame_s && std::isfinite(inputs.range_m)) {
    if (!std::isfinite(start_range_m_)) start_range_m_ = inputs.range_m;
    const double height = inputs.range_m - start_range_m_;
    if (std::isfinite(range_height_m_)) {
      const double rate = (height - range_height_m_) / (kFrame_s + range_ahead_s_);
      const double share = std::min((kFrame_s + range_ahead_s_) / kRangeLead_s, 1.0);
      range_climb_m_s_ += share * (std::clamp(rate, -10.0, 10.0) - range_climb_m_s_);
    }
    range_height_m_ = height;
    range_ahead_s_ = 0;
  } else {
    range_ahead_s_ += kFrame_s;
  }

  if (imu_usable()) {
    height_m_ = state_.position_N_m.x() - start_m_.x();
    climb_m_s_ = state_.velocity_N_m_s.x();
  } else {
    const bool known = inputs.range_age_s <= parameters_.limits.range_age_s;
    height_m_ = known ? range_height_m_ + range_climb_m_s_ * range_ahead_s_ : kNaN;
    climb_m_s_ = known ? range_climb_m_s_ : kNaN;
  }
}

FaultSet Flight::find_faults(const FlightInputs& in) const noexcept {
  const Limits& limits = parameters_.limits;
  FaultSet found = in.faults;
  if (silent_s_ > limits.imu_hold_s) {
    found |= kImuLost;
  } else if (silent_s_ > 0) {
    found |= kImuGap;
  }
  if (!(in.range_age_s <= limits.range_age_s)) found |= kAltimeterLost;
  if (!(in.valve_age_s <= limits.valve_age_s)) found |= kValvesLost;
  if (!(in.fan_age_s <= limits.fan_age_s)) found |= kFansLost;
  // without a sensor the count of the pulses is used
  if (std::isfinite(in.regulated_kPa) ? in.regulated_kPa < parameters_.gas.min_regulated_kPa
                                      : gas_.left_s() <= 0) {
    found |= kPressureLost;
  }
  // not while it descends already: it would land no sooner
  const bool coming_down =
      phase_ == Phase::descend || phase_ == Phase::escape || phase_ == Phase::parachute;
  if (airborne_ && !coming_down &&
      gas_.left_s() < landing_gas_s() + parameters_.gas.reserve_s / 2) {
    found |= kGasLow;
  }
  const Attitude attitude = attitude_of(state_.q_NB);
  if (silent_s_ <= 0 && (attitude.cosine < math::cos(limits.tilt_rad) ||
                         state_.rate_B_rad_s.norm() > limits.rate_rad_s)) {
    found |= kUpset;
  }
  if (phase_ == Phase::spin_up && phase_s_ > parameters_.fans.spin_up_timeout_s) {
    found |= kSpinUpFailed;
  }
  if (airborne_ && fans_s_ > parameters_.fans.max_run_s) found |= kRunTime;
  if (airborne_ && fans_s_ > parameters_.fans.max_run_s + kEscape_s) found |= kOverTime;
  if (!watch_.good()) found |= kActuatorFailed;
  if (judgement_.off != Off::none) found |= kOffCourse;
  // without the gas for the rest of the way after it a hold would be the end
  const bool covered =
      phase_ == Phase::hold || hold_gas_s() <= gas_.left_s() - parameters_.gas.reserve_s / 2;
  if (now_judged_.wavers && holds_ < kMostHolds && covered) found |= kOffTrack;
  const bool goes_on = phase_ == Phase::ascend || phase_ == Phase::hover || phase_ == Phase::turn ||
                       phase_ == Phase::traverse || phase_ == Phase::hold;
  if (airborne_ && goes_on && needed_gas_s() > gas_.left_s() - parameters_.gas.reserve_s / 2)
    found |= kGasShort;

  // faults of parts that the program does not use are ignored
  if (!plan_.uses_gas)
    found &= ~static_cast<FaultSet>(kValvesLost | kPressureLost | kGasLow | kGasShort);
  if (!plan_.uses_fans)
    found &= ~static_cast<FaultSet>(kFansLost | kRunTime | kOverTime | kSpinUpFailed);
  if (!plan_.needs_altimeter) found &= ~static_cast<FaultSet>(kAltimeterLost);
  return found;
}

// Reactions only become worse, except hold.
void Flight::respond(Reaction reaction) noexcept {
  if (reaction_ == Reaction::hold && reaction == Reaction::none) reaction_ = Reaction::none;
  // touchdown shuts everything off anyway
  if (phase_ == Phase::touchdown || reaction <= reaction_) return;
  reaction_ = reaction;
  switch (reaction) {
    case Reaction::none: return;
    case Reaction::hold:
      if (phase_ != Phase::traverse || !airborne_ || (faults_ & kOffTrack) == 0) return;
      ++holds_;
      stop_here();
      corridor_.stop(state_.position_N_m,
                     Vector3(0, state_.velocity_N_m_s.y(), state_.velocity_N_m_s.z()),
                     guidance_.time_to_go_s());
      enter(Phase::hold);
      return;
    case Reaction::shorten:
      stop_here();
      brake_s_ = std::max(plan_.keep_s, guidance_.time_to_go_s() + kSettled_s);
      enter(Phase::brake);
      return;
    case Reaction::land:
      if (!airborne_) {
        if (phase_ == Phase::spin_up || plan_.flies || plan_.request.program == Program::attitude) {
          enter(Phase::touchdown);
        } else {
          stop_here();
          enter(Phase::brake);
        }
      } else if (!plan_.uses_gas) {
        enter(Phase::parachute);
      } else if (phase_ != Phase::descend) {
        come_down(parameters_.profile.descend_m_s2, parameters_.profile.touchdown_speed_m_s,
                  parameters_.profile.touchdown_height_m);
        enter(Phase::descend);
      }
      return;
    case Reaction::escape: {
      const bool blind = (faults_ & kAltimeterLost) != 0;
      // without altimeter the height may be wrong: brake earlier, and slowly into the ground
      come_down(parameters_.limits.escape_m_s2,
                blind ? parameters_.limits.blind_m_s : parameters_.profile.touchdown_speed_m_s,
                (blind ? 2 : 1) * parameters_.profile.touchdown_height_m);
      enter(Phase::escape);
      return;
    }
    case Reaction::parachute:
      fan_flight_.begin();
      enter(Phase::parachute);
      return;
    case Reaction::all_stop: all_stop(); return;
  }
}

}  // namespace lss::gnc::talaris
