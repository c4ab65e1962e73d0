#pragma once

// Stop, Running or Parking, and the phases of stopping and steering (Ardito thesis 11.1, 11.2.4).
// Pure functions; both begin in their enumerators 0.

#include "gnc/ardito/parameters.h"

namespace lss::gnc::ardito {

struct ModeInputs {
  double speed = 0;  // Vtan, normalised
  bool parking = false;
  bool busy = false;
  bool error = false;
  double delta_sigma_rad = 0;  // since the frame before
};
Mode next_mode(Mode mode, const ModeInputs& inputs, const Parameters& parameters) noexcept;

struct StopInputs {
  double fastest_rad_s = 0;      // |speed| of the fastest wheel
  double largest_angle_rad = 0;  // largest |requested - measured| steering angle
};
StopPhase next_phase(StopPhase phase, const StopInputs& inputs,
                     const Parameters& parameters) noexcept;
inline bool busy(StopPhase phase) noexcept { return phase != StopPhase::rover_stop; }

}  // namespace lss::gnc::ardito
