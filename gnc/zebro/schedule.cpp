#include "gnc/zebro/schedule.h"

#include <algorithm>

namespace lss::gnc::zebro {

namespace {

bool same_gait(const Partition& a, const Partition& b) noexcept {
  if (a.groups != b.groups) return false;
  for (int first = 0; first < b.groups; ++first) {
    if (a == rotated(b, first)) return true;
  }
  return false;
}

}  // namespace

void Schedule::start(Algorithm algorithm, const Partition& gait, const GaitTimes& times,
                     double first_lift_s) noexcept {
  algorithm_ = algorithm;
  times_ = times;
  begin_s_ = first_lift_s;
  period_s_ = next_period_s_ = cycle_time_s(gait, times);
  gait_ = next_gait_ = gait;
  guard_ = Guard::own_last_group;
  not_before_s_ = kAnyTime;
  if (algorithm == Algorithm::table) {
    current_ = table(begin_s_, period_s_);
  } else {
    current_ = rhythm(gait, times);
    for (double& time_s : current_.touchdown_s) time_s += first_lift_s;
    for (double& time_s : current_.lift_off_s) time_s += first_lift_s;
  }
  plan_next();
}

void Schedule::change(const Partition& gait, const PerLeg<double>& commanded_lift_off_s) noexcept {
  if (algorithm_ == Algorithm::table) {
    not_before_s_ = commanded_lift_off_s;
    next_period_s_ = cycle_time_s(gait, times_);
    return plan_next();
  }
  if (same_gait(gait, next_gait_)) return;
  not_before_s_ = commanded_lift_off_s;
  if (same_gait(gait, gait_)) {  // back to the present gait before the change
    next_gait_ = gait_;
    guard_ = Guard::own_last_group;
  } else {
    next_gait_ = best_switch(gait, times_, current_, commanded_lift_off_s).gait;
    guard_ = Guard::all_legs;
  }
  next_period_s_ = cycle_time_s(next_gait_, times_);
  plan_next();
}

void Schedule::postpone_touchdown(std::size_t leg, double time_s) noexcept {
  const double delay_s = time_s - current_.touchdown_s[leg];
  if (delay_s <= 0) return;
  if (algorithm_ == Algorithm::table) return stop_clock(current_.touchdown_s[leg], delay_s);
  current_.touchdown_s[leg] = time_s;
  postpone_dependents(gait_, times_, current_);
  plan_next();
}

void Schedule::advance() noexcept {
  gait_ = next_gait_;
  begin_s_ = next_begin_s_;
  period_s_ = next_period_s_;
  guard_ = Guard::own_last_group;
  not_before_s_ = kAnyTime;
  current_ = next_;
  plan_next();
}

Events Schedule::table(double begin_s, double period_s) const noexcept {
  Events events{kAnyTime, kAnyTime};
  for (std::size_t i = 0; i < kLegs; ++i) {
    if (gait_.group_of[i] == kNoGroup) continue;
    events.lift_off_s[i] = begin_s + gait_.group_of[i] * period_s / gait_.groups;
    events.touchdown_s[i] = events.lift_off_s[i] + times_.flight_s;
  }
  return events;
}

// Everything from this time on is so much later.
void Schedule::stop_clock(double from_s, double delay_s) noexcept {
  for (std::size_t i = 0; i < kLegs; ++i) {
    if (current_.lift_off_s[i] >= from_s) current_.lift_off_s[i] += delay_s;
    if (current_.touchdown_s[i] >= from_s) current_.touchdown_s[i] += delay_s;
  }
  begin_s_ += delay_s;
  plan_next();
}

void Schedule::plan_next() noexcept {
  if (algorithm_ == Algorithm::table) {
    next_begin_s_ = begin_s_ + period_s_;
    double late_s = 0;
    const Events planned = table(next_begin_s_, next_period_s_);
    for (std::size_t i = 0; i < kLegs; ++i) {
      if (gait_.group_of[i] != kNoGroup)
        late_s = std::max(late_s, not_before_s_[i] - planned.lift_off_s[i]);
    }
    next_begin_s_ += late_s;
    next_ = table(next_begin_s_, next_period_s_);
    return;
  }
  next_ = next_cycle(next_gait_, times_, current_, guard_, not_before_s_);
}

}  // namespace lss::gnc::zebro
