#pragma once

// Members of the structs of CAN buses and CANopen masters in records (daemon/record/fields.h).

#include "daemon/record/fields.h"
#include "drivers/can/transport.h"
#include "drivers/canopen/drive_bus.h"

namespace lss {

template <class V, record::Like<CannelloniCounters> X>
void fields(V& v, X& x) {
  v("datagrams", x.datagrams);
  v("frames", x.frames);
  v("bad_header", x.bad_header);
  v("truncated", x.truncated);
  v("trailing", x.trailing);
  v("bad_frame", x.bad_frame);
  v("can_fd", x.can_fd);
}

template <class V, record::Like<CanCounters> X>
void fields(V& v, X& x) {
  v("received", x.received);
  v("filtered", x.filtered);
  v("overflows", x.overflows);
  v("sent", x.sent);
  v("retries", x.retries);
  v("dropped_full", x.dropped_full);
  v("dropped_stale", x.dropped_stale);
  v("send_errors", x.send_errors);
  v("error_frames", x.error_frames);
  v("error_passive", x.error_passive);
  v("bus_offs", x.bus_offs);
  v("restarts", x.restarts);
  v("foreign", x.foreign);
  v("cannelloni", x.cannelloni);
}

// Of daemon/runtime/can_bus.h, whatever its status.
template <class V, class Report>
void can_report(V& v, Report& x) {
  v("status", x.status);
  v("port", x.port);
  v("state", x.state);
  v("time_ns", x.time_ns);
  v("open", x.open);
  v("was_open", x.was_open);
  v("all_stop_pending", x.all_stop_pending);
}

}  // namespace lss

namespace lss::canopen {

using record::Like;

template <class V, Like<Entry> X>
void fields(V& v, X& x) {
  v("index", x.index);
  v("sub", x.sub);
  v("size", x.size);
  v("value", x.value);
  v("optional", x.optional);
}

template <class V, Like<NodeStatus> X>
void fields(V& v, X& x) {
  v("state", x.state);
  v("nmt", x.nmt);
  v("since_ns", x.since_ns);
  v("heartbeat_ns", x.heartbeat_ns);
  v("found_type", x.found_type);
  v("failed_entry", x.failed_entry);
  v("abort_code", x.abort_code);
  v("emcy_code", x.emcy_code);
  v("emcy_register", x.emcy_register);
  v("emcy_ns", x.emcy_ns);
  v("emcy_storm", x.emcy_storm);
  v("emcys", x.emcys);
  v("frames", x.frames);
  v("boots", x.boots);
  v("reboots", x.reboots);
  v("losses", x.losses);
  v("fall_backs", x.fall_backs);
  v("wrong_lengths", x.wrong_lengths);
  v("babbles", x.babbles);
  v("ignored", x.ignored);
}

template <class V, Like<MasterCounters> X>
void fields(V& v, X& x) {
  v("frames_received", x.frames_received);
  v("frames_sent", x.frames_sent);
  v("syncs", x.syncs);
  v("syncs_skipped", x.syncs_skipped);
  v("unknown_nodes", x.unknown_nodes);
  v("unknown_frames", x.unknown_frames);
  v("other_masters", x.other_masters);
  v("overflows", x.overflows);
}

template <class V, Like<DriveBusCounters> X>
void fields(V& v, X& x) {
  v("master", x.master);
  v("releases", x.releases);
  v("safe_commands", x.safe_commands);
  v("stale_orders", x.stale_orders);
  v("old_orders", x.old_orders);
  v("bad_orders", x.bad_orders);
  v("overflows", x.overflows);
}

// The common part of orders.
template <class V, class Orders>
void bus_orders(V& v, Orders& x) {
  v("issued_ns", x.issued_ns);
  v("serial", x.serial);
  v("emergency_serial", x.emergency_serial);
  v("fault_reset_serial", x.fault_reset_serial);
  v("node_reset_serial", x.node_reset_serial);
  v("reset_nodes", x.reset_nodes);
  v("next_frame_ns", x.next_frame_ns);
  v("quick_stop", x.quick_stop);
  v("standing", x.standing);
}

}  // namespace lss::canopen
