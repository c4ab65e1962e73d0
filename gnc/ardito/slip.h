#pragma once

// Wheels that turn faster than the rover moves: who is right, wheels or IMU, how much slower the
// rover drives, and whether one of them digs itself in. The stages themselves are of
// MobilityController. Frame thread.

#include "gnc/ardito/parameters.h"
#include "gnc/ardito/state.h"

namespace lss::gnc::ardito {

inline bool drives(Mode mode) noexcept { return mode == Mode::running || mode == Mode::parking; }

// Of the wheels' speed that is lost; 0 while they are too slow to measure it.
double slip_share(const SlipSpeed& slip, const Parameters& parameters) noexcept;

// How much lower each wheel stands than the plane of the other five, from the heights of all in the
// body (z down).
PerWheel<double> lower_than_others_m(const PerWheel<double>& z_m) noexcept;

// How many times as hard as the others' the motor of a wheel that is lower by this may push.
double sink_strain_limit(double lower_m, const Parameters& parameters) noexcept;

}  // namespace lss::gnc::ardito
