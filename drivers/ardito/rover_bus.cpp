#include "drivers/ardito/rover_bus.h"

#include <algorithm>
#include <cmath>

namespace lss::ardito {
namespace {

using canopen::DriveState;
using canopen::NodeState;

// Repetition of an acknowledged set-point, in case both frames were lost and the answer was old.
constexpr TimeNs kRepeat = kSecond;

// Serials count up and wrap.
bool after(std::uint32_t serial, std::uint32_t other) {
  return static_cast<std::int32_t>(serial - other) > 0;
}

}  // namespace

bool stops_all(const RoverOrders& orders) noexcept {
  const auto on = [](const auto& drive) { return drive.enabled; };
  return orders.quick_stop ||
         (std::ranges::none_of(orders.wheel, on) && std::ranges::none_of(orders.steering, on));
}

RoverBus::RoverBus(const RoverBusParameters& parameters) noexcept
    : parameters_(parameters), master_(master_parameters(parameters)) {
  restart(0);
}

void RoverBus::restart(TimeNs now) noexcept {
  master_.restart(now, now + parameters_.stand_still_ns);
  sample_count_ = 0;
  for (Drive& drive : drive_) {
    drive.state = DriveState::unknown;
    drive.reset_step = 0;
  }
  stop_all(now);
}

void RoverBus::stop_all(TimeNs now) noexcept {
  stopping_ = true;
  ended_serial_ = orders_.serial;
  send_all(now);
}

void RoverBus::release(const RoverOrders& orders, TimeNs now) noexcept {
  ++counters_.releases;
  const bool emergency = orders.emergency_serial != emergency_serial_;
  emergency_serial_ = orders.emergency_serial;
  released_ = true;
  orders_ = orders;
  if (now - orders.issued_ns > parameters_.stale_after_ns) {
    ++counters_.stale_orders;
    return stop_stale(now);
  }
  stale_ = false;
  if (orders.fault_reset_serial != fault_reset_serial_) {
    fault_reset_serial_ = orders.fault_reset_serial;
    for (Drive& drive : drive_) drive.reset_step = drive.state == DriveState::fault ? 1 : 0;
  }
  if (orders.node_reset_serial != node_reset_serial_) {
    node_reset_serial_ = orders.node_reset_serial;
    for (std::size_t i = 0; i < kNodes; ++i) {
      if ((orders.reset_nodes >> i & 1) != 0) master_.reset(i, now);
    }
  }
  master_.allow_boot(orders.standing);
  if (orders.next_frame_ns != 0) {
    master_.sync_at(orders.next_frame_ns - parameters_.sync_lead_ns);
  }
  if (emergency) return stop_all(now);
  if (stopping_ && after(orders.serial, ended_serial_)) stopping_ = false;
  if (stopping_) ++counters_.old_orders;
  send_all(now);
}

// Orders are missing or too old.
void RoverBus::stop_stale(TimeNs now) noexcept {
  if (!stale_) ++counters_.safe_commands;
  stale_ = true;
  master_.allow_boot(false);
  stop_all(now);
}

bool RoverBus::operational(std::size_t node) const noexcept {
  return master_.nodes() > node && master_.status(node).state == NodeState::operational;
}

// Sends all orders, or the stop.
void RoverBus::send_all(TimeNs now) noexcept {
  stop_again_ns_ = now + parameters_.period_ns;
  for (std::size_t node = 0; node < drive_.size(); ++node) {
    watch(node, now);
    send_drive(node, now);
  }
  if (!released_ || stale_ || !operational(kIo)) return;
  const std::uint8_t outputs = io_rpdo(orders_.clutches, orders_.beacon);
  master_.send_rpdo(kIo, 1, {&outputs, 1});
}

// A drive whose heartbeat is lost may still receive: it gets a stop.
void RoverBus::send_drive(std::size_t node, TimeNs now) noexcept {
  Drive& drive = drive_[node];
  const bool enabled = ordered(node);
  if (!operational(node)) drive.state = DriveState::unknown;
  if (moves() && operational(node)) {
    if (node < kWheels) return send_wheel(node, enabled);
    return send_steering(node - kFirstSteering, enabled, now);
  }
  drive.has_target = drive.edge_due = drive.unacknowledged = false;
  const std::uint16_t word = drive.reset_step > 0 ? controlword(drive, false) : canopen::kQuickStop;
  master_.send_rpdo(node, 1,
                    node < kWheels ? wheel_rpdo(word, 0) : steering_rpdo(word, drive.target));
}

std::uint16_t RoverBus::controlword(Drive& drive, bool enabled) noexcept {
  if (drive.reset_step > 0) {
    drive.reset_step = drive.reset_step == 1 ? 2 : 0;
    return drive.reset_step == 2 ? canopen::kDisableVoltage : canopen::kFaultReset;
  }
  if (enabled) return canopen::towards_enabled(drive.state);
  const bool held = drive.state == DriveState::quick_stop_active ||
                    drive.state == DriveState::fault || drive.state == DriveState::unknown;
  return held ? canopen::kDisableVoltage : canopen::kShutdown;
}

void RoverBus::send_wheel(std::size_t wheel, bool enabled) noexcept {
  Drive& drive = drive_[wheel];
  const std::uint16_t word = controlword(drive, enabled);
  const bool turns = word == canopen::kEnableOperation;
  master_.send_rpdo(wheel, 1, wheel_rpdo(word, turns ? orders_.wheel[wheel].motor_rpm : 0));
}

// A new set-point is taken at the rising edge of its bit: first low with the new target, then high,
// which is kept.
void RoverBus::send_steering(std::size_t steered, bool enabled, TimeNs now) noexcept {
  const std::size_t node = kFirstSteering + steered;
  Drive& drive = drive_[node];
  const std::uint16_t word = controlword(drive, enabled);
  const auto send = [&](std::uint16_t bits) {
    master_.send_rpdo(node, 1,
                      steering_rpdo(static_cast<std::uint16_t>(word | bits), drive.target));
  };
  if (!enabled || drive.state != DriveState::operation_enabled) {
    drive.has_target = drive.edge_due = drive.unacknowledged = false;
    return send(0);
  }
  const std::int32_t target =
      steering_counts(orders_.steering[steered].position_rad * parameters_.gear_ratio);
  if (drive.has_target && drive.target == target && now - drive.edge_ns < kRepeat) {
    if (!drive.edge_due) send(canopen::kChangeImmediately | canopen::kNewSetPoint);
    return;
  }
  drive.target = target;
  drive.has_target = drive.edge_due = true;
  drive.unacknowledged = false;
  drive.edge_ns = now + parameters_.set_point_gap_ns;
  send(canopen::kChangeImmediately);
}

void RoverBus::send_edges(TimeNs now) noexcept {
  for (std::size_t s = 0; s < kSteered; ++s) {
    Drive& drive = drive_[kFirstSteering + s];
    if (!drive.edge_due || now < drive.edge_ns) continue;
    drive.edge_due = false;
    drive.unacknowledged = true;
    drive.edge_ns = now;
    ++drive.set_points;
    constexpr std::uint16_t kWord =
        canopen::kEnableOperation | canopen::kChangeImmediately | canopen::kNewSetPoint;
    master_.send_rpdo(kFirstSteering + s, 1, steering_rpdo(kWord, drive.target));
  }
}

// Whether the orders enable this drive. An order that is not a number does not.
bool RoverBus::ordered(std::size_t node) noexcept {
  const bool wheel = node < kWheels;
  const std::size_t s = node - (wheel ? 0 : kFirstSteering);
  const bool enabled = wheel ? orders_.wheel[s].enabled : orders_.steering[s].enabled;
  const double value = wheel ? orders_.wheel[s].motor_rpm : orders_.steering[s].position_rad;
  if (enabled && !std::isfinite(value)) {
    ++counters_.bad_orders;
    return false;
  }
  return enabled;
}

void RoverBus::watch(std::size_t node, TimeNs now) noexcept {
  Drive& drive = drive_[node];
  const bool s = node >= kFirstSteering;
  const bool enabled =
      s ? orders_.steering[node - kFirstSteering].enabled : orders_.wheel[node].enabled;
  const bool runs = drive.state == DriveState::operation_enabled;
  if (!operational(node) || runs == (enabled && moves())) drive.obeyed_ns = now;
  drive.disobeys = now - drive.obeyed_ns > parameters_.disobeys_after_ns;
}

void RoverBus::receive(std::span<const CanFrame> frames) noexcept {
  canopen::PdoSample raw;
  for (const CanFrame& frame : frames) {
    master_.receive(frame);
    while (master_.take(raw)) {
      const auto reading = decode(raw.node, raw.number, std::span(raw.data).first(raw.size));
      if (!reading) continue;
      if (const auto* motion = std::get_if<WheelMotion>(&*reading)) {
        heard(drive_[raw.node], motion->statusword);
      } else if (const auto* steering = std::get_if<SteeringMotion>(&*reading)) {
        Drive& drive = drive_[raw.node];
        heard(drive, steering->statusword);
        if (drive.unacknowledged && raw.time_ns > drive.edge_ns) {
          drive.unacknowledged = false;
          if ((steering->statusword & canopen::kSetPointAcknowledged) == 0) {
            ++drive.refused;
            drive.has_target = false;  // again with the next orders
          }
        }
      }
      keep({raw.time_ns, *reading});
    }
  }
}

void RoverBus::heard(Drive& drive, std::uint16_t statusword) noexcept {
  drive.statusword = statusword;
  drive.state = canopen::drive_state(statusword);
}

void RoverBus::keep(const RoverSample& sample) noexcept {
  if (sample_count_ == kMaxSamples) {
    ++counters_.overflows;
    first_sample_ = (first_sample_ + 1) % kMaxSamples;
    --sample_count_;
  }
  sample_[(first_sample_ + sample_count_++) % kMaxSamples] = sample;
}

std::size_t RoverBus::take(std::span<RoverSample> out) noexcept {
  const std::size_t count = std::min(out.size(), sample_count_);
  for (std::size_t i = 0; i < count; ++i) out[i] = sample_[(first_sample_ + i) % kMaxSamples];
  first_sample_ = (first_sample_ + count) % kMaxSamples;
  sample_count_ -= count;
  return count;
}

bool RoverBus::transmit(TimeNs now, CanFrame& frame) noexcept {
  if (released_ && !stale_ && now - orders_.issued_ns > parameters_.stale_after_ns) {
    stop_stale(now);
  } else if (stopping_ && now >= stop_again_ns_) {
    send_all(now);
  }
  send_edges(now);
  return master_.transmit(now, frame);
}

TimeNs RoverBus::next_wake() const noexcept {
  TimeNs wake = master_.next_wake();
  if (released_ && !stale_) {
    wake = std::min(wake, orders_.issued_ns + parameters_.stale_after_ns + 1);
  }
  if (stopping_) wake = std::min(wake, stop_again_ns_);
  for (const Drive& drive : drive_) {
    if (drive.edge_due) wake = std::min(wake, drive.edge_ns);
  }
  return wake;
}

const RoverStatus& RoverBus::status() noexcept {
  for (std::size_t node = 0; node < master_.nodes(); ++node) {
    RoverLink& link = status_.link[node];
    link.node = master_.status(node);
    link.sdo_aborts = master_.sdo(node).aborts;
    link.sdo_repeats = master_.sdo(node).repeats;
    if (node >= drive_.size()) continue;
    const Drive& drive = drive_[node];
    link.drive = operational(node) ? drive.state : DriveState::unknown;
    link.statusword = drive.statusword;
    link.disobeys = drive.disobeys;
    link.set_points = drive.set_points;
    link.set_points_refused = drive.refused;
  }
  counters_.master = master_.counters();
  status_.counters = counters_;
  return status_;
}

}  // namespace lss::ardito
