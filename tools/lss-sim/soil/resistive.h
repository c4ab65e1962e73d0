#pragma once

// Granular resistive force theory: C. Li, T. Zhang, D. I. Goldman, "A Terradynamics of Legged
// Locomotion on Granular Media", Science 339 (2013), arXiv 1303.7065. The stress on a small plate
// grows with its depth, and depends on its tilt and on the direction of its motion, not on its
// speed. Pure functions; any thread.

namespace lss::sim::soil {

// Stress per depth, in units of that under a horizontal plate that moves straight down: against the
// horizontal part of the motion, and upwards.
struct Resistance {
  double against = 0, up = 0;
};

// The generic coefficients of the paper. `tilt_rad`: beta, of the plate from level, positive when
// its underside faces the way of its horizontal motion, any angle (period pi); `down_rad`: gamma,
// of the motion below the horizontal, -pi/2 to pi/2.
Resistance resistance(double tilt_rad, double down_rad);

// The stress on a plate per depth, ahead and upwards, times the speed: linear in the velocity
// (ahead, up), and in the speed. From the unit normal of either side of the plate, in the plane of
// motion.
struct Plate {
  Plate(double normal_ahead, double normal_up);
  double ahead_of_ahead, ahead_of_up, ahead_of_speed;
  double up_of_ahead, up_of_up, up_of_speed;
};

// The same divided by the speed: the stress of a moving plate per depth. 0 at standstill.
struct Stress {
  double ahead = 0, up = 0;
};
Stress stress(const Plate& plate, double ahead_m_s, double up_m_s);

// A level plate that is dragged along its own plane.
inline constexpr double kDragged = 0.136;

}  // namespace lss::sim::soil
