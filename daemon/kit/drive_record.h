#pragma once

// Members of the structs of daemon/kit/drive_vehicle.h in records (daemon/record/fields.h).
// Included by the vehicle's source, before its records are made.

#include "daemon/kit/drive_vehicle.h"
#include "daemon/record/can_fields.h"
#include "daemon/record/frame_record.h"

namespace lss::canopen {

using record::Like;

template <class V, Like<DriveLink> X>
void fields(V& v, X& x) {
  v("node", x.node);
  v("drive", x.drive);
  v("statusword", x.statusword);
  v("disobeys", x.disobeys);
  v("dropouts", x.dropouts);
  v("sdo_aborts", x.sdo_aborts);
  v("sdo_repeats", x.sdo_repeats);
}

template <class V, Like<VelocityStatus> X>
void fields(V& v, X& x) {
  v("link", x.link);
  v("counters", x.counters);
}

template <class V, Like<VelocitySample> X>
void fields(V& v, X& x) {
  v("time_ns", x.time_ns);
  v("drive", x.drive);
  v("statusword", x.statusword);
  v("motor_rpm", x.motor_rpm);
  v("current_permille", x.current_permille);
}

template <class V, Like<VelocityOrder> X>
void fields(V& v, X& x) {
  v("enabled", x.enabled);
  v("motor_rpm", x.motor_rpm);
}

template <class V, Like<VelocityOrders> X>
void fields(V& v, X& x) {
  bus_orders(v, x);
  v("drive", x.drive);
}

}  // namespace lss::canopen

namespace lss {

template <class V, record::Like<kit::DriveCanBus::Report> X>
void fields(V& v, X& x) {
  can_report(v, x);
}

}  // namespace lss
