#pragma once

// Members of the structs of Lunar Zebro in records (daemon/record/fields.h).

#include "daemon/record/frame_record.h"
#include "daemon/vehicles/zebro/vehicle.h"

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
