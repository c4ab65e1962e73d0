// The nodes of docs/icd-ardito.md sections 2, 5 and 7 for the CANopen master, by their
// descriptions.

#include "drivers/ardito/rover_bus.h"
#include "drivers/canopen/drive_pdo.h"

namespace lss::ardito {
namespace {

using canopen::Entry;
using canopen::NodeParameters;
using canopen::Pdo;

template <class Signal, class... More>
Pdo pdo(std::uint8_t number, std::uint8_t type, const Profile& p, Signal first, More... more) {
  Pdo result{.number = number, .type = type};
  std::size_t count = 0;
  for (const Signal signal : {first, more...}) {
    const std::uint32_t mapping = p.of(signal).mapping();
    if (mapping != 0) result.objects[count++] = mapping;
  }
  return result;
}

// A number in the object of a signal, after the entries of the description.
template <class Signal>
void write(NodeParameters& node, const Profile& p, Signal signal, double value) {
  for (Entry& entry : node.entries) {
    if (entry.size != 0) continue;
    const Field& f = p.of(signal);
    entry = {f.index, f.sub, f.bytes, canopen::object_u32(value / f.unit)};
    return;
  }
}

NodeParameters node_of(std::uint8_t number, const Profile& p) {
  NodeParameters node{.node = number, .device_type = p.device_type};
  for (std::size_t i = 0; i < p.entries.size(); ++i) node.entries[i] = p.entries[i];
  return node;
}

NodeParameters wheel(std::uint8_t number, const RoverBusParameters& parameters) {
  using S = WheelSignal;
  const Profile& p = parameters.profile[static_cast<std::size_t>(Kind::wheel)];
  NodeParameters node = node_of(number, p);
  for (const S ramp : {S::acceleration, S::deceleration, S::quick_stop_deceleration})
    write(node, p, ramp, parameters.wheel_acceleration_rpm_s);
  node.rpdo[0] = pdo(1, canopen::kEvent, p, S::controlword, S::target_velocity);
  node.tpdo[0] = pdo(1, canopen::kOnSync, p, S::statusword, S::velocity, S::current);
  node.tpdo[1] = pdo(2, canopen::kOnSync, p, S::hall_velocity, S::wheel_velocity);
  node.tpdo[2] = pdo(3, canopen::kEvent, p, S::temperature, S::link_voltage);
  node.tpdo[2].event_ms = 1000;
  return node;
}

NodeParameters steering(std::uint8_t number, const RoverBusParameters& parameters) {
  using S = SteeringSignal;
  const Profile& p = parameters.profile[static_cast<std::size_t>(Kind::steering)];
  NodeParameters node = node_of(number, p);
  write(node, p, S::profile_velocity, parameters.steering_speed_rad_s * parameters.gear_ratio);
  for (const S ramp : {S::acceleration, S::deceleration, S::quick_stop_deceleration})
    write(node, p, ramp, parameters.steering_acceleration_rad_s2 * parameters.gear_ratio);
  node.rpdo[0] = pdo(1, canopen::kEvent, p, S::controlword, S::target_position);
  node.tpdo[0] = pdo(1, canopen::kOnSync, p, S::statusword, S::position, S::current);
  node.tpdo[1] = pdo(2, canopen::kOnSync, p, S::wheel_position);
  return node;
}

NodeParameters io(const RoverBusParameters& parameters) {
  using S = IoSignal;
  const Profile& p = parameters.profile[static_cast<std::size_t>(Kind::io)];
  NodeParameters node = node_of(parameters.io_node, p);
  node.rpdo[0] = pdo(1, canopen::kEvent, p, S::outputs);
  node.tpdo[0] = pdo(1, canopen::kDeviceEvent, p, S::inputs);
  node.tpdo[0].inhibit_100us = 20;
  node.tpdo[1] = pdo(2, canopen::kOnSync, p, S::beta, S::rho1, S::rho2);
  return node;
}

NodeParameters imu(const RoverBusParameters& parameters) {
  using S = ImuSignal;
  const Profile& p = parameters.profile[static_cast<std::size_t>(Kind::imu)];
  NodeParameters node = node_of(parameters.imu_node, p);
  node.tpdo[0] = pdo(1, canopen::kOnSync, p, S::speed, S::direction, S::yaw_rate, S::counter);
  return node;
}

}  // namespace

canopen::MasterParameters master_parameters(const RoverBusParameters& p) noexcept {
  canopen::MasterParameters master;
  master.heartbeat = {p.master_node, p.heartbeat_period_ns, p.heartbeat_timeout_ns};
  master.sync_period_ns = p.period_ns;
  for (std::size_t i = 0; i < kWheels; ++i) master.nodes[i] = wheel(p.wheel_node[i], p);
  for (std::size_t i = 0; i < kSteered; ++i) {
    master.nodes[kFirstSteering + i] = steering(p.steering_node[i], p);
  }
  master.nodes[kIo] = io(p);
  master.nodes[kImu] = imu(p);
  return master;
}

}  // namespace lss::ardito
