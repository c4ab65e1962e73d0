#pragma once

// Navigation with a camera, checked by one that does without. What a camera says in error goes into
// speed, attitude and biases, and cannot be taken back: when both speeds contradict each other, or
// no sample passes the gate for long, the one without goes on alone until the next calibration. A
// plain value.

#include "gnc/talaris/navigation.h"

namespace lss::gnc::talaris {

class CheckedNavigation {
 public:
  explicit CheckedNavigation(const NavigationParameters& parameters) noexcept
      : with_(parameters), without_(parameters) {}

  // As those of Navigation.
  void begin_calibration() noexcept;
  const CalibrationStatus& calibrate(const Batch& batch) noexcept;
  const CalibrationStatus& calibration() const noexcept { return with_.calibration(); }
  bool aligned() const noexcept { return with_.aligned(); }
  const NavState& step(const Batch& batch, bool standing = false, bool slides = false) noexcept;
  const NavState& state() const noexcept { return with_.state(); }
  const NavCounters& counters() const noexcept { return with_.counters(); }
  bool range_doubted() const noexcept { return with_.range_doubted(); }
  bool corners_uneven() const noexcept { return with_.corners_uneven(); }
  const RangeSample& range_by_corners() const noexcept { return with_.range_by_corners(); }

  bool camera_doubted() const noexcept { return doubted_; }  // it is not used

 private:
  Navigation with_, without_;
  bool doubted_ = false;
  int gated_ = 0;  // frames
};

}  // namespace lss::gnc::talaris
