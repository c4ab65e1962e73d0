// Supervision of D.I.A.N.A. Ardito: turns reports of nodes, bus, inputs and the failure detection
// into events and faults of the locomotion controller.

#include <algorithm>
#include <bit>
#include <cmath>

#include "daemon/cycle/solving.h"
#include "daemon/vehicles/ardito/vehicle.h"
#include "idl/ardito/codes.h"

namespace lss::ardito {
namespace {

using gnc::ardito::SteeringFailure;
using gnc::ardito::WheelFailure;

constexpr TimeNs kBoot = 5 * kSecond;  // a node that is silent until then is missing
constexpr TimeNs kSlowestValue = 3 * kSecond;

bool severe(FaultId id) noexcept {
  return info(id)->severity == static_cast<std::uint8_t>(Severity::fatal);
}

FaultId fault_of(WheelFailure failure) noexcept {
  switch (failure) {
    case WheelFailure::none: return FaultId::none;
    case WheelFailure::motor_sensor:
    case WheelFailure::reduction_encoder:
    case WheelFailure::two_sensors: return faults::wheel_sensor;
    case WheelFailure::motor: return faults::wheel_motor;
    case WheelFailure::reduction: return faults::wheel_gear;
    case WheelFailure::clutch:
    case WheelFailure::clutch_and_sensor: return faults::wheel_clutch;
    case WheelFailure::all_sensors: return faults::wheel_critical;
  }
  return FaultId::none;
}

FaultId fault_of(SteeringFailure failure) noexcept {
  switch (failure) {
    case SteeringFailure::none: return FaultId::none;
    case SteeringFailure::motor_encoder:
    case SteeringFailure::reduction_encoder: return faults::steering_sensor;
    case SteeringFailure::critical:
    case SteeringFailure::both_encoders: return faults::steering_critical;
  }
  return FaultId::none;
}

}  // namespace

void Vehicle::watch(const lss::Inputs<Vehicle>& in, Supervisor& s) noexcept {
  supervisor_ = &s;
  isolated_ = s.controller().isolated;
  // First: a standstill of the machine makes data old, so it is the cause.
  if (in.overrun_limit && s.controller().state == State::operational)
    s.raise(FaultId::frame_overrun);
  watch_bus(in.bus, s);
  watch_inputs(s);
  watch_nodes(s);
  watch_mobility(s);
  watch_slip(s);
  watch_imu(s);
  watch_mode(s);
  watch_solver(s);
  set_sense(s);
}

void Vehicle::watch_bus(const BusReport& bus, Supervisor& s) noexcept {
  s.check_stop(bus.time_ns != 0 && bus.all_stop_pending);
  port_.watch(bus, bus.status.counters.safe_commands, bus.port.bus_offs, now_ns_, s);
  port_.watch_masters(bus.status.counters.master.other_masters, now_ns_, s);
}

void Vehicle::watch_nodes(Supervisor& s) noexcept {
  const auto link_of = [this](std::size_t i) -> const RoverLink& { return link(i); };
  watched_.watch_resets(
      now_ns_, parameters_.reset_ns, bus_.open, link_of,
      [this](std::size_t i) { return answers(i); }, s);
  kit::set_ages(kNodes, now_ns_, parameters_.bus.heartbeat_timeout_ns, link_of, s);
  for (std::size_t i = 0; i < kNodes; ++i) {
    watched_.watch(i, link(i).node,
                   {.answers = answers(i), .needed = i != kImu, .in_service = in_service(i)},
                   bus_.open, s);
    if (i >= kWheels + kSteered) continue;
    // Without power all drives report faults; the lost power is reported instead.
    const bool just_restored =
        (unsigned{restored_} >> i & 1u) != 0 && now_ns_ - restored_ns_ < kit::NodeWatch::kSettled;
    if (in_service(i) && !just_restored) {
      watched_.watch_drive(i, link(i), answers(i), inputs_.power_good, s);
    } else {
      watched_.forget_drive(i);
    }
    watched_.watch_dropouts(i, link(i), now_ns_, in_service(i) && inputs_.power_good, s);
  }
}

// What was pressed or lost in Idle is no emergency, and over when it is undone.
void Vehicle::watch_inputs(Supervisor& s) noexcept {
  // The node answers but its inputs are missing, perhaps since it began.
  const TimeNs heard_ns = std::max(inputs_ns_, link(kIo).node.since_ns);
  if (s.controller().state == State::operational && answers(kIo) &&
      now_ns_ - heard_ns > parameters_.io_silent_ns)
    s.raise(FaultId::stale_input, kIoNode);
  if (inputs_ns_ == 0) return;
  const std::uint8_t flags = s.controller().flags;
  const bool idle = s.controller().state == State::idle;
  if (inputs_.emergency_button != ((flags & kButtonIn) != 0)) {
    if (inputs_.emergency_button) s.latch(faults::emergency_button, kIoNode);
    if (!inputs_.emergency_button && idle) s.clear(faults::emergency_button, kIoNode);
    s.happen(inputs_.emergency_button ? event::button_in : event::button_out);
  }
  if (inputs_.power_good == ((flags & kPowerBad) != 0)) {
    const bool driven = s.controller().state == State::operational;
    if (!inputs_.power_good && (driven || inputs_.emergency_button))
      s.latch(faults::power_lost, kIoNode);
    if (inputs_.power_good && idle) s.clear(faults::power_lost, kIoNode);
    s.happen(inputs_.power_good ? event::power_good : event::power_bad);
  }
}

// ---- the mobility controller, as it was in the last frame

void Vehicle::watch_mobility(Supervisor& s) noexcept {
  if (!stepped_) return;
  for (std::size_t i = 0; i < kWheels; ++i) {
    watch_wheel(i, s);
    watch_heat(i, s);
    watch_unproven(i, s);
  }
  watch_yaw(s);
  for (std::size_t i = 0; i < kSteered; ++i) watch_steering(i, s);
  if (started_ns_ == now_ns_) s.clear(faults::instance_disagreed);  // nothing else solves it
  const gnc::ardito::VoteReport& vote = mobility_.report();
  if (vote.no_majority) {
    s.raise(faults::no_majority);
  } else if (vote.disagreed) {
    disagreeing_ = static_cast<std::uint8_t>(std::countr_zero(vote.disagreed) + 1);
    s.latch(faults::instance_disagreed);
  }
  const bool error = command_.error != 0;
  if (error && !error_) {
    if (s.controller().state == State::solve_errors) {
      s.latch(faults::mobility_error);
    } else {
      s.raise(faults::mobility_error);
    }
  }
  error_ = error;
  const bool rocker_lost =
      (has_fault(gnc::ardito::kRockerStale) || has_fault(gnc::ardito::kRockerJump) ||
       has_fault(gnc::ardito::kRockerOff)) &&
      !watched_.away(kIo);
  if (rocker_lost != rocker_lost_) {
    rocker_lost ? s.latch(faults::rocker_lost, kIoNode) : s.clear(faults::rocker_lost, kIoNode);
    rocker_lost_ = rocker_lost;
  }
}

// The failure of a wheel or steering system as a fault of its node.
static void report_change(FaultId before, FaultId now, std::size_t node, Supervisor& s) noexcept {
  if (now == before) return;
  if (before != FaultId::none && !severe(before)) s.clear(before, kit::module_of(node));
  if (now != FaultId::none && severe(now)) {
    kit::blame(now, node, s);
  } else if (now != FaultId::none) {
    s.latch(now, kit::module_of(node));
  }
}

void Vehicle::watch_wheel(std::size_t i, Supervisor& s) noexcept {
  const FaultId before = fault_of(failure_[i]), now = fault_of(command_.wheel_failure[i]);
  failure_[i] = command_.wheel_failure[i];
  report_change(before, now, i, s);
  if (gnc::ardito::contains(command_.stale_wheels, i) && in_service(i) && drives_on_)
    s.raise(FaultId::stale_input, kit::module_of(i));
}

void Vehicle::watch_heat(std::size_t i, Supervisor& s) noexcept {
  constexpr double kCooler_degC = 3;  // before it is no longer hot
  const std::uint32_t wheel = gnc::ardito::only(i);
  const bool was = (hot_ & wheel) != 0;
  const bool above = (command_.hot_motors & wheel) != 0;
  const bool below =
      wheel_[i].temperature_degC.value < parameters_.mobility.warm_temperature_C - kCooler_degC;
  if (!was && above) {
    hot_ |= wheel;
    s.latch(FaultId::temperature_warning, kit::module_of(i));
  } else if (was && below) {
    hot_ &= ~wheel;
    s.clear(FaultId::temperature_warning, kit::module_of(i));
  }
}

// What error solving forgot counts as failed until it worked under way: at rest nothing shows it.
void Vehicle::watch_unproven(std::size_t i, Supervisor& s) noexcept {
  constexpr int kProven = 20;  // frames
  const std::uint32_t wheel = gnc::ardito::only(i);
  const bool drives =
      command_.mode != gnc::ardito::Mode::stop && (command_.clutches_engaged & wheel) != 0 &&
      std::abs(command_.estimate.wheel_rad_s[i]) > parameters_.mobility.still_rad_s &&
      command_.wheel_suspect[i] == WheelFailure::none;
  proven_frames_[i] = drives ? proven_frames_[i] + 1 : 0;
  const bool found_again =
      command_.wheel_failure[i] != WheelFailure::none && (retry_wheels_ & wheel) == 0;
  if (proven_frames_[i] >= kProven || found_again || !in_service(i)) unproven_ &= ~wheel;
  const bool told = (unproven_told_ & wheel) != 0, is = (unproven_ & wheel) != 0;
  if (is && !told) s.latch(faults::wheel_unproven, kit::module_of(i));
  if (!is && told) s.clear(faults::wheel_unproven, kit::module_of(i));
  unproven_told_ = (unproven_told_ & ~wheel) | (unproven_ & wheel);
}

// Slip is reported; wheels that turn while the rover does not move are stopped.
void Vehicle::watch_slip(Supervisor& s) noexcept {
  constexpr int kBegins = 5, kEnds = -10;  // frames with slip, and without
  const gnc::ardito::Estimate& e = command_.estimate;
  const bool slips = has_fault(gnc::ardito::kSlip) || has_fault(gnc::ardito::kWheelsSlip);
  slip_frames_ = slips ? std::max(slip_frames_, 0) + 1 : std::min(slip_frames_, 0) - 1;
  if (slips) most_slip_m_s_ = std::max(most_slip_m_s_, std::abs(e.slip_m_s));
  if (!slipping_ && slip_frames_ >= kBegins) {
    slipping_ = true;
    s.note(events::slip_begun, 0, e.slip_m_s, e.load);
  } else if (slip_frames_ <= kEnds) {
    if (slipping_) s.note(events::slip_ended, 0, most_slip_m_s_);
    slipping_ = false;
    most_slip_m_s_ = 0;
    slip_frames_ = kEnds;
  }
  watch_slowed(s);
  const bool stuck = has_fault(gnc::ardito::kStuck);
  if (stuck && !stuck_ && s.happen(event::stuck).reason == Reason::none) {
    s.latch(faults::rover_stuck);
    s.note(events::stopped_stuck, 0, e.speed_m_s, e.ground_m_s);
    s.abandon(reasons::stuck);
    stuck_told_ = true;
  }
  stuck_ = stuck;
  if (!stuck_told_) s.clear(faults::rover_stuck);  // another command to move came
  watch_sinking(s);
}

// One wheel digs itself in: the rover stops before it is held.
void Vehicle::watch_sinking(Supervisor& s) noexcept {
  const unsigned sinks = command_.sinking;
  if (embedded_ != 0 && !embedded_told_) {  // another command to move came
    s.clear(faults::wheel_embedded, embedded_);
    embedded_ = 0;
  }
  if (sinks == 0 || s.happen(event::stuck).reason != Reason::none) return;
  const gnc::ardito::Estimate& e = command_.estimate;
  const gnc::ardito::Parameters& p = parameters_.mobility;
  embedded_ = kit::module_of(static_cast<std::size_t>(std::countr_zero(sinks)));
  embedded_told_ = true;
  s.latch(faults::wheel_embedded, embedded_);
  s.note(events::stopped_embedded, embedded_, e.sunk_m, p.sink_m, e.strain, e.strain_limit);
  s.abandon(reasons::wheel_embedded);
}

// A person learns why the rover drives slower than commanded.
void Vehicle::watch_slowed(Supervisor& s) noexcept {
  const bool slowed = has_fault(gnc::ardito::kSlipSlows);
  const double share = command_.estimate.slip_share;
  if (slowed && !slowed_) s.note(events::slip_slows, 0, share, parameters_.mobility.slow_share);
  if (slowed) most_slip_share_ = std::max(most_slip_share_, share);
  const bool measured = command_.mode != gnc::ardito::Mode::stop && share != 0;
  if (!slowed && slowed_ && measured) s.note(events::slip_slows_ended, 0, share, most_slip_share_);
  if (!slowed) most_slip_share_ = 0;
  slowed_ = slowed;
}

void Vehicle::watch_yaw(Supervisor& s) noexcept {
  constexpr int kGood = 50;  // frames
  const bool disagrees = has_fault(gnc::ardito::kYawDisagrees);
  yaw_good_frames_ = disagrees ? 0 : std::min(yaw_good_frames_ + 1, kGood);
  if (disagrees && !yaw_told_) s.latch(faults::yaw_disagrees);
  if (yaw_told_ && yaw_good_frames_ == kGood) s.clear(faults::yaw_disagrees);
  yaw_told_ = disagrees || (yaw_told_ && yaw_good_frames_ < kGood);
}

void Vehicle::watch_steering(std::size_t i, Supervisor& s) noexcept {
  const std::size_t node = kFirstSteering + i;
  const FaultId before = fault_of(steering_failure_[i]),
                now = fault_of(command_.steering_failure[i]);
  steering_failure_[i] = command_.steering_failure[i];
  report_change(before, now, node, s);
  if (gnc::ardito::contains(command_.stale_steering, i) && drives_on_)
    s.raise(FaultId::stale_input, kit::module_of(node));
}

// Driving by hand goes on without it.
void Vehicle::watch_imu(Supervisor& s) noexcept {
  constexpr std::uint32_t kBad = gnc::ardito::kImuSilent | gnc::ardito::kImuImplausible;
  const bool lost = !answers(kImu) || (stepped_ && (command_.faults & kBad) != 0);
  if (((s.controller().flags & kImuLost) != 0) != lost)
    s.happen(lost ? event::imu_lost : event::imu_good);
  // While it boots its absence is no fault.
  const bool expected = imu_seen_ || (port_.open() && now_ns_ - port_.opened_ns() > kBoot);
  const bool tell = expected && !watched_.away(kImu);
  if (lost && tell && !imu_told_) s.latch(faults::imu_lost, kImuNode);
  if (!lost && imu_told_) s.clear(faults::imu_lost, kImuNode);
  imu_told_ = lost && (tell || imu_told_);
  imu_seen_ = imu_seen_ || !lost;
  imu_lost_ = lost;
  if (lost && (s.controller().flags & kAutonomous) != 0 &&
      s.happen(event::autonomy_lost).reason == Reason::none) {
    s.note(events::autonomy_ended);
    s.abandon(Reason::imu_lost);
  }
}

bool Vehicle::all_heard() const noexcept {
  return (command_.stale_wheels & ~unsigned{isolated_}) == 0 && command_.stale_steering == 0;
}

// Its modes as modes of the locomotion controller.
void Vehicle::watch_mode(Supervisor& s) noexcept {
  const lc::ControllerState& c = s.controller();
  if (c.state != State::operational) return;
  if (c.mode == static_cast<std::uint8_t>(Mode::warning)) {
    // The controller must be stopped before the motors go on, after any mode before. And each value
    // must have been received, some come once a second; a missing one is a fault then.
    const TimeNs warned_ns = now_ns_ - started_ns_;
    const bool heard = all_heard() || warned_ns >= kSlowestValue;
    if (warned_ns >= parameters_.beacon_ns && stepped_ && standing() && heard)
      s.happen(event::warned);
    return;
  }
  if (!(c.flags & kMotorsConfirmed) && drives_enabled()) s.happen(event::motors_confirmed);
  lc::Event is = event::is_stopped;
  if (command_.mode == gnc::ardito::Mode::running) is = event::is_running;
  if (command_.mode == gnc::ardito::Mode::parking) is = event::is_parking;
  if (command_.mode == gnc::ardito::Mode::stop) {
    if (command_.phase == gnc::ardito::StopPhase::rover_steer) is = event::is_steering;
    if (command_.phase == gnc::ardito::StopPhase::deceleration) is = event::is_decelerating;
  }
  s.happen(is);  // in this mode already: refused, and nothing changes
}

void Vehicle::set_sense(Supervisor& s) noexcept {
  std::array<double, kMaxModules> sense{};
  sense[kSenseLimit] = limit_m_s_;
  for (std::size_t i = 0; i < kWheels + kSteered; ++i) {
    const bool on = answers(i) && link(i).drive == canopen::DriveState::operation_enabled;
    sense[kSenseMotorsOn] += on ? 1 : 0;
  }
  sense[kSenseCap] = parameters_.mobility.top_speed_m_s;
  sense[kSenseHeading] = parameters_.mobility.max_sigma_rad;
  s.set_sense(sense);
}

bool Vehicle::powered() const noexcept {
  for (std::size_t i = 0; i < kWheels + kSteered; ++i) {
    if (answers(i) && canopen::powered(link(i).drive)) return true;
  }
  return false;
}

// ---- error solving

std::uint16_t Vehicle::faulty_modules() const noexcept {
  unsigned mask = 0;
  for (std::size_t i = 0; i < kImu; ++i) {
    if (in_service(i) && (!answers(i) || faulty(i) || link(i).disobeys)) mask |= 1u << i;
  }
  return static_cast<std::uint16_t>(mask);
}

// Sensors that are substituted do not keep the rover from driving.
std::uint16_t Vehicle::diagnosed() const noexcept {
  unsigned nodes = 0;
  for (std::size_t i = 0; i < kWheels; ++i) {
    const WheelFailure f = command_.wheel_failure[i];
    const bool sensor = fault_of(f) == faults::wheel_sensor;
    if (f != WheelFailure::none && !sensor && in_service(i)) nodes |= 1u << i;
  }
  for (std::size_t i = 0; i < kSteered; ++i) {
    if (fault_of(command_.steering_failure[i]) == faults::steering_critical)
      nodes |= 1u << (kFirstSteering + i);
  }
  return static_cast<std::uint16_t>(nodes);
}

void Vehicle::reset_nodes(std::uint16_t nodes) noexcept {
  const bool sent = orders_.node_reset_serial == sent_.node_reset_serial;
  orders_.reset_nodes = static_cast<std::uint16_t>(sent ? nodes : orders_.reset_nodes | nodes);
  ++orders_.node_reset_serial;
  forget(nodes);
}

void Vehicle::forget(std::uint16_t nodes) noexcept {
  for (std::size_t i = 0; i < kWheels; ++i) {
    const bool failed = command_.wheel_failure[i] != WheelFailure::none;
    if ((unsigned{nodes} >> i & 1u) != 0 && failed) unproven_ |= 1u << i;
  }
  retry_wheels_ |= nodes & gnc::ardito::kAllWheels;
  retry_steering_ |= static_cast<unsigned>(nodes) >> kFirstSteering & gnc::ardito::kAllSteered;
}

bool Vehicle::isolate(std::uint16_t nodes) noexcept {
  if (std::popcount(nodes) != 1) return false;  // the rover goes on with five wheels, not with four
  const auto node = static_cast<std::size_t>(std::countr_zero(nodes));
  if (link(node).disobeys) return false;  // its motor may be on
  if (supervisor_->happen(event::isolate, kit::module_of(node)).reason != Reason::none)
    return false;
  isolated_ = supervisor_->controller().isolated;
  return true;
}

bool Vehicle::healthy(const Supervisor& s) const noexcept {
  const std::uint8_t flags = s.controller().flags;
  return port_.open() && !kit::PortWatch::stands_still(bus_, now_ns_) && faulty_modules() == 0 &&
         s.controller().unheard == 0 && s.controller().silent == 0 &&
         (flags & (kButtonIn | kPowerBad)) == 0 && command_.error == 0;
}

// From the latched faults and the present ones.
void Vehicle::begin_solving(const Supervisor& s) noexcept {
  std::array<FaultClass, kMaxFaults + 3> wrong;
  std::size_t count = 0;
  each_fatal(s, [&](const FaultRecord& fault) { wrong[count++] = class_of(fault.id); });
  bool contact_lost = false, drive_faults = false;
  for (std::size_t i = 0; i < kImu; ++i) {
    contact_lost = contact_lost || (in_service(i) && !answers(i));
    drive_faults = drive_faults || (in_service(i) && (faulty(i) || link(i).disobeys));
  }
  if (contact_lost) wrong[count++] = FaultClass::contact;
  if (drive_faults) wrong[count++] = FaultClass::drive;
  if (command_.error != 0) wrong[count++] = FaultClass::mobility;
  solver_.begin(std::span(wrong).first(count));
}

void Vehicle::watch_solver(Supervisor& s) noexcept {
  if (s.controller().state != State::solve_errors) return;
  const bool well = healthy(s);
  solve_errors(
      s, solver_, [&] { begin_solving(s); }, [&] { return solver_.step(*this, well); });
}

}  // namespace lss::ardito
