#pragma once

// Height and attitude by the fans alone (TALARIS thesis 5.2.3: altitude hop, "parachute mode").
//
// Four fans that push along +x at the corners give lift, pitch and yaw by differences. They give no
// roll: their cants cancel, and nothing else would turn the vehicle about its vertical; its roll is
// whatever it was. A fan follows with a lag of a quarter of a second, longer than a frame. So the
// lag is part of the state: moment (from the measured speeds), rate, angle and the integral of the
// angle are fed back with gains that put the poles of the sampled loop, ZOH and lag included, where
// the parameters say.

#include <Eigen/Core>

#include "gnc/talaris/fans.h"
#include "gnc/talaris/parameters.h"

namespace lss::gnc::talaris {

// Gains of u = -k x for integral of the angle, angle, rate, acceleration (rad s, rad, rad/s,
// rad/s2), u: acceleration that the command shall settle at. All four poles at -pole, frame 200 ms.
Eigen::Vector4d fan_attitude_gains(double lag_s, double pole_rad_s) noexcept;

struct FanHeight {
  double height_m = 0;   // measured
  double speed_m_s = 0;  // up
  double bias_m_s2 = 0;  // acceleration that fans and mass do not explain
};

class FanFlight {
 public:
  FanFlight(const Parameters& parameters, const Gains& gains) noexcept;

  // Forgets integrals. On the ground the lift is raised from what lifts no vehicle until this one
  // leaves it: a vehicle light for its fans jumps otherwise, a heavy one never leaves.
  void begin(bool on_ground = false) noexcept;
  void set_gains(const Gains& gains) noexcept;

  // Speeds for one frame. Height control: PID towards `target_height_m` moving with
  // `target_speed_m_s`, limited; `tilt_y/z_rad` actual minus wanted, `rate` in B; NaN in any of
  // those: no attitude is known, all fans alike but for what is known to turn the vehicle
  // (`disturbance`, rad/s2).
  PerFan step(const FanHeight& now, double target_height_m, double target_speed_m_s, double mass_kg,
              double tilt_y_rad, double tilt_z_rad, const Vector3& rate_B_rad_s,
              const PerFan& measured_rpm, double offset_s, double disturbance_y = 0,
              double disturbance_z = 0) noexcept;

 private:
  Body body_;
  Fans fans_;
  Gains gains_;
  Eigen::Vector4d attitude_gains_;
  double height_integral_ = 0;              // m/s2
  double ground_m_s2_ = 0;                  // lift on the ground, of what it takes to hover
  double integral_y_ = 0, integral_z_ = 0;  // rad s
  double command_y_ = 0, command_z_ = 0;    // rad/s2, of the frame before
};

}  // namespace lss::gnc::talaris
