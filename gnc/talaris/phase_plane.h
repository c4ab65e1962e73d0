#pragma once

// Roll by two side valves while nothing pushes sideways: rise, hover, descent (TALARIS thesis 4.2).
// Angle error e and rate w make a plane with a switching curve
//   w*(e) = -sign(e) min(sqrt(2 share a b), slope b, w_limit),   b = |e| - dead band,
//   a = 2 F y / I_x
// and a pulse takes w most of the way to w*: a full correction would oscillate when I_x is smaller
// than assumed. The smallest pulse of a couple changes the rate by 17.7 deg/s (58 N), which is
// large: small corrections are made by a single valve.

#include "gnc/talaris/parameters.h"

namespace lss::gnc::talaris {

struct RollFire {
  double on_s = 0;      // 0: nothing; positive: +roll, negative: -roll
  bool couple = false;  // both valves, or one
};

// `error_rad`: actual minus wanted, at the centre of the pulse; `rate_rad_s` likewise.
RollFire phase_plane(double error_rad, double rate_rad_s, double force_N, const Body& body,
                     const Thrusters& thrusters, const Gains& gains) noexcept;

// Rate of the switching curve.
double wanted_roll_rate(double error_rad, double acceleration_rad_s2, const Gains& gains) noexcept;

}  // namespace lss::gnc::talaris
