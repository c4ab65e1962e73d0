#pragma once

// Sideways. Along z by the side jets: pulses too short to fire are carried over until they make one
// (sigma-delta); roll by making one jet of the pair longer. Along y there is no jet: the vehicle is
// tilted about z by a_y/g. Both in the heading frame: N turned with the vehicle about the vertical.

#include <array>

#include "gnc/talaris/parameters.h"
#include "gnc/talaris/phase_plane.h"

namespace lss::gnc::talaris {

// Tilt about +z that moves the vehicle towards y = 0 against a steady `push_m_s2`: PD, limited.
double tilt_for_y(double y_m, double y_rate_m_s, const Gains& gains, double push_m_s2 = 0) noexcept;

class SideJets {
 public:
  // One frame. `force_N` along z, `roll_acceleration_rad_s2` while the pair fires, `fire` of the
  // phase plane otherwise; pulses of valves 2, 4, 6, 8. `traverse`: roll by differential whenever
  // the pair fires, by the phase plane when not.
  std::array<double, 4> step(double force_N, double roll_acceleration_rad_s2, const RollFire& fire,
                             const Body& body, const Thrusters& thrusters,
                             const Gains& gains) noexcept;
  double carry_N_s() const noexcept { return carry_N_s_; }  // pending along +z
  void reset() noexcept { carry_N_s_ = 0; }

 private:
  double carry_N_s_ = 0;
};

}  // namespace lss::gnc::talaris
