#pragma once

// The event times of a walk: the present cycle and the next one, which must be known before the
// first touchdown since a stance ends with the next cycle's lift-off. Delays are included, gaits
// change by the guarded cycle, and no event ever moves earlier than it was when it could first be
// commanded. Owned by Locomotion; trivially copyable.

#include "gnc/zebro/gait.h"

namespace lss::gnc::zebro {

class Schedule {
 public:
  // All legs on the ground; the first group lifts off at first_lift_s, in the rhythm of the gait.
  void start(const Partition& gait, const GaitTimes& times, double first_lift_s) noexcept;

  // The next cycle uses this gait. Lift-offs of the next cycle that are already commanded stay or
  // move later: for the other legs pass eps. False: it uses this gait already.
  bool change(const Partition& gait, const PerLeg<double>& commanded_lift_off_s) noexcept;

  // This leg touches down later, at time_s: events that wait for it move after it.
  void postpone_touchdown(std::size_t leg, double time_s) noexcept;

  // The next cycle becomes the current one.
  void advance() noexcept;

  const Events& current() const noexcept { return current_; }
  const Events& next() const noexcept { return next_; }
  // Of the next cycle's gait in its steady state.
  double steady_stance_s() const noexcept {
    return cycle_time_s(next_gait_, times_) - times_.flight_s;
  }

 private:
  void plan_next() noexcept;

  GaitTimes times_{};
  Partition gait_{};
  Partition next_gait_{};
  Guard guard_ = Guard::own_last_group;
  PerLeg<double> not_before_s_ = kAnyTime;
  Events current_{};
  Events next_{};
};

}  // namespace lss::gnc::zebro
