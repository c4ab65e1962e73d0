#pragma once

// Reject reasons, faults and events of TALARIS itself (idl/codes.h). Pure data.

#include "idl/codes.h"

// number, name, text, advice
#define LSS_TALARIS_REASONS(X)                                                                     \
  X(40, not_calibrated, "the navigation is not calibrated",                                        \
    "lss-cli gnc standby, then lss-cli gnc calibrate, standing still")                             \
  X(41, not_planned, "nothing is planned", "lss-cli plan PROGRAM")                                 \
  X(42, gas_short,                                                                                 \
    "the gas does not suffice: thruster-seconds needed, and available above the reserve",          \
    "refill, or plan less")                                                                        \
  X(43, plan_request, "no program can be flown with these numbers",                                \
    "see: lss-cli command describe plan")                                                          \
  X(44, plan_height, "too low to fly: m", "plan higher")                                           \
  X(45, hover_short, "no pulse holds it up: s open in a frame needed, and the longest",            \
    "make it lighter, or the thrusters stronger")                                                  \
  X(46, climb_short, "climbing takes more than the thrust leaves: m/s2", "plan lower")             \
  X(47, lateral_short, "the traverse takes more than the lateral thrusters leave: m/s2",           \
    "give it more time, or plan it shorter")                                                       \
  X(48, altimeter_short, "outside the range of the altimeter: m", "plan lower or shorter")         \
  X(49, wall_near, "the wall is too near: m to go, and to the wall without clearance",             \
    "plan it shorter, or move back")                                                               \
  X(50, fans_short, "the fans are too weak: N needed of all, and what they have",                  \
    "make it lighter")                                                                             \
  X(51, fans_long, "the fans would run for too long: s", "plan it shorter")                        \
  X(52, fans_not_armed, "the fans' speed controllers are not started", "lss-cli edf arm")          \
  X(53, valve_disabled, "a valve that is needed is disabled", "lss-cli enable all")                \
  X(54, pulse_too_long, "delay and on-time do not fit into the frame: s, and the frame",           \
    "shorten one of them")                                                                         \
  X(85, pause_too_short, "a valve would open again too soon: s shut, and the least",               \
    "make the pulses shorter, or as long as the frame")                                            \
  X(60, script_incomplete, "the script is not there as a whole: steps there, and announced",       \
    "send it with: lss-cli script run FILE")                                                       \
  X(63, moved, "it moved while it was calibrated", "let it stand still, then calibrate again")     \
  X(64, in_flight, "it is in the air", "lss-cli land")                                             \
  X(66, altimeter_lost, "the altimeter is silent, or has errors only",                             \
    "check its line and what it looks at")                                                         \
  X(67, no_such_gains, "there is no such set of gains: the one asked for, and how many there are", \
    "add it to the config")                                                                        \
  X(68, pressure_low, "the pressure is too low: kPa", "open the bottle, or refill it")             \
  X(69, voltage_low, "the supply is too low: V", "charge or exchange the battery")                 \
  X(70, flight_failed, "the flight did not go as planned",                                         \
    "see the events before it and: lss-cli status")                                                \
  X(71, calibration_bad, "the measurements at standstill are implausible",                         \
    "level it, check IMU and altimeter; the event says what was found")                            \
  X(80, off_target, "it may stand too far from the target: m, by navigation with 3 sigma",         \
    "see where it stands; a smaller distance or a better sensor set keeps it nearer")              \
  X(81, fell_over, "it does not stand upright: rad", "set it up; see the events before it")        \
  X(82, landed_hard, "it touched down too fast: m/s", "inspect the legs")                          \
  X(83, landed_sideways, "it moved sideways at touchdown: m/s", "inspect the legs")                \
  X(84, no_lift_off, "it stood still when it should fly", "weigh it; check fans, thrust and gains")

// number, name, severity (of lss.idl: 0 info, 1 warning, 2 error, 3 fatal), text, advice
#define LSS_TALARIS_FAULTS(X)                                                                  \
  X(41, imu_silent, 1, "no packets of the IMU come",                                           \
    "check its power and line; then calibrate again")                                          \
  X(42, imu_stuck, 1, "the IMU repeats its values, or they are implausible",                   \
    "check it, then calibrate again")                                                          \
  X(43, imu_lossy, 1, "packets of the IMU are lost", "check its line")                         \
  X(44, altimeter_lost, 1, "the altimeter is silent, has errors only, or is out of range",     \
    "check its line and what it looks at")                                                     \
  X(45, navigation_lost, 3, "the IMU was lost in flight",                                      \
    "check the IMU, then: lss-cli solve, and calibrate again")                                 \
  X(46, altitude_lost, 3, "the altimeter was lost in flight", "check it, then: lss-cli solve") \
  X(47, gas_low, 3, "less gas than the remaining flight needs", "refill, then: lss-cli solve") \
  X(48, pressure_lost, 3, "the regulated pressure was gone in flight",                         \
    "check bottle, regulator and lines, then: lss-cli solve")                                  \
  X(49, attitude_lost, 3, "tilt or rates above their limits",                                  \
    "look at vehicle and gains, then: lss-cli solve")                                          \
  X(51, load_cell_lost, 1, "the load cell does not answer", "check the node and the bus")      \
  X(52, supply_low, 1, "the supply is low", "charge or exchange the battery")                  \
  X(53, fan_slow, 3, "the fans do not come to their speed",                                    \
    "check fans, speed controllers and battery, then: lss-cli solve")                          \
  X(54, fans_hot, 3, "the fans ran for too long", "let them cool, then: lss-cli solve")        \
  X(56, corridor_left, 2, "the flight left its corridor and came down",                        \
    "the event before it says by how much; wait for less wind, see docs/gnc-talaris.md")       \
  X(57, hop_shortened, 2, "gas did not last for the rest of the plan: it came down earlier",   \
    "refill, or plan less")                                                                    \
  X(58, altimeter_stuck, 1, "the altimeter repeats one reading in the air",                    \
    "check it and what it looks at")                                                           \
  X(65, valve_stuck_open, 3, "the valve gives thrust without an order (N, ordered)",           \
    "shut the bottle; change the valve, then: lss-cli solve")                                  \
  X(66, valve_stuck_shut, 3, "the valve gives no thrust (N, ordered)",                         \
    "check its wiring and the valve, then: lss-cli solve")                                     \
  X(67, fan_dead, 3, "the fan is too slow for its order (rpm, at least)",                      \
    "check its motor and speed controller, then: lss-cli solve")                               \
  X(68, fan_without_thrust, 3, "the fan turns without its thrust (N, of its speed)",           \
    "check its blades and duct, then: lss-cli solve")

// number, name, severity, text ({0}..{3}: arguments)
#define LSS_TALARIS_EVENTS(X)                                                           \
  X(32, calibrated, 0, "navigation is calibrated")                                      \
  X(36, lifted_off, 0, "in the air")                                                    \
  X(37, landed, 0, "landed with {0} m/s, {1} thruster-seconds used")                    \
  X(39, script_begun, 0, "script {0} runs: {1} steps, the first in {2} s")              \
  X(40, script_step_done, 0, "script {0}: step {1} of {2}")                             \
  X(41, script_ended, 0, "script {0} ended")                                            \
  X(42, script_aborted, 2, "script {0} aborted after {1} of {2} steps: all-stop")       \
  X(43, imu_scale_changed, 1, "the IMU changed its scale: status {0} to {1}")           \
  X(44, imu_packets_lost, 1, "{0} packets of the IMU lost, {1} in all")                 \
  X(45, gains_selected, 0, "set of gains {0}")                                          \
  X(46, fans_armed, 0, "the fans' speed controllers are started")                       \
  X(47, valve_timed_out, 1, "valves {0} shut after their time")                         \
  X(48, altimeter_error, 1, "altimeter reports error {0}, {1} in all")                  \
  X(59, flight_judged, 0, "{0} m off target (1 sigma {1}); {2} m/s down, {3} sideways") \
  X(60, off_course, 1, "off the plan, kind {0}: {1}, allowed {2}")

namespace lss::talaris {
LSS_OWN_CODES(LSS_TALARIS_REASONS, LSS_TALARIS_FAULTS, LSS_TALARIS_EVENTS)
}  // namespace lss::talaris
