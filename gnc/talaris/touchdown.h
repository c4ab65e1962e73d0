#pragma once

// Stands it? Witnesses of the ground that need neither altimeter nor a known height: the IMU is
// still, and stays so although the lift changes. In the air an acceleration follows each change of
// the lift; on the ground the legs take it. Frame thread; time is data; no allocation.

#include "gnc/talaris/types.h"

namespace lss::gnc::talaris {

struct TouchdownParameters {
  // Of a frame on the legs: mean acceleration along x of N, and by how much the vertical moved in
  // B. Light on its legs it may slide and turn.
  double level_m_s2 = 0.12;
  double level_rad = 0.005;
  double support_m_s2 = 0.3;  // loss of lift that is not followed: the ground carries,
  double support_s = 0.8;     // when it is level for so long, too,
  double lost_s = 0.4;        // and the loss lasts
  // Of a frame without any motion: in every direction, and by how much the attitude changed.
  double still_m_s2 = 0.08;
  double still_rad = 0.0026;
  double stands_s = 3;  // still for so long in a flight by pulses: they shake it in the air
};

class Touchdown {
 public:
  Touchdown() = default;
  explicit Touchdown(const TouchdownParameters& parameters) noexcept : parameters_(parameters) {}

  void reset() noexcept { *this = Touchdown(parameters_); }
  // One frame. `heard`: the state is measured. `expected_m_s2`: acceleration along x of N that lift
  // and mass explain, mean of the frame; a constant error of it has no effect.
  void step(const NavState& state, bool heard, double expected_m_s2) noexcept;

  double still_s() const noexcept { return still_s_; }
  double level_s() const noexcept { return level_s_; }
  bool supported() const noexcept {
    return level_s_ >= parameters_.support_s && lost_s_ >= parameters_.lost_s;
  }
  bool stands() const noexcept { return still_s_ >= parameters_.stands_s; }

 private:
  TouchdownParameters parameters_;
  Quaternion before_ = Quaternion::Identity();
  bool known_ = false;                // before_
  double level_s_ = 0, still_s_ = 0;  // without interruption
  double least_m_s2_ = 0;             // acceleration above the expected one, while it was level
  double lost_s_ = 0;                 // much above it, without interruption
};

}  // namespace lss::gnc::talaris
