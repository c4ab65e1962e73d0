#pragma once

// E-guidance (TALARIS thesis 4.2: once a second, an inertial thrust vector to control): over the
// time to go T the acceleration c0 + c1 t takes position and velocity to the target exactly,
//   c0 = 6 dr/T^2 - 2 dv/T,  c1 = -12 dr/T^3 + 6 dv/T^2,  dr = r_T - r - v T,  dv = v_T - v.
// T is never below kMinTimeToGo_s, so that the gains stay finite near the target.

#include <cstdint>

#include "gnc/talaris/parameters.h"

namespace lss::gnc::talaris {

inline constexpr double kMinTimeToGo_s = 1.5;
inline constexpr double kGuidancePeriod_s = 1.0;

// Position, velocity and time of a target; axes of N. Time is counted from Guidance::aim.
struct Target {
  Vector3 position_m = Vector3::Zero();
  Vector3 velocity_m_s = Vector3::Zero();
  double time_to_go_s = kMinTimeToGo_s;
};

struct Coefficients {
  Vector3 c0_m_s2 = Vector3::Zero();
  Vector3 c1_m_s3 = Vector3::Zero();
};

// Exact for the given time; > 0.
Coefficients e_guidance(const Vector3& position_m, const Vector3& velocity_m_s,
                        const Target& target, double time_to_go_s) noexcept;

class Guidance {
 public:
  void aim(const Target& target) noexcept;  // computed again in the next step
  // One frame: position and velocity now, acceleration wanted `ahead_s` from now. Computed again
  // once a second; in between, the polynomial runs on.
  Vector3 step(const Vector3& position_m, const Vector3& velocity_m_s, double ahead_s) noexcept;
  // Acceleration that the last step() wants `ahead_s` after it.
  Vector3 wanted_m_s2(double ahead_s) const noexcept {
    return now_.c0_m_s2 + now_.c1_m_s3 * (since_s_ - kFrame_s + ahead_s);
  }
  const Target& target() const noexcept { return target_; }
  double time_to_go_s() const noexcept { return left_s_; }  // by the plan; below 0: overdue

 private:
  Target target_;
  Coefficients now_;
  double left_s_ = 0;   // to the target
  double since_s_ = 0;  // since now_ was computed
  bool anew_ = true;
};

// F = m (a - g_N) - F_EDF: the force required from the cold gas, axes of N (domain of 4.2's thrust
// vector).
Vector3 gas_force_N(const Vector3& acceleration_m_s2, double mass_kg,
                    const Vector3& fan_force_N) noexcept;

}  // namespace lss::gnc::talaris
