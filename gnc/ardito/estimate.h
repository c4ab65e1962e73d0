#pragma once

// How the rover moves, from wheels and steering systems that can be trusted, and whether they and
// the IMU tell the same (Ardito thesis 17.6 to 17.8, with E8 to E13). Pure functions.

#include "gnc/ardito/inputs.h"

namespace lss::gnc::ardito {

struct Motion {
  PlaneMotion mean;
  double sigma_rad = 0;      // of mean
  PerWheel<double> v_m_s{};  // of the CM, as each wheel alone would have it
  double v_to_hub = 1;       // on the spot the CM hardly moves: speeds are compared times this
  bool incoherent_speed = false;
  bool incoherent_sigma = false;
  bool slip = false;
  bool imu_contradicts = false;  // more than a rover that slides sideways can make of it
};

// trusted, trusted_steering: what the means are made of; none: all of them.
Motion estimate_motion(const Feedback& feedback, const Inputs& inputs, WheelSet trusted,
                       SteeringSet trusted_steering, bool correction,
                       const Parameters& parameters) noexcept;

// This wheel goes another way than the rover: 135 mm/s, less where the rover is slow.
bool incoherent(const Motion& motion, std::size_t wheel, const Parameters& parameters) noexcept;

// Speed of the CM that goes with this hub's measured speed, against the IMU's, on the same scale.
bool imu_confirms(const Motion& motion, std::size_t wheel, double wheel_rad_s,
                  const Feedback& feedback, const Inputs& inputs, bool correction,
                  const Parameters& parameters) noexcept;

}  // namespace lss::gnc::ardito
