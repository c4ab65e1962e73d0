// TALARIS' telemetry topic: conversion of its struct to the type of idl/talaris.idl.

#include "talaris.h"

#include <algorithm>
#include <array>

#include "daemon/dds/convert.h"
#include "daemon/dds/telemetry_topic.h"
#include "daemon/vehicles/talaris_telemetry.h"

namespace lss::talaris {
namespace {

static_assert(std::size(decltype(lss_TalarisTelemetry::valves){}) == kValveCount);
static_assert(std::size(decltype(lss_TalarisTelemetry::fans){}) == kFanCount);
static_assert(std::size(decltype(lss_TalarisTelemetry::modules){}) == kModuleCount);

template <std::size_t N>
void copy(const std::array<double, N>& from, double (&to)[N]) {
  std::copy(from.begin(), from.end(), std::begin(to));
}

lss_TalarisModule module_of(const ModuleTelemetry& from) {
  lss_TalarisModule to{};
  to.id = from.id;
  to.online = from.online;
  to.link = from.link;
  to.age_ms = from.age_ms;
  to.samples = from.samples;
  to.errors = from.errors;
  to.lost = from.lost;
  return to;
}

lss_TalarisValve valve_of(const ValveTelemetry& from) {
  lss_TalarisValve to{};
  to.id = from.id;
  to.enabled = from.enabled;
  to.open = from.open;
  to.on_s = from.on_s;
  to.delay_s = from.delay_s;
  to.fired_s = from.fired_s;
  to.pulses = from.pulses;
  return to;
}

lss_TalarisFan fan_of(const FanTelemetry& from) {
  lss_TalarisFan to{};
  to.id = from.id;
  to.armed = from.armed;
  to.throttle = from.throttle;
  to.target_rpm = from.target_rpm;
  to.rpm = from.rpm;
  return to;
}

void convert(const void* from_untyped, std::string_view vehicle_id, void* to_untyped) {
  const auto& from = *static_cast<const Telemetry*>(from_untyped);
  auto& to = *static_cast<lss_TalarisTelemetry*>(to_untyped);
  to = {};
  dds::copy_text(vehicle_id, to.vehicle_id);
  to.time_ns = from.time_ns;
  to.frame = from.frame;
  to.state = static_cast<std::uint8_t>(from.state);
  to.mode = static_cast<std::uint8_t>(from.mode);
  to.phase = static_cast<std::uint8_t>(from.phase);
  to.program = static_cast<std::uint8_t>(from.program);
  to.gains = from.gains;
  to.calibrated = from.calibrated;
  to.planned = from.planned;
  to.airborne = from.airborne;
  to.calibrated_share = from.calibrated_share;
  to.phase_s = from.phase_s;
  to.remaining_s = from.remaining_s;
  copy(from.position_m, to.position_m);
  copy(from.velocity_m_s, to.velocity_m_s);
  copy(from.attitude_wxyz, to.attitude_wxyz);
  copy(from.rate_rad_s, to.rate_rad_s);
  copy(from.acceleration_m_s2, to.acceleration_m_s2);
  copy(from.position_sigma_m, to.position_sigma_m);
  copy(from.attitude_sigma_rad, to.attitude_sigma_rad);
  copy(from.gyro_bias_rad_s, to.gyro_bias_rad_s);
  copy(from.accelerometer_bias_m_s2, to.accelerometer_bias_m_s2);
  to.innovation_m = from.innovation_m;
  to.ranges_used = from.ranges_used;
  to.ranges_gated = from.ranges_gated;
  copy(from.target_position_m, to.target_position_m);
  copy(from.target_velocity_m_s, to.target_velocity_m_s);
  copy(from.thrust_N, to.thrust_N);
  copy(from.attitude_error_rad, to.attitude_error_rad);
  to.range_m = from.range_m;
  copy(from.pressure_Pa, to.pressure_Pa);
  to.gas_thruster_s = from.gas_thruster_s;
  to.gas_left_thruster_s = from.gas_left_thruster_s;
  to.voltage_V = from.voltage_V;
  to.temperature_degC = from.temperature_degC;
  copy(from.load_N, to.load_N);
  copy(from.load_Nm, to.load_Nm);
  std::transform(from.valves.begin(), from.valves.end(), std::begin(to.valves), valve_of);
  std::transform(from.fans.begin(), from.fans.end(), std::begin(to.fans), fan_of);
  std::transform(from.modules.begin(), from.modules.end(), std::begin(to.modules), module_of);
  to.script_id = from.script_id;
  to.script_steps = from.script_steps;
  to.script_done = from.script_done;
  to.script_s = from.script_s;
  to.edges = from.edges;
  to.edge_worst_s = from.edge_worst_s;
  to.imu_port_open = from.imu_port_open;
  to.altimeter_port_open = from.altimeter_port_open;
  to.can_port_open = from.can_port_open;
  to.bus_frames_sent = from.bus_frames_sent;
  to.bus_frames_received = from.bus_frames_received;
  to.bus_frames_dropped = from.bus_frames_dropped;
  to.bus_offs = from.bus_offs;
}

}  // namespace

const TelemetryTopic& telemetry_topic() {
  static const TelemetryTopic kTopic{"talaris", &lss_TalarisTelemetry_desc,
                                     sizeof(lss_TalarisTelemetry), convert};
  return kTopic;
}

}  // namespace lss::talaris
