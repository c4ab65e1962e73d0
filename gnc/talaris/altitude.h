#pragma once

// Height and attitude by the fans alone (TALARIS thesis 5.2.3: altitude hop, "parachute mode").
//
// Four fans that push along +x at the corners give lift, pitch and yaw by differences. They give no
// roll: their cants cancel, and no other actuator turns the vehicle about its vertical; its roll
// stays as it was. A fan follows with a lag of a quarter of a second, longer than a frame. So the
// lag is part of the state: moment (from the measured speeds), rate, angle and the integral of the
// angle are fed back with gains that place the poles of the sampled loop, ZOH and lag included, as
// the parameters say.

#include <Eigen/Core>

#include "gnc/talaris/fans.h"
#include "gnc/talaris/parameters.h"

namespace lss::gnc::talaris {

// Gains of u = -k x for integral of the angle, angle, rate, acceleration (rad s, rad, rad/s,
// rad/s2), u: settled acceleration of the command. All four poles at -pole, frame 200 ms.
Eigen::Vector4d fan_attitude_gains(double lag_s, double pole_rad_s) noexcept;

struct FanHeight {
  double height_m = 0;   // measured
  double speed_m_s = 0;  // up
  double bias_m_s2 = 0;  // acceleration not explained by fans and mass
};

class FanFlight {
 public:
  FanFlight(const Parameters& parameters, const Gains& gains) noexcept;

  // Clears integrals. On the ground the lift rises from a low value until the vehicle lifts off:
  // else a light one would jump, and a heavy one would never leave.
  void begin(bool on_ground = false) noexcept;
  void set_gains(const Gains& gains) noexcept;

  // Speeds for one frame. Height control: PID towards `target_height_m` moving with
  // `target_speed_m_s`, limited; `tilt_y/z_rad` actual minus wanted, `rate` in B; NaN in any of
  // those: no attitude is known, all fans alike except against the known `disturbance` (rad/s2).
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
  double ground_m_s2_ = 0;                  // lift on the ground, relative to hovering
  double integral_y_ = 0, integral_z_ = 0;  // rad s
  double command_y_ = 0, command_z_ = 0;    // rad/s2, of the frame before
};

}  // namespace lss::gnc::talaris
