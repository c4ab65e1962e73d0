#pragma once

// Members of the structs of TALARIS in records (daemon/record/fields.h).

#include "daemon/record/can_fields.h"
#include "daemon/record/frame_record.h"
#include "daemon/vehicles/talaris.h"

namespace lss {

template <class V, record::Like<CanSender::Counters> X>
void fields(V& v, X& x) {
  v("sent", x.sent);
  v("closed", x.closed);
  v("full", x.full);
  v("failed", x.failed);
}

}  // namespace lss

namespace lss::talaris {

using record::Like;

template <class V, Like<ImuPacket> X>
void fields(V& v, X& x) {
  v("rate_rad_s", x.rate_rad_s);
  v("force_m_s2", x.force_m_s2);
  v("temperature_degC", x.temperature_degC);
  v("count", x.count);
  v("status", x.status);
}

template <class V, Like<ImuStatus> X>
void fields(V& v, X& x) {
  v("kind", x.kind);
  v("index", x.index);
  v("value", x.value);
  v("rate_unit_rad_s", x.rate_unit_rad_s);
  v("force_unit_m_s2", x.force_unit_m_s2);
}

template <class V, Like<Range> X>
void fields(V& v, X& x) {
  v("range_m", x.range_m);
  v("error", x.error);
}

template <class V, Like<GasState> X>
void fields(V& v, X& x) {
  v("tank_Pa", x.tank_Pa);
  v("regulated_Pa", x.regulated_Pa);
  v("voltage_V", x.voltage_V);
  v("temperature_degC", x.temperature_degC);
}

template <class V, Like<FanSpeeds> X>
void fields(V& v, X& x) {
  v("rpm", x.rpm);
}

template <class V, Like<Load> X>
void fields(V& v, X& x) {
  v("force_N", x.force_N);
  v("moment_Nm", x.moment_Nm);
}

template <class V, Like<TalarisSample> X>
void fields(V& v, X& x) {
  v("time_ns", x.time_ns);
  v("reading", x.reading);
}

template <class V, Like<ValvePulse> X>
void fields(V& v, X& x) {
  v("delay_ns", x.delay_ns);
  v("on_ns", x.on_ns);
}

template <class V, Like<ValveHold> X>
void fields(V& v, X& x) {
  v("open", x.open);
  v("until_ns", x.until_ns);
}

template <class V, Like<TalarisOrders> X>
void fields(V& v, X& x) {
  v("issued_ns", x.issued_ns);
  v("boundary_ns", x.boundary_ns);
  v("release_ns", x.release_ns);
  v("all_stop", x.all_stop);
  v("enabled", x.enabled);
  v("pulse", x.pulse);
  v("hold", x.hold);
  v("fan_us", x.fan_us);
  v("boot_allowed", x.boot_allowed);
  v("node_reset_serial", x.node_reset_serial);
  v("reset_nodes", x.reset_nodes);
}

template <class V, Like<LineCounters> X>
void fields(V& v, X& x) {
  v("bytes", x.bytes);
  v("packets", x.packets);
  v("lost", x.lost);
  v("repeated", x.repeated);
  v("parity", x.parity);
  v("bad_check", x.bad_check);
  v("skipped", x.skipped);
  v("said_errors", x.said_errors);
  v("out_of_range", x.out_of_range);
  v("commands", x.commands);
  v("restarts", x.restarts);
  v("overflows", x.overflows);
}

template <class V, Like<LineStatus> X>
void fields(V& v, X& x) {
  v("counters", x.counters);
  v("heard_ns", x.heard_ns);
  v("rate_unit_rad_s", x.rate_unit_rad_s);
  v("force_unit_m_s2", x.force_unit_m_s2);
}

template <class V, Like<LineReport> X>
void fields(V& v, X& x) {
  v("status", x.status);
  v("time_ns", x.time_ns);
  v("open", x.open);
  v("was_open", x.was_open);
}

template <class V, Like<HopperLink> X>
void fields(V& v, X& x) {
  v("node", x.node);
  v("sdo_aborts", x.sdo_aborts);
  v("sdo_repeats", x.sdo_repeats);
}

template <class V, Like<HopperCounters> X>
void fields(V& v, X& x) {
  v("master", x.master);
  v("releases", x.releases);
  v("safe_commands", x.safe_commands);
  v("stale_orders", x.stale_orders);
  v("bad_orders", x.bad_orders);
  v("load_unpaired", x.load_unpaired);
  v("overflows", x.overflows);
}

template <class V, Like<HopperStatus> X>
void fields(V& v, X& x) {
  v("link", x.link);
  v("counters", x.counters);
}

template <class V, Like<ValveCounters> X>
void fields(V& v, X& x) {
  v("frames", x.frames);
  v("edges", x.edges);
  v("failed", x.failed);
  v("stale", x.stale);
  v("all_stops", x.all_stops);
  v("restarts", x.restarts);
  v("worst_late_ns", x.worst_late_ns);
  v("pulses", x.pulses);
  v("open_ns", x.open_ns);
}

template <class V, Like<EdgeReport> X>
void fields(V& v, X& x) {
  v("counters", x.counters);
  v("sender", x.sender);
  v("opened_ns", x.opened_ns);
  v("shut_ns", x.shut_ns);
  v("last_ns", x.last_ns);
  v("last_late_ns", x.last_late_ns);
  v("open", x.open);
  v("all_stop_pending", x.all_stop_pending);
  v("refused_orders", x.refused_orders);
}

template <class V, Like<ModuleTelemetry> X>
void fields(V& v, X& x) {
  v("id", x.id);
  v("online", x.online);
  v("link", x.link);
  v("age_ms", x.age_ms);
  v("samples", x.samples);
  v("errors", x.errors);
  v("lost", x.lost);
}

template <class V, Like<ValveTelemetry> X>
void fields(V& v, X& x) {
  v("id", x.id);
  v("enabled", x.enabled);
  v("open", x.open);
  v("on_s", x.on_s);
  v("delay_s", x.delay_s);
  v("fired_s", x.fired_s);
  v("pulses", x.pulses);
}

template <class V, Like<FanTelemetry> X>
void fields(V& v, X& x) {
  v("id", x.id);
  v("armed", x.armed);
  v("throttle", x.throttle);
  v("target_rpm", x.target_rpm);
  v("rpm", x.rpm);
}

template <class V, Like<Telemetry> X>
void fields(V& v, X& x) {
  v("time_ns", x.time_ns);
  v("frame", x.frame);
  v("state", x.state);
  v("mode", x.mode);
  v("phase", x.phase);
  v("program", x.program);
  v("gains", x.gains);
  v("calibrated", x.calibrated);
  v("planned", x.planned);
  v("airborne", x.airborne);
  v("calibrated_share", x.calibrated_share);
  v("phase_s", x.phase_s);
  v("remaining_s", x.remaining_s);
  v("position_m", x.position_m);
  v("velocity_m_s", x.velocity_m_s);
  v("attitude_wxyz", x.attitude_wxyz);
  v("rate_rad_s", x.rate_rad_s);
  v("acceleration_m_s2", x.acceleration_m_s2);
  v("position_sigma_m", x.position_sigma_m);
  v("attitude_sigma_rad", x.attitude_sigma_rad);
  v("gyro_bias_rad_s", x.gyro_bias_rad_s);
  v("accelerometer_bias_m_s2", x.accelerometer_bias_m_s2);
  v("innovation_m", x.innovation_m);
  v("ranges_used", x.ranges_used);
  v("ranges_gated", x.ranges_gated);
  v("target_position_m", x.target_position_m);
  v("target_velocity_m_s", x.target_velocity_m_s);
  v("thrust_N", x.thrust_N);
  v("attitude_error_rad", x.attitude_error_rad);
  v("range_m", x.range_m);
  v("pressure_Pa", x.pressure_Pa);
  v("gas_thruster_s", x.gas_thruster_s);
  v("gas_left_thruster_s", x.gas_left_thruster_s);
  v("voltage_V", x.voltage_V);
  v("temperature_degC", x.temperature_degC);
  v("load_N", x.load_N);
  v("load_Nm", x.load_Nm);
  v("valves", x.valves);
  v("fans", x.fans);
  v("modules", x.modules);
  v("script_id", x.script_id);
  v("script_steps", x.script_steps);
  v("script_done", x.script_done);
  v("script_s", x.script_s);
  v("edges", x.edges);
  v("edge_worst_s", x.edge_worst_s);
  v("imu_port_open", x.imu_port_open);
  v("altimeter_port_open", x.altimeter_port_open);
  v("can_port_open", x.can_port_open);
  v("bus_frames_sent", x.bus_frames_sent);
  v("bus_frames_received", x.bus_frames_received);
  v("bus_frames_dropped", x.bus_frames_dropped);
  v("bus_offs", x.bus_offs);
}

}  // namespace lss::talaris

namespace lss {

template <class V, record::Like<talaris::HopperCan::Report> X>
void fields(V& v, X& x) {
  v("status", x.status);
  v("port", x.port);
  v("state", x.state);
  v("time_ns", x.time_ns);
  v("open", x.open);
  v("was_open", x.was_open);
}

}  // namespace lss

namespace lss::talaris {

template <class V, Like<BusReport> X>
void fields(V& v, X& x) {
  v("imu", x.imu);
  v("altimeter", x.altimeter);
  v("can", x.can);
  v("edges", x.edges);
}

}  // namespace lss::talaris
