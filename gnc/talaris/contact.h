#pragma once

// Detects ground contact with the IMU alone. In the air the specific force along x is only lift /
// mass; the ground adds to it, at first as a shock and then, when the lift decreases, as support.
// On a slope a single foot is first: too slow for a shock, it turns the vehicle all the more.

#include "gnc/talaris/types.h"

namespace lss::gnc::talaris {

struct ContactParameters {
  // A sample above the expected lift, and one beside it by half as much: a touchdown at 0.3 m/s
  // and more. Both also beyond the scatter of samples in the air: fans shake the IMU.
  double shock_m_s2 = 6;  // [D]
  double shock_sigma = 6;
  double scatter_share = 0.2;  // of a frame in the scatter: as slow as 1 s
  // Turned by a foot, about y and z, within 10 ms: a touchdown of one foot at 0.1 m/s. Valves do
  // less, pulses in pairs; those of a landing with failed ones do not.
  double jolt_rad_s = 0.13;  // [D]
  double support_m_s2 = 1;   // mean of a frame above the expected lift [D]
  int support_frames = 2;    // so many in a row [D]
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
  // Turned like that in this frame.
  bool jolted() const noexcept { return jolted_; }
  void reset() noexcept { *this = Contact(parameters_); }

 private:
  struct Turns {
    std::int64_t time_ns = 0;
    Eigen::Vector2d rate_rad_s{kNaN, kNaN};  // about y and z
  };
  bool jolts() const noexcept;

  ContactParameters parameters_;
  int supported_ = 0, shock_frames_ = 0;
  bool jolted_ = false;
  std::array<Turns, 5> turns_{};  // of the last samples
  double variance_ = -1;          // from sample to sample, (m/s2)^2; negative: not known yet
};

}  // namespace lss::gnc::talaris
