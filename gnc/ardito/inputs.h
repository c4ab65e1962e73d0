#pragma once

// Validity of one frame's measurements: old values, values that are not numbers, and failed sensors
// are not usable from here on. Pure functions of the frame thread.

#include "gnc/ardito/ackermann.h"
#include "gnc/ardito/state.h"

namespace lss::gnc::ardito {

struct WheelInputs {
  WheelSensors sensors;
  Sensor current;
  Sensor temperature_C;
  Ordered ordered;
  Sensor load;  // current above that of no load at this speed, positive when the motor works
  bool drive_fault = false;
  bool stale = false;
};

struct SteeringInputs {
  Sensor motor;
  Sensor reduction;
  Sensor current;
  Ordered ordered;
  bool drive_fault = false;
  bool stale = false;
};

struct ImuInputs {
  Sensor speed_m_s;
  Sensor sigma_rad;
  Sensor yaw_rate_rad_s;
  bool usable = false;  // all of them
  bool silent = false;
  bool implausible = false;
};

struct Inputs {
  PerWheel<WheelInputs> wheels;
  PerSteered<SteeringInputs> steering;
  ImuInputs imu;
  bool rocker = false;  // vx, vz can be used
  bool rocker_stale = false;
  bool rocker_jumped = false;  // in this frame, or a short while ago; `rocker` is false, too, while
                               // RockerWatch::off
  PerWheel<double> vx_m_s{};   // of the hubs against the chassis
  PerWheel<double> vz_m_s{};
};

// WheelInputs::load, from the other members (part VII).
Sensor load_current(const WheelInputs& inputs, const Parameters& parameters) noexcept;

// Stores poses and IMU for the next frame.
Inputs read_inputs(const Measured& measured, const Parameters& parameters, const Linkage& linkage,
                   State& state) noexcept;

// Finite and within the limits, for any request.
Request sane(const Request& request, const Parameters& parameters) noexcept;

// The feedback that control and estimate use (17.2, comparator_feed).
struct Feedback {
  PerWheel<double> wheel_rad_s{};
  PerWheel<double> steering_rad{};  // of all wheels, 0 for the middle ones
  PerWheel<Direction> steering;     // the same
};
Feedback choose_feedback(const Inputs& inputs, const Parameters& parameters, bool correction,
                         const State& state) noexcept;

// Speed of a wheel on this ground for a speed of its hub in the plane: from Ackermann to 3-D
// (18.2.1).
double wheel_speed_rad_s(std::size_t wheel, double hub_m_s, const Direction& steering,
                         const Inputs& inputs, bool correction,
                         const Parameters& parameters) noexcept;
inline PlaneMotion estimated_motion(const State& state) noexcept {
  return {{state.direction_sin, state.direction_cos}, state.v_m_s};
}

}  // namespace lss::gnc::ardito
