#pragma once

// The event times of a walk: the present cycle and the next one, which must be known before the
// first touchdown since a stance ends with the next cycle's lift-off. Delays are included, and no
// event ever moves earlier than it was when it could first be commanded. Two algorithms
// (docs/gait-zebro.md): max-plus, where each event waits for those that it depends on and gaits
// change by the guarded cycle; and a fixed table of equal intervals, in which the legs keep their
// groups whatever the speed, and whose clock stands still while a leg is late. Owned by Locomotion;
// trivially copyable.

#include "gnc/zebro/gait.h"

namespace lss::gnc::zebro {

enum class Algorithm : std::uint8_t { max_plus, table };

class Schedule {
 public:
  // All legs on the ground; the first group lifts off at first_lift_s, in the rhythm of the gait.
  void start(Algorithm algorithm, const Partition& gait, const GaitTimes& times,
             double first_lift_s) noexcept;

  // The next cycle uses this gait, with a table its cycle time. Lift-offs of the next cycle that
  // are already commanded stay or move later: for the other legs pass eps.
  void change(const Partition& gait, const PerLeg<double>& commanded_lift_off_s) noexcept;

  // This leg touches down later, at time_s: events that wait for it move after it.
  void postpone_touchdown(std::size_t leg, double time_s) noexcept;

  // The next cycle becomes the current one.
  void advance() noexcept;

  const Events& current() const noexcept { return current_; }
  const Events& next() const noexcept { return next_; }
  // Of the next cycle's gait in its steady state.
  double steady_stance_s() const noexcept { return next_period_s_ - times_.flight_s; }

 private:
  void plan_next() noexcept;
  Events table(double begin_s, double period_s) const noexcept;
  void stop_clock(double from_s, double delay_s) noexcept;

  Algorithm algorithm_ = Algorithm::max_plus;
  double begin_s_ = 0, period_s_ = 0;            // table: of the current cycle
  double next_begin_s_ = 0, next_period_s_ = 0;  // of the next one
  GaitTimes times_{};
  Partition gait_{};
  Partition next_gait_{};
  Guard guard_ = Guard::own_last_group;
  PerLeg<double> not_before_s_ = kAnyTime;
  Events current_{};
  Events next_{};
};

}  // namespace lss::gnc::zebro
