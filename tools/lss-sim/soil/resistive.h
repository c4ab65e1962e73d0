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

// The same from a unit normal (ahead, up) of either side of the plate and a velocity (ahead, up);
// the stress on the plate per depth, ahead and upwards. 0 at standstill.
struct Stress {
  double ahead = 0, up = 0;
};
Stress stress(double normal_ahead, double normal_up, double ahead_m_s, double up_m_s);

// A level plate that is dragged along its own plane.
inline constexpr double kDragged = 0.136;

}  // namespace lss::sim::soil
