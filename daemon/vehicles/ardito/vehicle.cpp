#include "daemon/vehicles/ardito/vehicle.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "daemon/kit/gate.h"
#include "daemon/vehicles/ardito/tunables.h"
#include "gnc/ardito/slip.h"
#include "gnc/math.h"
#include "idl/angles.h"

namespace lss::ardito {
namespace {

using gnc::ardito::contains;
using gnc::ardito::kRadPerSecondPerRpm;

constexpr TimeNs kFlash = 500 * kMillisecond;        // of the lamp: on, off
constexpr double kGateMargin = 1.2;                  // above the limits of the mobility controller
constexpr double kSteeringLimit_rad = 65 * kDegree;  // Ardito thesis 11.2

double seconds(TimeNs time) noexcept { return static_cast<double>(time) * 1e-9; }

// For people: NaN before it was measured.
double shown(const Known& known, double scale = 1) noexcept {
  return known.time_ns == 0 ? std::numeric_limits<double>::quiet_NaN() : known.value * scale;
}

std::size_t system_of(std::uint8_t wheel) noexcept {
  return gnc::ardito::kSteeredOfWheel[wheel % kWheels];
}

}  // namespace

Vehicle::Vehicle(const Parameters& parameters) noexcept
    : parameters_(parameters),
      tunables_(values_of(tuning().tunables, parameters)),
      mobility_(parameters.mobility),
      radius_m_(parameters.mobility.geometry.wheel_radius_m),
      gear_(parameters.mobility.geometry.gear_ratio),
      solver_(parameters.solver) {
  orders_.serial = 1;
  orders_.clutches = gnc::ardito::kAllWheels;
}

// ---- adjust: a parameter

Adjusted Vehicle::adjust(std::size_t index, double value, bool really) noexcept {
  return lss::adjust(tuning(), parameters_, tunables_, index, value, really, [&] {
    solver_.configure(parameters_.solver);
    mobility_.configure(parameters_.mobility);
  });
}

// ---- read

void Vehicle::read(const lss::Inputs<Vehicle>& in) noexcept {
  now_ns_ = in.time_ns;
  data_requested_ = false;
  bus_ = in.bus;
  bool pressed = false;  // also when it was released before the frame
  for (std::uint32_t i = 0; i < in.sample_count; ++i) {
    const RoverSample& sample = in.samples[i];
    std::visit([&](const auto& heard) { take(heard, sample.time_ns); }, sample.reading);
    const bool of_io = std::holds_alternative<ardito::Inputs>(sample.reading);
    pressed = pressed || (of_io && inputs_.emergency_button);
  }
  inputs_.emergency_button = inputs_.emergency_button || pressed;
}

void Vehicle::take(const WheelMotion& m, TimeNs time) noexcept {
  Wheel& wheel = wheel_[m.wheel % kWheels];
  wheel.motor_rpm = {m.motor_rpm, time};
  wheel.current_permille = {m.current_permille, time};
}
void Vehicle::take(const WheelSpeeds& m, TimeNs time) noexcept {
  Wheel& wheel = wheel_[m.wheel % kWheels];
  wheel.hall_rpm = {m.hall_rpm, time};
  wheel.reduction_rpm = {m.reduction_rpm, time};
}
void Vehicle::take(const WheelHealth& m, TimeNs time) noexcept {
  Wheel& wheel = wheel_[m.wheel % kWheels];
  wheel.temperature_degC = {m.temperature_degC, time};
  wheel.link_V = {m.link_V, time};
}
void Vehicle::take(const SteeringMotion& m, TimeNs time) noexcept {
  if (system_of(m.wheel) >= kSteered) return;
  Steering& steering = steering_[system_of(m.wheel)];
  steering.motor_rad = {m.motor_rad, time};
  steering.current_permille = {m.current_permille, time};
}
void Vehicle::take(const SteeringAngle& m, TimeNs time) noexcept {
  if (system_of(m.wheel) >= kSteered) return;
  steering_[system_of(m.wheel)].reduction_rad = {m.reduction_rad, time};
}
void Vehicle::take(const ardito::Inputs& m, TimeNs time) noexcept {
  inputs_ = m;
  inputs_ns_ = time;
}
void Vehicle::take(const Rocker& m, TimeNs time) noexcept {
  beta_rad_ = {m.beta_rad, time};
  rho1_rad_ = {m.rho1_rad, time};
  rho2_rad_ = {m.rho2_rad, time};
}
void Vehicle::take(const Imu& m, TimeNs time) noexcept {
  imu_speed_m_s_ = {m.Vtan_mm_s * 1e-3, time};
  imu_sigma_rad_ = {m.sigma_rad, time};
  imu_yaw_rate_rad_s_ = {m.yaw_rate_rad_s, time};
  imu_counter_ = m.counter;
}

// ---- state

bool Vehicle::answers(std::size_t node) const noexcept {
  return bus_.open && link(node).node.state == canopen::NodeState::operational;
}

bool Vehicle::faulty(std::size_t node) const noexcept {
  const canopen::DriveState state = link(node).drive;
  return state == canopen::DriveState::fault || state == canopen::DriveState::fault_reaction;
}

bool Vehicle::contact() const noexcept {
  for (std::size_t i = 0; i < kImu; ++i) {
    if (in_service(i) && !answers(i)) return false;
  }
  return true;
}

// Without power the mobility controller waits in `begin`, and orders nothing.
bool Vehicle::standing() const noexcept {
  using gnc::ardito::StopPhase;
  return command_.mode == gnc::ardito::Mode::stop &&
         (command_.phase == StopPhase::rover_stop || command_.phase == StopPhase::begin);
}

bool Vehicle::wheels_rest() const noexcept {
  return stepped_ && std::ranges::all_of(command_.estimate.wheel_rad_s, [this](double rad_s) {
           return std::abs(rad_s) <= parameters_.mobility.still_rad_s;
         });
}

// The conditions for enabled drives. A steering drive of unknown angle must not get a target.
bool Vehicle::drives_enabled() const noexcept {
  for (std::size_t i = 0; i < kWheels + kSteered; ++i) {
    const bool wanted = i < kWheels ? sent_.wheel[i].enabled : sent_.steering[i - kWheels].enabled;
    if (wanted && link(i).drive != canopen::DriveState::operation_enabled) return false;
  }
  return command_.steering_known != 0;
}

// ---- act: actions of the locomotion controller, at once

void Vehicle::act(lc::ActionSet actions, const Request* request) noexcept {
  if (actions & (lc::kEmergencyStop | lc::kMotorsOff)) {
    drives_on_ = false;
    wanted_m_s_ = ramped_m_s_ = 0;
    // Only error solving ends it before the rover rests (control()).
    const bool solves = (actions & (lc::kNextStrategy | lc::kEndSolve | lc::kIsolate)) != 0;
    orders_.quick_stop = (actions & lc::kEmergencyStop) != 0 || (orders_.quick_stop && !solves);
    beacon_ = by_itself_ = orders_.beacon = false;
    if (actions & lc::kEmergencyStop) {
      make_safe(orders_, now_ns_);
    } else {
      ++orders_.serial;  // ends a stop that the bus keeps
    }
  }
  if (actions & lc::kEndSolve) solver_.end();
  if (actions & lc::kRestore) {
    forget(isolated_);
    unproven_ &= ~unsigned{isolated_};
    if (isolated_ != 0) {
      reset_faults();  // of drives that are repaired
      restored_ = isolated_;
      restored_ns_ = now_ns_;
    }
    isolated_ = 0;
  }
  if (actions & lc::kResetModule) {
    const int number = arguments<Reset>(*request).module;
    const unsigned all = (1u << kNodes) - 1;
    const unsigned nodes = number == 0 ? all : 1u << (number - 1);
    reset_nodes(static_cast<std::uint16_t>(nodes));
    unproven_ &= ~nodes;  // it was checked
    for (std::size_t i = 0; i < kNodes; ++i) {
      if (nodes >> i & 1u) watched_.begin_reset(i, now_ns_, link(i).node);
    }
  }
  if (actions & lc::kPublishData) data_requested_ = true;
  if (actions & kBeacon) {
    beacon_ = true;
    reset_faults();  // of power that was missing while standing; other faults prevent the start
    started_ns_ = now_ns_;
    const SpeedLimit limit = arguments<Start>(*request).limit;
    limit_m_s_ = std::min(kSpeedLimits_m_s[static_cast<std::size_t>(limit)],
                          parameters_.mobility.top_speed_m_s);
    distance_m_ = yaw_rad_ = x_m_ = y_m_ = 0;
  }
  if (actions & kMotorsOn) {
    drives_on_ = true;
    orders_.quick_stop = false;
    ++orders_.serial;
  }
  if (actions & kHalt) wanted_m_s_ = 0;
  if (actions & kByHand) by_itself_ = false;
  if ((actions & kByItself) && !by_itself_) {
    by_itself_ = true;
    activated_ns_ = now_ns_;
  }
  if (actions & (kDrive | kPark)) stuck_told_ = embedded_told_ = false;
  if (actions & kDrive) {
    const auto drive = arguments<Drive>(*request);
    wanted_m_s_ = drive.speed_m_s;
    wanted_rad_ = drive.heading_rad;
    correction_ = drive.correction;
  }
  if (actions & kPark) {
    wanted_m_s_ = arguments<Park>(*request).speed_m_s;
    wanted_rad_ = 0;
  }
}

// ---- navigate, guide, control

gnc::ardito::Reading Vehicle::reading(const Known& known, double scale) const noexcept {
  if (known.time_ns == 0) return {};
  return {.value = known.value * scale, .age_s = seconds(now_ns_ - known.time_ns)};
}

void Vehicle::measure() noexcept {
  const double motor = kRadPerSecondPerRpm / gear_;
  for (std::size_t i = 0; i < kWheels; ++i) {
    const Wheel& wheel = wheel_[i];
    measured_.wheels[i] = {.motor_rad_s = reading(wheel.motor_rpm, motor),
                           .hall_rad_s = reading(wheel.hall_rpm, motor),
                           .reduction_rad_s = reading(wheel.reduction_rpm, kRadPerSecondPerRpm),
                           .current = reading(wheel.current_permille, 1e-3),
                           .temperature_C = reading(wheel.temperature_degC),
                           .drive_fault = !answers(i) || faulty(i)};
  }
  for (std::size_t i = 0; i < kSteered; ++i) {
    const Steering& steering = steering_[i];
    const std::size_t node = kFirstSteering + i;
    measured_.steering[i] = {.motor_rad = reading(steering.motor_rad, 1 / gear_),
                             .reduction_rad = reading(steering.reduction_rad),
                             .current = reading(steering.current_permille, 1e-3),
                             .drive_fault = !answers(node) || faulty(node)};
  }
  measured_.beta_rad = reading(beta_rad_);
  measured_.rho1_rad = reading(rho1_rad_);
  measured_.rho2_rad = reading(rho2_rad_);
  measured_.imu = {.speed_m_s = reading(imu_speed_m_s_),
                   .sigma_rad = reading(imu_sigma_rad_),
                   .yaw_rate_rad_s = reading(imu_yaw_rate_rad_s_),
                   .counter = imu_counter_};
}

bool Vehicle::has_fault(gnc::ardito::Fault fault) const noexcept {
  return stepped_ && (command_.faults & fault) != 0;
}

// The rover flashes and waits at the activation of autonomous driving (Ardito thesis part III).
double Vehicle::autonomy_wait_s() const noexcept {
  const TimeNs left = activated_ns_ + parameters_.autonomy_ns - now_ns_;
  return by_itself_ && left > 0 ? seconds(left) : 0;
}

// Dead reckoning over the last frame: speed from wheels and steering, of slipping wheels from the
// IMU; turning from the IMU.
void Vehicle::reckon() noexcept {
  if (!stepped_ || !drives_on_) return;
  const gnc::ardito::Estimate& e = command_.estimate;
  const double dt_s = seconds(parameters_.bus.period_ns);
  const double yaw_rate_rad_s = imu_lost_ ? e.yaw_rate_rad_s : imu_yaw_rate_rad_s_.value;
  const double way_m = e.ground_m_s * dt_s;
  const double course_rad = yaw_rad_ + yaw_rate_rad_s * dt_s / 2 + e.sigma_rad;
  x_m_ += way_m * gnc::math::cos(course_rad);
  y_m_ -= way_m * gnc::math::sin(course_rad);
  yaw_rad_ += yaw_rate_rad_s * dt_s;
  if (command_.mode != gnc::ardito::Mode::parking) distance_m_ += way_m;
}

void Vehicle::navigate(TimeNs) noexcept {
  measure();
  reckon();
}

void Vehicle::guide(TimeNs) noexcept {
  const lc::ControllerState& c = supervisor_->controller();
  const auto goal = static_cast<Goal>(c.goal);
  const bool run =
      drives_on_ && (goal == Goal::drive || goal == Goal::park) && autonomy_wait_s() == 0;
  const double step_m_s = kAcceleration_m_s2 * seconds(parameters_.bus.period_ns);
  if (!run || ramped_m_s_ * wanted_m_s_ < 0) {
    ramped_m_s_ = 0;  // the mobility controller ramps down
  } else {
    ramped_m_s_ = std::copysign(std::min(std::abs(wanted_m_s_), std::abs(ramped_m_s_) + step_m_s),
                                wanted_m_s_);
  }
  request_ = {.sigma_rad = wanted_rad_,
              .speed = ramped_m_s_ / limit_m_s_,
              .speed_limit_m_s = limit_m_s_,
              .parking = goal == Goal::park,
              .run = run,
              .enable_correction = correction_,
              .error = c.state != State::operational,
              .powered = drives_on_ && drives_enabled(),
              .retry_wheels = retry_wheels_,
              .retry_steering = retry_steering_,
              .accept_lost_wheels = isolated_ & gnc::ardito::kAllWheels};
}

Vehicle::Command Vehicle::control(TimeNs now) noexcept {
  // Without contact there is nothing to diagnose: silence is no failure of a sensor.
  stepped_ = contact();
  if (stepped_) {
    command_ = mobility_.step(request_, measured_);
    retry_wheels_ = retry_steering_ = 0;
  }
  for (std::size_t i = 0; i < kWheels; ++i) {
    const bool enabled = drives_on_ && in_service(i) && !contains(command_.motors_stopped, i);
    const double rpm = command_.wheel_rad_s[i] / kRadPerSecondPerRpm * gear_;
    orders_.wheel[i] = {.enabled = enabled, .motor_rpm = enabled ? rpm : 0};
  }
  for (std::size_t i = 0; i < kSteered; ++i)
    orders_.steering[i] = {.enabled = drives_on_ && command_.steering_known != 0,
                           .position_rad = command_.steering_rad[i]};
  if (stepped_)
    orders_.clutches =
        static_cast<std::uint8_t>(command_.clutches_engaged & ~static_cast<unsigned>(isolated_));
  const bool dark = autonomy_wait_s() > 0 && (now - activated_ns_) / kFlash % 2 == 1;
  orders_.beacon = beacon_ && !dark;
  const lc::ControllerState& c = supervisor_->controller();
  // In Idle motors are off, also after an emergency stop, when the wheels have rested for a second.
  if (!orders_.quick_stop || c.state != State::idle || !wheels_rest()) rests_ns_ = now;
  if (now - rests_ns_ >= kSecond) {
    orders_.quick_stop = false;
    ++orders_.serial;
  }
  orders_.standing = c.state != State::operational || standing();
  orders_.next_frame_ns = now + parameters_.bus.period_ns;
  orders_.issued_ns = now;
  return orders_;
}

// ---- gate

Vehicle::Command Vehicle::gate(const Command& wanted, Supervisor& supervisor, TimeNs now) noexcept {
  const auto motor_rpm = [&](double m_s) { return m_s / radius_m_ / kRadPerSecondPerRpm * gear_; };
  const double saturation_rpm =
      2 * parameters_.mobility.wheel_saturation_rad_s / kRadPerSecondPerRpm * gear_;
  // A wheel outside of a curve is faster than the middle of the rover.
  const double curve = 1.5 * kGateMargin;
  const GateLimits limits{
      .motor_rpm = motor_rpm(limit_m_s_) * kGateMargin + saturation_rpm,
      .motor_rpm_step = motor_rpm(kAcceleration_m_s2 * seconds(parameters_.bus.period_ns)) * curve +
                        saturation_rpm,
      .steering_rad = kSteeringLimit_rad};
  const GateCheck failed = check(wanted, sent_, supervisor.controller(), limits, now);
  return kit::pass_gate(failed, wanted, orders_, sent_, supervisor,
                        [&] { make_safe(orders_, now); });
}

// ---- telemetry

bool Vehicle::describe(const lss::Inputs<Vehicle>& in, const SupervisorState& state,
                       Telemetry& out) noexcept {
  const gnc::ardito::Estimate& e = command_.estimate;
  out.time_ns = in.time_ns;
  out.frame = in.frame;
  out.state = static_cast<std::uint8_t>(state.controller.state);
  out.mode = state.controller.mode;
  out.autonomous = (state.controller.flags & kAutonomous) != 0;
  out.correction = correction_ && parameters_.mobility.correction_sign != 0;
  out.limit_m_s = limit_m_s_;
  out.cap_m_s = parameters_.mobility.top_speed_m_s;
  out.autonomy_wait_s = autonomy_wait_s();
  out.speed_m_s = request_.run ? wanted_m_s_ : 0;
  out.heading_rad = request_.run ? wanted_rad_ : 0;
  out.measured_m_s = stepped_ ? e.speed_m_s : 0;
  out.measured_rad = stepped_ ? e.sigma_rad : 0;
  out.ground_m_s = stepped_ ? e.ground_m_s : 0;
  out.slip_m_s = stepped_ ? e.slip_m_s : 0;
  out.slip_share = stepped_ ? e.slip_share : 0;
  out.speed_share = stepped_ ? e.speed_share : 1;
  out.load = stepped_ ? e.load : 0;
  out.slipping = slipping_;
  out.stuck = has_fault(gnc::ardito::kStuck);
  out.incoherent_speed = has_fault(gnc::ardito::kIncoherentSpeed);
  out.incoherent_heading = has_fault(gnc::ardito::kIncoherentSigma);
  out.distance_m = distance_m_;
  out.yaw_rad = yaw_rad_;
  out.x_m = x_m_;
  out.y_m = y_m_;
  static_assert(std::extent_v<decltype(out.wheels)> == kWheels &&
                std::extent_v<decltype(out.steering)> == kSteered &&
                std::extent_v<decltype(out.nodes)> == kNodes);
  const double motor = kRadPerSecondPerRpm / gear_;
  for (std::size_t i = 0; i < kWheels; ++i) {
    const Wheel& wheel = wheel_[i];
    out.wheels[i] = {.id = static_cast<std::uint8_t>(i + 1),
                     .state = static_cast<std::uint8_t>(command_.wheel_failure[i]),
                     .suspect = static_cast<std::uint8_t>(command_.wheel_suspect[i]),
                     .inconclusive = contains(command_.inconclusive_wheels, i),
                     .hot = contains(hot_, i),
                     .probing = contains(command_.probing, i),
                     .unproven = contains(unproven_, i),
                     .clutch = contains(sent_.clutches, i),
                     .stopped = contains(command_.motors_stopped, i),
                     .target_rad_s = sent_.wheel[i].motor_rpm * motor,
                     .motor_rad_s = shown(wheel.motor_rpm, motor),
                     .hall_rad_s = shown(wheel.hall_rpm, motor),
                     .reduction_rad_s = shown(wheel.reduction_rpm, kRadPerSecondPerRpm),
                     .current_A = shown(wheel.current_permille, 1e-3 * parameters_.wheel_current_A),
                     .temperature_degC = shown(wheel.temperature_degC),
                     .voltage_V = shown(wheel.link_V)};
  }
  for (std::size_t i = 0; i < kSteered; ++i) {
    const Steering& s = steering_[i];
    const auto failure = command_.steering_failure[i];
    out.steering[i] = {
        .id = static_cast<std::uint8_t>(i + 1),
        .state = static_cast<std::uint8_t>(failure),
        .suspect = static_cast<std::uint8_t>(command_.steering_suspect[i]),
        .stopped = !sent_.steering[i].enabled,
        .target_rad = sent_.steering[i].position_rad,
        .motor_rad = shown(s.motor_rad, 1 / gear_),
        .reduction_rad = shown(s.reduction_rad),
        .current_A = shown(s.current_permille, 1e-3 * parameters_.steering_current_A)};
  }
  for (std::size_t i = 0; i < kNodes; ++i) describe_node(i, out.nodes[i]);
  out.beta_rad = shown(beta_rad_);
  out.rho_rad[0] = shown(rho1_rad_);
  out.rho_rad[1] = shown(rho2_rad_);
  describe_sunk(out);
  out.imu_valid = !imu_lost_;
  out.imu_speed_m_s = shown(imu_speed_m_s_);
  out.imu_heading_rad = shown(imu_sigma_rad_);
  out.imu_yaw_rate_rad_s = shown(imu_yaw_rate_rad_s_);
  out.emergency_button = inputs_.emergency_button;
  out.power_good = inputs_.power_good;
  out.beacon = sent_.beacon;
  out.disagreeing = disagreeing_;
  out.disagreements = mobility_.report().upsets;
  out.port_open = bus_.open;
  const RoverCounters& rover = bus_.status.counters;
  out.bus_frames_sent = bus_.port.sent;
  out.bus_frames_received = bus_.port.received;
  out.bus_frames_dropped = bus_.port.foreign + bus_.port.cannelloni.broken() +
                           rover.master.unknown_nodes + rover.master.unknown_frames +
                           rover.master.other_masters;
  out.bus_overflows = bus_.port.overflows + bus_.port.dropped_full + rover.overflows;
  out.bus_offs = bus_.port.bus_offs;
  return data_requested_;
}

// As it stands: sinking wheels are judged by it, filtered, while the rover drives.
void Vehicle::describe_sunk(Telemetry& out) const noexcept {
  using namespace gnc::ardito;
  static_assert(std::extent_v<decltype(out.sunk_m)> == kWheels);
  const RockerAngles angles{out.beta_rad, out.rho_rad[0], out.rho_rad[1]};
  if (rocker_lost_ || !std::isfinite(angles.beta_rad + angles.rho1_rad + angles.rho2_rad)) {
    std::ranges::fill(out.sunk_m, std::numeric_limits<double>::quiet_NaN());
    return;
  }
  const WheelPoses poses = wheel_poses(angles, parameters_.mobility.geometry);
  std::ranges::copy(lower_than_others_m(poses.z_m), out.sunk_m);
}

void Vehicle::describe_node(std::size_t i, lss_ArditoNode& out) const noexcept {
  const RoverBusParameters& p = parameters_.bus;
  const RoverLink& l = link(i);
  out.id = static_cast<std::uint8_t>(i + 1);
  out.address = i < kFirstSteering ? p.wheel_node[i]
                : i < kIo          ? p.steering_node[i - kFirstSteering]
                : i == kIo         ? p.io_node
                                   : p.imu_node;
  out.online = answers(i);
  out.isolated = !in_service(i);
  out.link = static_cast<std::uint8_t>(l.node.state);
  out.drive = static_cast<std::uint8_t>(l.drive);
  out.emergency = l.node.emcy_code;
  out.emergencies = static_cast<std::uint32_t>(l.node.emcys);
  out.age_ms = l.node.heartbeat_ns == 0
                   ? kNeverHeard_ms
                   : static_cast<std::uint64_t>(std::max<TimeNs>(now_ns_ - l.node.heartbeat_ns, 0) /
                                                kMillisecond);
}

}  // namespace lss::ardito
