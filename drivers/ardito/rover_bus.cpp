#include "drivers/ardito/rover_bus.h"

#include <algorithm>

namespace lss::ardito {
namespace {

using canopen::DriveState;

// Repetition of an acknowledged set-point, in case both frames were lost and the answer was old.
constexpr TimeNs kRepeat = kSecond;

}  // namespace

bool stops_all(const RoverOrders& orders) noexcept {
  const auto on = [](const auto& drive) { return drive.enabled; };
  return orders.quick_stop ||
         (std::ranges::none_of(orders.wheel, on) && std::ranges::none_of(orders.steering, on));
}

RoverBus::RoverBus(const RoverBusParameters& parameters) noexcept
    : DriveBus(master_parameters(parameters), parameters, kWheels + kSteered),
      profile_(parameters.profile),
      gear_ratio_(parameters.gear_ratio),
      set_point_gap_ns_(parameters.set_point_gap_ns) {
  restart(0);
}

void RoverBus::release(const RoverOrders& orders, TimeNs now) noexcept {
  orders_ = orders;
  release_orders(orders, now);
}

RoverBus::Order RoverBus::order(std::size_t node) const noexcept {
  if (node < kWheels) return {orders_.wheel[node].enabled, orders_.wheel[node].motor_rpm};
  const SteeringOrder& steering = orders_.steering[node - kFirstSteering];
  return {steering.enabled, steering.position_rad};
}

void RoverBus::send_others() noexcept {
  if (!operational(kIo)) return;
  const std::uint8_t outputs = io_rpdo(orders_.clutches, orders_.beacon);
  master_.send_rpdo(kIo, 1, {&outputs, 1});
}

void RoverBus::send_stop(std::size_t node, std::uint16_t controlword) noexcept {
  if (node < kWheels) return master_.send_rpdo(node, 1, drive_rpdo(controlword, 0));
  SetPoint& point = set_point_[node - kFirstSteering];
  point.has_target = point.edge_due = point.unacknowledged = false;
  master_.send_rpdo(node, 1, drive_rpdo(controlword, point.target));
}

void RoverBus::send_order(std::size_t node, bool enabled, TimeNs now) noexcept {
  if (node >= kFirstSteering) return send_steering(node - kFirstSteering, enabled, now);
  const std::uint16_t word = controlword(node, enabled);
  const bool turns = word == canopen::kEnableOperation;
  const Field& target =
      profile_[static_cast<std::size_t>(Kind::wheel)].of(WheelSignal::target_velocity);
  const double motor_rpm = turns ? orders_.wheel[node].motor_rpm : 0;
  master_.send_rpdo(node, 1, drive_rpdo(word, counts(target, motor_rpm)));
}

// A new set-point is taken at the rising edge of its bit: first low with the new target, then high,
// which is kept.
void RoverBus::send_steering(std::size_t steered, bool enabled, TimeNs now) noexcept {
  const std::size_t node = kFirstSteering + steered;
  SetPoint& point = set_point_[steered];
  const std::uint16_t word = controlword(node, enabled);
  const auto send = [&](std::uint16_t bits) {
    master_.send_rpdo(node, 1, drive_rpdo(static_cast<std::uint16_t>(word | bits), point.target));
  };
  if (!enabled || state(node) != DriveState::operation_enabled) {
    point.has_target = point.edge_due = point.unacknowledged = false;
    return send(0);
  }
  const Field& field =
      profile_[static_cast<std::size_t>(Kind::steering)].of(SteeringSignal::target_position);
  const std::int32_t target = counts(field, orders_.steering[steered].position_rad * gear_ratio_);
  if (point.has_target && point.target == target && now - point.edge_ns < kRepeat) {
    if (!point.edge_due) send(canopen::kChangeImmediately | canopen::kNewSetPoint);
    return;
  }
  point.target = target;
  point.has_target = point.edge_due = true;
  point.unacknowledged = false;
  point.edge_ns = now + set_point_gap_ns_;
  send(canopen::kChangeImmediately);
}

void RoverBus::send_due(TimeNs now) noexcept {
  for (std::size_t s = 0; s < kSteered; ++s) {
    SetPoint& point = set_point_[s];
    if (!point.edge_due || now < point.edge_ns) continue;
    point.edge_due = false;
    point.unacknowledged = true;
    point.edge_ns = now;
    ++point.sent;
    constexpr std::uint16_t kWord =
        canopen::kEnableOperation | canopen::kChangeImmediately | canopen::kNewSetPoint;
    master_.send_rpdo(kFirstSteering + s, 1, drive_rpdo(kWord, point.target));
  }
}

TimeNs RoverBus::next_due() const noexcept {
  TimeNs due = canopen::kNever;
  for (const SetPoint& point : set_point_) {
    if (point.edge_due) due = std::min(due, point.edge_ns);
  }
  return due;
}

void RoverBus::receive(std::span<const CanFrame> frames) noexcept {
  canopen::PdoSample raw;
  for (const CanFrame& frame : frames) {
    master_.receive(frame);
    while (master_.take(raw)) {
      const auto reading =
          decode(profile_, raw.node, raw.number, std::span(raw.data).first(raw.size));
      if (!reading) continue;
      if (const auto* motion = std::get_if<WheelMotion>(&*reading)) {
        heard(raw.node, motion->statusword);
      } else if (const auto* steering = std::get_if<SteeringMotion>(&*reading)) {
        heard_steering(*steering, raw.node, raw.time_ns);
      }
      if (!samples_.put({raw.time_ns, *reading})) ++counters_.overflows;
    }
  }
}

void RoverBus::heard_steering(const SteeringMotion& motion, std::size_t node, TimeNs now) noexcept {
  heard(node, motion.statusword);
  SetPoint& point = set_point_[node - kFirstSteering];
  if (!point.unacknowledged || now <= point.edge_ns) return;
  point.unacknowledged = false;
  if ((motion.statusword & canopen::kSetPointAcknowledged) != 0) return;
  ++point.refused;
  point.has_target = false;  // again with the next orders
}

const RoverStatus& RoverBus::status() noexcept {
  for (std::size_t node = 0; node < master_.nodes(); ++node) {
    RoverLink& link = status_.link[node];
    describe(node, link);
    if (node < kFirstSteering || node >= kIo) continue;
    link.set_points = set_point_[node - kFirstSteering].sent;
    link.set_points_refused = set_point_[node - kFirstSteering].refused;
  }
  describe(status_.counters);
  return status_;
}

}  // namespace lss::ardito
