// Lunar Zebro's telemetry topic: conversion of its struct to the type of idl/zebro.idl.

#include "zebro.h"

#include "daemon/dds/convert.h"
#include "daemon/dds/telemetry_topic.h"
#include "daemon/vehicles/zebro_telemetry.h"

namespace lss::zebro {
namespace {

static_assert(std::size(decltype(lss_ZebroTelemetry::modules){}) == kModules);

lss_ZebroModule to_dds(const ModuleTelemetry& module) {
  lss_ZebroModule to{};
  to.id = module.id;
  to.address = module.address;
  to.online = module.online;
  to.calibrated = module.calibrated;
  to.motion_control = module.motion_control;
  to.moving = module.moving;
  to.swing = module.swing;
  to.isolated = module.isolated;
  to.flags = module.flags;
  to.position_rad = module.position_rad;
  to.velocity_rad_s = module.velocity_rad_s;
  to.set_point_rad = module.set_point_rad;
  to.time_left_s = module.time_left_s;
  to.current_A = module.current_A;
  to.temperature_degC = module.temperature_degC;
  to.supply_V = module.supply_V;
  to.uptime_s = module.uptime_s;
  to.firmware_major = module.firmware_major;
  to.firmware_minor = module.firmware_minor;
  to.reset_cause = module.reset_cause;
  to.dropped_frames = module.dropped_frames;
  to.age_ms = module.age_ms;
  to.replies = module.replies;
  to.resends = module.resends;
  return to;
}

void convert(const void* from_untyped, std::string_view vehicle_id, void* to_untyped) {
  const auto& from = *static_cast<const Telemetry*>(from_untyped);
  auto& to = *static_cast<lss_ZebroTelemetry*>(to_untyped);
  to = {};
  dds::copy_text(vehicle_id, to.vehicle_id);
  to.time_ns = from.time_ns;
  to.frame = from.frame;
  to.state = static_cast<std::uint8_t>(from.state);
  to.mode = static_cast<std::uint8_t>(from.mode);
  to.speed = from.speed;
  to.heading_rad = from.heading_rad;
  to.direction = from.direction;
  to.distance_m = from.distance_m;
  to.yaw_rad = from.yaw_rad;
  to.speed_m_s = from.speed_m_s;
  to.steps = from.steps;
  std::transform(from.modules.begin(), from.modules.end(), std::begin(to.modules), to_dds);
  to.bus_frames_sent = from.bus_frames_sent;
  to.bus_frames_received = from.bus_frames_received;
  to.bus_frames_dropped = from.bus_frames_dropped;
  to.bus_overflows = from.bus_overflows;
  to.bus_cycle_ns = static_cast<std::uint64_t>(from.bus_cycle_ns);
  to.port_open = from.port_open;
}

}  // namespace

const TelemetryTopic& telemetry_topic() {
  static const TelemetryTopic kTopic{"zebro", &lss_ZebroTelemetry_desc, sizeof(lss_ZebroTelemetry),
                                     convert};
  return kTopic;
}

}  // namespace lss::zebro
