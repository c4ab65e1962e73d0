#pragma once

// Estimates the motion of the rover from trusted wheels and steering systems, and compares it with
// the IMU (Ardito thesis 17.6 to 17.8, with E8 to E13). Pure functions.

#include "gnc/ardito/inputs.h"

namespace lss::gnc::ardito {

struct Motion {
  PlaneMotion mean;
  double sigma_rad = 0;      // of mean
  PerWheel<double> v_m_s{};  // of the CM, by each wheel alone
  double v_to_hub = 1;       // on the spot the CM hardly moves: factor for comparing speeds
  bool incoherent_speed = false;
  bool incoherent_sigma = false;
  bool slip = false;
  bool imu_contradicts = false;  // by more than sideways sliding can explain
  double slip_m_s =
      0;  // wheels minus IMU along the motion, on the scale of v_to_hub; 0 without IMU
  double sliding_m_s = 0;  // across the motion, by the IMU, without a sign; 0 without one
  double ground_m_s = 0;   // of the CM along the motion, by the IMU; without one that of the wheels
};

// Motion::v_to_hub of a motion in this direction.
double v_to_hub(const Direction& direction, const Parameters& parameters) noexcept;

// trusted, trusted_steering: inputs of the means; none: all of them.
Motion estimate_motion(const Feedback& feedback, const Inputs& inputs, WheelSet trusted,
                       SteeringSet trusted_steering, bool correction,
                       const Parameters& parameters) noexcept;

// This wheel moves differently from the rover: 135 mm/s, less where the rover is slow.
bool incoherent(const Motion& motion, std::size_t wheel, const Parameters& parameters) noexcept;

// Speed of the CM for this hub's measured speed, against the IMU's, on the same scale.
bool imu_confirms(const Motion& motion, std::size_t wheel, double wheel_rad_s,
                  const Feedback& feedback, const Inputs& inputs, bool correction,
                  const Parameters& parameters) noexcept;

}  // namespace lss::gnc::ardito
