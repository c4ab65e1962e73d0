#pragma once

// Members of the structs of Lunar Zebro in records (daemon/record/fields.h).

#include "daemon/record/frame_record.h"
#include "daemon/vehicles/zebro.h"

namespace lss::zebro {

using record::Like;

template <class V, Like<ModuleReply> X>
void fields(V& v, X& x) {
  v("time_ns", x.time_ns);
  v("module", x.module);
  v("code", x.code);
  v("data", x.data);
}

template <class V, Like<ModuleLink> X>
void fields(V& v, X& x) {
  v("requests", x.requests);
  v("replies", x.replies);
  v("resends", x.resends);
  v("resets", x.resets);
  v("disobeys", x.disobeys);
}

template <class V, Like<BusCounters> X>
void fields(V& v, X& x) {
  v("cycles", x.cycles);
  v("frames_sent", x.frames_sent);
  v("frames_received", x.frames_received);
  v("frames_dropped", x.frames_dropped);
  v("bad_start", x.bad_start);
  v("bad_length", x.bad_length);
  v("bad_character", x.bad_character);
  v("bad_check", x.bad_check);
  v("unexpected", x.unexpected);
  v("overflows", x.overflows);
  v("safe_commands", x.safe_commands);
  v("cycle_ns", x.cycle_ns);
  v("module", x.module);
}

template <class V, Like<ModuleOrder> X>
void fields(V& v, X& x) {
  v("kind", x.kind);
  v("position_cdeg", x.position_cdeg);
  v("arrive_ns", x.arrive_ns);
  v("serial", x.serial);
}

template <class V, Like<BusOrders> X>
void fields(V& v, X& x) {
  v("issued_ns", x.issued_ns);
  v("emergency_serial", x.emergency_serial);
  v("module", x.module);
}

template <class V, Like<ModuleTelemetry> X>
void fields(V& v, X& x) {
  v("id", x.id);
  v("address", x.address);
  v("online", x.online);
  v("calibrated", x.calibrated);
  v("motion_control", x.motion_control);
  v("moving", x.moving);
  v("swing", x.swing);
  v("isolated", x.isolated);
  v("flags", x.flags);
  v("position_rad", x.position_rad);
  v("velocity_rad_s", x.velocity_rad_s);
  v("set_point_rad", x.set_point_rad);
  v("time_left_s", x.time_left_s);
  v("current_A", x.current_A);
  v("temperature_degC", x.temperature_degC);
  v("supply_V", x.supply_V);
  v("uptime_s", x.uptime_s);
  v("firmware_major", x.firmware_major);
  v("firmware_minor", x.firmware_minor);
  v("reset_cause", x.reset_cause);
  v("dropped_frames", x.dropped_frames);
  v("age_ms", x.age_ms);
  v("replies", x.replies);
  v("resends", x.resends);
}

template <class V, Like<Telemetry> X>
void fields(V& v, X& x) {
  v("time_ns", x.time_ns);
  v("frame", x.frame);
  v("state", x.state);
  v("mode", x.mode);
  v("speed", x.speed);
  v("heading_rad", x.heading_rad);
  v("direction", x.direction);
  v("distance_m", x.distance_m);
  v("yaw_rad", x.yaw_rad);
  v("speed_m_s", x.speed_m_s);
  v("steps", x.steps);
  v("modules", x.modules);
  v("bus_frames_sent", x.bus_frames_sent);
  v("bus_frames_received", x.bus_frames_received);
  v("bus_frames_dropped", x.bus_frames_dropped);
  v("bus_overflows", x.bus_overflows);
  v("bus_cycle_ns", x.bus_cycle_ns);
  v("port_open", x.port_open);
}

}  // namespace lss::zebro

namespace lss {

template <class V, record::Like<zebro::LegSerialBus::Report> X>
void fields(V& v, X& x) {
  v("counters", x.counters);
  v("time_ns", x.time_ns);
  v("open", x.open);
  v("was_open", x.was_open);
  v("all_stop_pending", x.all_stop_pending);
}

}  // namespace lss
