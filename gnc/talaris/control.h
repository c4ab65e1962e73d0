#pragma once

// Cold gas control at 5 Hz (TALARIS thesis 4.2): from the force of guidance and the state to
// on-time and delay of each valve. The state is predicted to the centre of the pulses, T_k + offset
// + 100 ms, with the impulse of pulses that still run at T_k.

#include "gnc/talaris/lateral.h"
#include "gnc/talaris/parameters.h"
#include "gnc/talaris/pwm.h"

namespace lss::gnc::talaris {

struct ControlTarget {
  Vector3 force_N = Vector3::Zero();  // cold gas, axes of N: x and z of the heading are used
  double roll_rad = 0;                // heading wanted
  double tilt_y_rad = 0;              // wanted rotation about y and z; level: 0
  double tilt_z_rad = 0;
  bool lift = true;      // lift valves may fire
  bool side = true;      // side jets may fire along z
  bool roll = true;      // side jets may fire for roll
  bool attitude = true;  // off-pulsing
  bool full = false;     // emergency: pulses up to the whole frame
  bool fresh = false;    // just off the ground: what turns it is learned at once
  bool unheard = false;  // the pulses before may not have been fired: nothing is learned
};

// Rotation of the vehicle for control: heading about the vertical (-pi..pi) and tilt, the small
// rotation about y and z that takes the vertical to the body's x.
struct Attitude {
  double roll_rad = 0, tilt_y_rad = 0, tilt_z_rad = 0;
  double cosine = 1;  // of the tilt
};
Attitude attitude_of(const Quaternion& q_NB) noexcept;

// -pi..pi
double wrapped(double angle_rad) noexcept;

struct ControlOutput {
  std::array<Pulse, kValves> valve{};
  Vector3 error_rad = Vector3::Zero();  // roll, pitch, yaw at the centre of the pulses
  double lift_N = 0;                    // mean over the frame, as commanded
};

class Control {
 public:
  Control(const Parameters& parameters, const Gains& gains) noexcept
      : parameters_(parameters), gains_(gains) {}

  void begin() noexcept;  // clears integral, carry and pulses
  void set_gains(const Gains& gains) noexcept { gains_ = gains; }
  // Angular acceleration not explained by pulses, rad/s2: fans, CM.
  double disturbance_y() const noexcept { return disturbance_y_; }
  double disturbance_z() const noexcept { return disturbance_z_; }
  // Mean force along the heading's z in the frame that just ended.
  double side_N() const noexcept;
  ControlOutput step(const NavState& state, const ControlTarget& target) noexcept;

 private:
  Vector3 impulse_N_m_s(const std::array<Pulse, kValves>& pulses, bool late) const noexcept;
  void observe(const Vector3& rate_B_rad_s, bool fresh, bool unheard) noexcept;

  Parameters parameters_;
  Gains gains_;
  SideJets jets_;
  double integral_y_ = 0, integral_z_ = 0;  // rad s
  double saturated_ = 0;                    // share of the moments that was cut in the last frame
  std::array<Pulse, kValves> last_{}, before_{};
  Vector3 rate_before_ = Vector3::Zero();
  double disturbance_y_ = 0, disturbance_z_ = 0;  // rad/s2, not explained by pulses
  bool observed_ = false;
};

}  // namespace lss::gnc::talaris
