#pragma once

// Reject reasons, faults and events of D.I.A.N.A. Ardito itself (idl/codes.h). Pure data.

#include "idl/codes.h"

// number, name, text, advice
#define LSS_ARDITO_REASONS(X)                                                                      \
  X(33, over_limit, "faster than the limit selected at start",                                     \
    "drive slower, or stop and start with another --limit")                                        \
  X(35, button_pressed, "the emergency-stop button is pressed", "release it, then: lss-cli solve") \
  X(36, power_bad, "the motors have no power", "check the battery, then: lss-cli solve")           \
  X(37, too_few_wheels, "another wheel is out of service already", "repair and restore it first")  \
  X(90, stuck, "the wheels turn and, by the IMU, the rover does not move",                         \
    "drive back, or another way; lss-cli status shows the slip")                                   \
  X(91, over_cap, "faster than the configuration allows this vehicle",                             \
    "drive slower; the cap is safety.max_speed_m_s of the config")                                 \
  X(93, over_heading, "heading beyond the limit of the parameters: rad",                           \
    "steer less, or at rest: lss-cli param set mobility.heading_limit_deg DEGREES")

// number, name, severity (of lss.idl: 0 info, 1 warning, 2 error, 3 fatal), text, advice
#define LSS_ARDITO_FAULTS(X)                                                                     \
  X(21, wheel_sensor, 1, "a speed sensor of the wheel failed and is substituted",                \
    "driving goes on; check it, then in Idle: lss-cli reset NODE")                               \
  X(22, wheel_motor, 1, "the wheel's motor failed: its clutch is open",                          \
    "driving goes on with five wheels; check it, then in Idle: lss-cli reset NODE")              \
  X(23, wheel_gear, 1, "the wheel's gear failed: its motor is stopped",                          \
    "driving goes on with five wheels; check it, then in Idle: lss-cli reset NODE")              \
  X(24, wheel_clutch, 1, "the wheel's clutch slips or is open: its motor is stopped",            \
    "driving goes on with five wheels; check it, then in Idle: lss-cli reset NODE")              \
  X(25, wheel_critical, 3, "several parts of the wheel failed", "check it, then: lss-cli solve") \
  X(26, steering_sensor, 1, "a position sensor of the steering failed and is substituted",       \
    "driving goes on; check it, then in Idle: lss-cli reset NODE")                               \
  X(27, steering_critical, 3, "the steering does not follow", "check it, then: lss-cli solve")   \
  X(28, mobility_error, 3, "the failure detection cannot keep the rover driving",                \
    "see which wheels failed: lss-cli status; then: lss-cli solve")                              \
  X(29, imu_lost, 1, "the IMU is silent or implausible: no correction, no autonomous driving",   \
    "check it; driving by hand goes on")                                                         \
  X(30, rocker_lost, 1, "a rocker or bogie angle is stale or implausible: no correction",        \
    "check the I/O node; driving goes on")                                                       \
  X(32, emergency_button, 3, "the emergency-stop button was pressed",                            \
    "release it, then: lss-cli solve")                                                           \
  X(33, power_lost, 3, "the motors lost their power", "check the battery, then: lss-cli solve")  \
  X(39, instance_disagreed, 1,                                                                   \
    "an instance of the mobility controller was out-voted and set to the others' state",         \
    "memory may be failing: watch whether it comes again")                                       \
  X(40, no_majority, 3, "the instances of the mobility controller all disagree",                 \
    "restart the daemon")                                                                        \
  X(70, rover_stuck, 2, "the wheels turn and, by the IMU, the rover does not move: it stopped",  \
    "drive back, or another way; if it did move, check the IMU's speed")                         \
  X(72, yaw_disagrees, 1, "the rover turns otherwise than its steering says",                    \
    "check the steering's brackets and the IMU's yaw rate")                                      \
  X(73, wheel_unproven, 1, "a part of the wheel failed and has not worked since",                \
    "drive to see whether it works; after a repair: lss-cli reset NODE")

// number, name, severity, text ({0}..{3}: arguments)
#define LSS_ARDITO_EVENTS(X)                                                    \
  X(31, autonomy_ended, 1, "back to manual driving: the IMU is lost")           \
  X(71, slip_begun, 1, "the wheels go {0} m/s faster than the rover, load {1}") \
  X(72, slip_ended, 0, "the wheels no longer slip, {0} m/s at most")            \
  X(73, stopped_stuck, 2, "stopped: the wheels turn with {0} m/s, the rover goes {1} m/s")

namespace lss::ardito {
LSS_OWN_CODES(LSS_ARDITO_REASONS, LSS_ARDITO_FAULTS, LSS_ARDITO_EVENTS)
}  // namespace lss::ardito
