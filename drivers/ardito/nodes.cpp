// The nodes of docs/icd-ardito.md sections 2, 5 and 7 for the CANopen master.

#include "drivers/ardito/rover_bus.h"
#include "drivers/canopen/drive_pdo.h"

namespace lss::ardito {
namespace {

using canopen::kFallBack;
using canopen::kHoldWhenStopped;
using canopen::kInhibitEmergencies;
using canopen::kStopOnLoss;
using canopen::NodeParameters;
using canopen::Pdo;

constexpr std::uint32_t kStepper = 0x0004'0192, kIoDevice = 0x0007'0191;
constexpr std::uint32_t kImuDevice = 0x0001'0000;
constexpr std::uint32_t kProfilePosition = 1;  // mode of operation
constexpr std::uint32_t kBeaconBit = 0x40;

constexpr Pdo kWheelTpdo2 = {2, canopen::kOnSync, 0, 0, {0x2100'0120, 0x2100'0220}};
constexpr Pdo kWheelTpdo3 = {3, canopen::kEvent, 0, 1000, {0x2101'0110, 0x2101'0210}};
constexpr Pdo kSteeringRpdo1 = {1, canopen::kEvent, 0, 0, {0x6040'0010, 0x607A'0020}};
constexpr Pdo kSteeringTpdo1 = {1, canopen::kOnSync, 0, 0, {0x6041'0010, 0x6064'0020, 0x6078'0010}};
constexpr Pdo kSteeringTpdo2 = {2, canopen::kOnSync, 0, 0, {0x2100'0320}};
constexpr Pdo kIoRpdo1 = {1, canopen::kEvent, 0, 0, {0x6200'0108}};
constexpr Pdo kIoTpdo1 = {1, canopen::kDeviceEvent, 20, 0, {0x6000'0108}};
constexpr Pdo kIoTpdo2 = {2, canopen::kOnSync, 0, 0, {0x6401'0110, 0x6401'0210, 0x6401'0310}};
constexpr Pdo kImuTpdo1 = {
    1, canopen::kOnSync, 0, 0, {0x2110'0110, 0x2110'0210, 0x2110'0310, 0x2110'0410}};

NodeParameters wheel(std::uint8_t node, const RoverBusParameters& p) {
  NodeParameters drive = canopen::velocity_drive(node, p.wheel_acceleration_rpm_s);
  drive.tpdo[1] = kWheelTpdo2;
  drive.tpdo[2] = kWheelTpdo3;
  return drive;
}

NodeParameters steering(std::uint8_t node, const RoverBusParameters& p) {
  constexpr double kPerRad = 1e4;
  const std::uint32_t speed = canopen::object_u32(p.steering_speed_rad_s * p.gear_ratio * kPerRad);
  const std::uint32_t acceleration =
      canopen::object_u32(p.steering_acceleration_rad_s2 * p.gear_ratio * kPerRad);
  return {node,
          kStepper,
          {{kInhibitEmergencies,
            kFallBack,
            kStopOnLoss,
            kHoldWhenStopped,
            {canopen::kModeOfOperation, 0, 1, kProfilePosition},
            {canopen::kProfileVelocity, 0, 4, speed},
            {canopen::kAcceleration, 0, 4, acceleration},
            {canopen::kDeceleration, 0, 4, acceleration},
            {canopen::kQuickStopDeceleration, 0, 4, acceleration}}},
          {kSteeringRpdo1},
          {kSteeringTpdo1, kSteeringTpdo2}};
}

// On a communication error clutches and beacon keep their state.
NodeParameters io(std::uint8_t node) {
  return {node,
          kIoDevice,
          {{kInhibitEmergencies,
            kFallBack,
            {canopen::kOutputErrorMode, 1, 1, kBeaconBit},
            {canopen::kOutputErrorValue, 1, 1, kBeaconBit}}},
          {kIoRpdo1},
          {kIoTpdo1, kIoTpdo2}};
}

NodeParameters imu(std::uint8_t node) {
  return {node, kImuDevice, {{kInhibitEmergencies, kFallBack}}, {}, {kImuTpdo1}};
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
  master.nodes[kIo] = io(p.io_node);
  master.nodes[kImu] = imu(p.imu_node);
  return master;
}

}  // namespace lss::ardito
