#pragma once

// A rigid body of six degrees of freedom with the valves, fans, ground and stands of TALARIS, and a
// navigation that knows the truth but for noise and drift: enough to fly gnc/talaris in a loop, at
// some thousand times real time. Written from the equations alone; shares nothing with the
// simulator.

#include <cstdint>
#include <random>

#include "gnc/talaris/flight.h"

namespace lss::gnc::talaris::test {

enum class Stand { free, rails, sled, attitude_y, attitude_z, altitude, height };

struct World {
  Stand stand = Stand::free;
  unsigned seed = 1;
  double mass_kg = 45;
  Vector3 inertia_kg_m2 = {4.5, 3.0, 1.8};
  std::array<double, kValves> force_N = {58, 58, 58, 58, 58, 58, 58, 58};
  double valve_lag_s = 0.008;
  double fan_lag_s = 0.25;
  double fan_scale = 1;  // thrust, relative to the model
  std::array<double, kFans> fan_speed = {1, 1, 1,
                                         1};  // rpm at full throttle, relative to the model
  Vector3 moment_N_m = {0, 0.3, -0.2};        // while it flies: offset of the CM
  double noise = 1;                           // of navigation
  Vector3 drift_m_s2 = Vector3::Zero();       // of navigation's speed, horizontal
  double sled_friction_N_s_m = 1.0;
};

// The result of a flight.
struct Log {
  double max_tilt_rad = 0, max_roll_error_rad = 0;  // in the air, before contact
  double settled_tilt_rad = 0;                      // the same from 4 s after the phase began on
  double max_height_m = 0;
  double max_height_error_m = 0, height_square = 0;  // hover, traverse, brake: of the target
  int height_frames = 0;
  double landing_speed_m_s = 0, landing_tilt_rad = 0, landing_drift_m_s = 0;
  bool landed = false;  // touched the ground after it had left it
  double rms_height_m() const;
};

class Hopper {
 public:
  Hopper(const World& world, const Parameters& parameters);

  void frame();              // 200 ms
  bool run(double seconds);  // until finished or that long; true: finished
  // plan, execute, run; false: not feasible or not finished
  bool fly(const PlanRequest& request, double seconds = 60);
  void count(const FlightOutput& out);

  // truth
  Vector3 position = Vector3::Zero(), velocity = Vector3::Zero(), rate_B = Vector3::Zero();
  Quaternion q_NB = Quaternion::Identity();
  std::array<double, kFans> rpm{};
  double time_s = 0;
  double tilt() const;

  // faults
  bool valves_dead = false, fans_silent = false, fans_dead = false, imu_silent = false,
       range_silent = false, pressure_gone = false;
  double regulated_kPa = 2500;
  FaultSet told = 0;

  World world;
  Parameters parameters;
  Flight flight;
  FlightInputs inputs;  // of the last frame
  FlightOutput out;
  Log log;

 private:
  void sense();
  void physics(double dt);
  double normal(double sigma);

  struct Window {
    double from = -1, to = -1;
  };
  std::array<Window, kValves> window_{}, next_{};
  std::array<double, kFans> throttle_{};
  Actuation pending_;
  double release_s_ = 0, gas_s_ = 0;
  Vector3 velocity_before_ = Vector3::Zero(), drift_v_ = Vector3::Zero(),
          drift_p_ = Vector3::Zero();
  Vector3 tilt_offset_ = Vector3::Zero();
  double rest_x_ = 0, valve_age_ = 0, fan_age_ = 0, imu_age_ = 0, range_age_ = 0;
  bool was_up_ = false;
  std::mt19937 random_;
};

}  // namespace lss::gnc::talaris::test
