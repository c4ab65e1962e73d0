// Ardito's telemetry topic: conversion of its struct to the type of idl/ardito.idl.

#include "ardito.h"

#include <algorithm>

#include "daemon/dds/convert.h"
#include "daemon/dds/telemetry_topic.h"
#include "daemon/vehicles/ardito_telemetry.h"

namespace lss::ardito {
namespace {

static_assert(std::size(decltype(lss_ArditoTelemetry::wheels){}) == kDriveWheels);
static_assert(std::size(decltype(lss_ArditoTelemetry::steering){}) == kSteeredWheels);
static_assert(std::size(decltype(lss_ArditoTelemetry::nodes){}) == kBusNodes);

lss_ArditoNode node(const NodeTelemetry& from) {
  lss_ArditoNode to{};
  to.id = from.id;
  to.address = from.address;
  to.online = from.online;
  to.isolated = from.isolated;
  to.link = from.link;
  to.drive = from.drive;
  to.emergency = from.emergency;
  to.emergencies = from.emergencies;
  to.age_ms = from.age_ms;
  return to;
}

lss_ArditoWheel wheel(const WheelTelemetry& from) {
  lss_ArditoWheel to{};
  to.id = from.id;
  to.state = from.state;
  to.clutch = from.clutch;
  to.stopped = from.stopped;
  to.target_rad_s = from.target_rad_s;
  to.motor_rad_s = from.motor_rad_s;
  to.hall_rad_s = from.hall_rad_s;
  to.reduction_rad_s = from.reduction_rad_s;
  to.current_A = from.current_A;
  to.temperature_degC = from.temperature_degC;
  to.voltage_V = from.voltage_V;
  return to;
}

lss_ArditoSteering steering(const SteeringTelemetry& from) {
  lss_ArditoSteering to{};
  to.id = from.id;
  to.state = from.state;
  to.stopped = from.stopped;
  to.target_rad = from.target_rad;
  to.motor_rad = from.motor_rad;
  to.reduction_rad = from.reduction_rad;
  to.current_A = from.current_A;
  return to;
}

void convert(const void* from_untyped, std::string_view vehicle_id, void* to_untyped) {
  const auto& from = *static_cast<const Telemetry*>(from_untyped);
  auto& to = *static_cast<lss_ArditoTelemetry*>(to_untyped);
  to = {};
  dds::copy_text(vehicle_id, to.vehicle_id);
  to.time_ns = from.time_ns;
  to.frame = from.frame;
  to.state = static_cast<std::uint8_t>(from.state);
  to.mode = static_cast<std::uint8_t>(from.mode);
  to.autonomous = from.autonomous;
  to.correction = from.correction;
  to.limit_m_s = from.limit_m_s;
  to.speed_m_s = from.speed_m_s;
  to.heading_rad = from.heading_rad;
  to.measured_m_s = from.measured_m_s;
  to.measured_rad = from.measured_rad;
  to.distance_m = from.distance_m;
  to.yaw_rad = from.yaw_rad;
  to.x_m = from.x_m;
  to.y_m = from.y_m;
  std::transform(from.wheels.begin(), from.wheels.end(), std::begin(to.wheels), wheel);
  std::transform(from.steering.begin(), from.steering.end(), std::begin(to.steering), steering);
  std::transform(from.nodes.begin(), from.nodes.end(), std::begin(to.nodes), node);
  to.beta_rad = from.beta_rad;
  std::copy(from.rho_rad.begin(), from.rho_rad.end(), std::begin(to.rho_rad));
  to.imu_valid = from.imu_valid;
  to.imu_speed_m_s = from.imu_speed_m_s;
  to.imu_heading_rad = from.imu_heading_rad;
  to.imu_yaw_rate_rad_s = from.imu_yaw_rate_rad_s;
  to.emergency_button = from.emergency_button;
  to.power_good = from.power_good;
  to.beacon = from.beacon;
  to.disagreeing = from.disagreeing;
  to.disagreements = from.disagreements;
  to.bus_frames_sent = from.bus_frames_sent;
  to.bus_frames_received = from.bus_frames_received;
  to.bus_frames_dropped = from.bus_frames_dropped;
  to.bus_overflows = from.bus_overflows;
  to.bus_offs = from.bus_offs;
  to.port_open = from.port_open;
}

}  // namespace

const TelemetryTopic& telemetry_topic() {
  static const TelemetryTopic kTopic{"ardito", &lss_ArditoTelemetry_desc,
                                     sizeof(lss_ArditoTelemetry), convert};
  return kTopic;
}

}  // namespace lss::ardito
