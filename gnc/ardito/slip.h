#pragma once

// Wheels that turn faster than the rover moves: who is right, wheels or IMU, and how much slower
// the rover drives. The stages themselves are of MobilityController. Frame thread.

#include "gnc/ardito/parameters.h"
#include "gnc/ardito/state.h"

namespace lss::gnc::ardito {

inline bool drives(Mode mode) noexcept { return mode == Mode::running || mode == Mode::parking; }

// Of the wheels' speed that is lost; 0 while they are too slow to measure it.
double slip_share(const SlipSpeed& slip, const Parameters& parameters) noexcept;

}  // namespace lss::gnc::ardito
