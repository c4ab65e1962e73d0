#pragma once

// Detects ground contact with the IMU alone: for a landing whose altimeter is silent. In the air
// the specific force along x is only lift / mass; the ground adds to it, at first as a shock and
// then, when the lift decreases, as support.

#include "gnc/talaris/types.h"

namespace lss::gnc::talaris {

struct ContactParameters {
  // A sample above the expected lift, and one beside it by half as much: a touchdown at 0.3 m/s
  // and more. Both also beyond the scatter of samples in the air: fans shake the IMU.
  double shock_m_s2 = 6;  // [D]
  double shock_sigma = 6;
  double scatter_share = 0.2;  // of a frame in the scatter: as slow as 1 s
  double support_m_s2 = 1;     // mean of a frame above the expected lift [D]
  int support_frames = 2;      // so many in a row [D]
};

class Contact {
 public:
  Contact() = default;
  explicit Contact(const ContactParameters& parameters) noexcept : parameters_(parameters) {}

  // In every frame of a flight. lift_m_s2: expected lift of fans and vertical valves, mean of the
  // frame, over the mass. Samples that are not numbers are ignored.
  void step(const Batch& batch, double lift_m_s2) noexcept;
  // The ground carries.
  bool supported() const noexcept { return supported_ >= parameters_.support_frames; }
  // Samples as hard as a touchdown in this frame or the one before.
  bool shocked() const noexcept { return shock_frames_ > 0; }
  void reset() noexcept { *this = Contact(parameters_); }

 private:
  ContactParameters parameters_;
  int supported_ = 0, shock_frames_ = 0;
  double variance_ = -1;  // from sample to sample, (m/s2)^2; negative: not known yet
};

}  // namespace lss::gnc::talaris
