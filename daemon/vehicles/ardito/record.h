#pragma once

// Members of the structs of D.I.A.N.A. Ardito in records (daemon/record/fields.h).

#include "daemon/record/can_fields.h"
#include "daemon/record/frame_record.h"
#include "daemon/vehicles/ardito/vehicle.h"

namespace lss::ardito {

using record::Like;

template <class V, Like<WheelMotion> X>
void fields(V& v, X& x) {
  v("wheel", x.wheel);
  v("statusword", x.statusword);
  v("motor_rpm", x.motor_rpm);
  v("current_permille", x.current_permille);
}

template <class V, Like<WheelSpeeds> X>
void fields(V& v, X& x) {
  v("wheel", x.wheel);
  v("hall_rpm", x.hall_rpm);
  v("reduction_rpm", x.reduction_rpm);
}

template <class V, Like<WheelHealth> X>
void fields(V& v, X& x) {
  v("wheel", x.wheel);
  v("temperature_degC", x.temperature_degC);
  v("link_V", x.link_V);
}

template <class V, Like<SteeringMotion> X>
void fields(V& v, X& x) {
  v("wheel", x.wheel);
  v("statusword", x.statusword);
  v("motor_rad", x.motor_rad);
  v("current_permille", x.current_permille);
}

template <class V, Like<SteeringAngle> X>
void fields(V& v, X& x) {
  v("wheel", x.wheel);
  v("reduction_rad", x.reduction_rad);
}

template <class V, Like<ardito::Inputs> X>
void fields(V& v, X& x) {
  v("emergency_button", x.emergency_button);
  v("power_good", x.power_good);
}

template <class V, Like<Rocker> X>
void fields(V& v, X& x) {
  v("beta_rad", x.beta_rad);
  v("rho1_rad", x.rho1_rad);
  v("rho2_rad", x.rho2_rad);
}

template <class V, Like<Imu> X>
void fields(V& v, X& x) {
  v("Vtan_mm_s", x.Vtan_mm_s);
  v("sigma_rad", x.sigma_rad);
  v("yaw_rate_rad_s", x.yaw_rate_rad_s);
  v("counter", x.counter);
}

template <class V, Like<RoverSample> X>
void fields(V& v, X& x) {
  v("time_ns", x.time_ns);
  v("reading", x.reading);
}

template <class V, Like<RoverLink> X>
void fields(V& v, X& x) {
  v("node", x.node);
  v("drive", x.drive);
  v("statusword", x.statusword);
  v("disobeys", x.disobeys);
  v("dropouts", x.dropouts);
  v("set_points", x.set_points);
  v("set_points_refused", x.set_points_refused);
  v("sdo_aborts", x.sdo_aborts);
  v("sdo_repeats", x.sdo_repeats);
}

template <class V, Like<RoverStatus> X>
void fields(V& v, X& x) {
  v("link", x.link);
  v("counters", x.counters);
}

template <class V, Like<WheelOrder> X>
void fields(V& v, X& x) {
  v("enabled", x.enabled);
  v("motor_rpm", x.motor_rpm);
}

template <class V, Like<SteeringOrder> X>
void fields(V& v, X& x) {
  v("enabled", x.enabled);
  v("position_rad", x.position_rad);
}

template <class V, Like<RoverOrders> X>
void fields(V& v, X& x) {
  canopen::bus_orders(v, x);
  v("wheel", x.wheel);
  v("steering", x.steering);
  v("clutches", x.clutches);
  v("beacon", x.beacon);
}

}  // namespace lss::ardito

namespace lss {

template <class V, record::Like<ardito::RoverCanBus::Report> X>
void fields(V& v, X& x) {
  can_report(v, x);
}

}  // namespace lss
