#include "gnc/zebro/schedule.h"

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

void Schedule::start(const Partition& gait, const GaitTimes& times, double first_lift_s) noexcept {
  times_ = times;
  gait_ = next_gait_ = gait;
  guard_ = Guard::own_last_group;
  not_before_s_ = kAnyTime;
  current_ = rhythm(gait, times);
  for (double& time_s : current_.touchdown_s) time_s += first_lift_s;
  for (double& time_s : current_.lift_off_s) time_s += first_lift_s;
  plan_next();
}

bool Schedule::change(const Partition& gait, const PerLeg<double>& commanded_lift_off_s) noexcept {
  if (same_gait(gait, next_gait_)) return false;
  not_before_s_ = commanded_lift_off_s;
  if (same_gait(gait, gait_)) {  // back to the present gait before the change
    next_gait_ = gait_;
    guard_ = Guard::own_last_group;
  } else {
    next_gait_ = best_switch(gait, times_, current_, commanded_lift_off_s).gait;
    guard_ = Guard::all_legs;
  }
  plan_next();
  return true;
}

void Schedule::postpone_touchdown(std::size_t leg, double time_s) noexcept {
  if (time_s <= current_.touchdown_s[leg]) return;
  current_.touchdown_s[leg] = time_s;
  postpone_dependents(gait_, times_, current_);
  plan_next();
}

void Schedule::advance() noexcept {
  gait_ = next_gait_;
  guard_ = Guard::own_last_group;
  not_before_s_ = kAnyTime;
  current_ = next_;
  plan_next();
}

void Schedule::plan_next() noexcept {
  next_ = next_cycle(next_gait_, times_, current_, guard_, not_before_s_);
}

}  // namespace lss::gnc::zebro
