#pragma once

// Members of the structs of TALARIS in records (daemon/record/fields.h).

#include "daemon/record/can_fields.h"
#include "daemon/record/frame_record.h"
#include "daemon/vehicles/talaris/vehicle.h"

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
