// The walking stage of Locomotion: turns the events of the schedule into the movements of the legs.

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "gnc/zebro/locomotion.h"

namespace lss::gnc::zebro {

namespace {

// A swing that ends within 20 deg of its start is ordered in two halves, since "rotate to here"
// would move nothing.
constexpr double kAmbiguous_rad = 2 * kPi - 0.35;
// A stance whose end moved by less is unchanged: the leg waits this long at its end instead of a
// new order per frame.
constexpr double kSlower_s = 0.1;

// A shorter stance is omitted: its order would be to turn to the present angle.
constexpr double kStill_rad = 1e-3;

// Of the legs that have one.
double first_s(const PerLeg<double>& times_s) noexcept {
  double first = std::numeric_limits<double>::infinity();
  for (const double time_s : times_s) {
    if (time_s != max_plus::kEps) first = std::min(first, time_s);
  }
  return first;
}

const Partition& gait_of(Speed speed) noexcept {
  if (speed == Speed::high) return kTripod;
  return speed == Speed::medium ? kTetrapodB : kWave;
}

bool reverses(double before, double after) noexcept { return before * after < 0; }

}  // namespace

double Locomotion::requested_half_sweep_rad(std::size_t leg) const noexcept {
  const double speed = is_left(static_cast<int>(leg)) ? sides_.left : sides_.right;
  return half_sweep_rad(speed, sweep_rad_, parameters_.leg_diameter_m);
}

Roll Locomotion::roll_of(const SideSpeeds& sides) const noexcept {
  Roll roll{{}, offset_rad_, parameters_.leg_diameter_m, parameters_.hips};
  const double left_rad = half_sweep_rad(sides.left, sweep_rad_, parameters_.leg_diameter_m);
  const double right_rad = half_sweep_rad(sides.right, sweep_rad_, parameters_.leg_diameter_m);
  for (std::size_t i = 0; i < kLegs; ++i) {
    roll.half_sweep_rad[i] = is_left(static_cast<int>(i)) ? left_rad : right_rad;
  }
  return roll;
}

// With legs out of service; false when no gait is stable.
bool Locomotion::choose_gait() noexcept {
  if (!can_walk_) return false;
  sides_ = side_speeds(request_.direction, request_.heading_rad);
  creep_speed_ = request_.speed;
  const StableGait found = stable_gait(isolated_, request_.speed, roll_of(sides_));
  creep_ = found.creep;
  return found.margin_m >= kLeastMargin_m;
}

// A small change of heading uses the present gait, when that is stable with it. Legs take it over
// group by group, from whichever lifts off next: each mixture must be stable, too.
bool Locomotion::gait_stays(const SideSpeeds& wanted) const noexcept {
  const Roll to = roll_of(wanted);
  if (request_.speed != creep_speed_ && stable_gait(isolated_, request_.speed, to).creep != creep_)
    return false;
  Roll from = to;
  for (std::size_t i = 0; i < kLegs; ++i) from.half_sweep_rad[i] = legs_[i].half_sweep_rad;
  const int groups = creep_.gait.groups;
  for (int first = 0; first < groups; ++first) {
    Roll mixed = from;
    for (int n = 0; n < groups; ++n) {
      for (std::size_t i = 0; i < kLegs; ++i) {
        if (creep_.gait.group_of[i] == (first + n) % groups)
          mixed.half_sweep_rad[i] = to.half_sweep_rad[i];
      }
      if (static_margin_m(creep_, mixed) < kLeastMargin_m) return false;
    }
  }
  return true;
}

void Locomotion::begin_stepping(double now_s) noexcept {
  const bool creeps = isolated_ != 0;
  if (creeps) {
    schedule_.start(creep_.gait, times_, now_s + parameters_.start_delay_s);
  } else {
    sides_ = side_speeds(request_.direction, request_.heading_rad);
    // Two tripods align the legs for the gait; six single legs would take three times as long.
    schedule_.start(kTripod, times_, now_s + parameters_.start_delay_s);
    schedule_.change(gait_of(request_.speed), kAnyTime);
  }
  // A creep begins in its steady state, for the walk that the legs were aligned for.
  pushed_off_ = creeps;
  first_cycle_ = !creeps;
  walk_changed_ = creeps;
  gait_changed_ = false;
  landing_group_ = 0;
  for (std::size_t i = 0; i < kLegs; ++i) {
    Leg& leg = legs_[i];
    leg.lifted = leg.landed = !in_service(i);  // which takes no part in any cycle
    leg.late = false;
    leg.half_sweep_rad = creeps ? requested_half_sweep_rad(i) : 0;
    leg.top_s = 0;
  }
}

void Locomotion::step(double now_s) noexcept {
  if (walk_changed_) change_walk();
  if (stage_ != Stage::step) return;
  if (!pushed_off_ && now_s >= first_s(schedule_.current().lift_off_s)) push_off();
  // Usually nothing or one event is due; after a gap in time they are processed in order.
  constexpr int kMostRounds = 64;
  bool more = true;
  for (int round = 0; more && round < kMostRounds && progress_ == Progress::running; ++round) {
    more = false;
    for (std::size_t i = 0; i < kLegs; ++i) {
      if (!targets_[i].swing || !swing_over(i, now_s)) continue;
      touch_down(i);
      if (isolated_ == 0) stance(i);
      more = true;
    }
    if (isolated_ != 0 && group_landed()) roll_body();
    if (next_cycle_begins(now_s)) begin_next_cycle(now_s);
    // The first one first: after a gap in time its touchdown postpones the lift-offs of others.
    for (;;) {
      const PerLeg<double>& lift_off_s = schedule_.current().lift_off_s;
      std::size_t first = kLegs;
      for (std::size_t i = 0; i < kLegs; ++i) {
        if (legs_[i].lifted || now_s < lift_off_s[i]) continue;
        if (first == kLegs || lift_off_s[i] < lift_off_s[first]) first = i;
      }
      if (first == kLegs) break;
      lift_off(first);
      more = true;
    }
  }
  if (isolated_ == 0) slow_stances(now_s);
}

// A new request takes effect leg by leg with each next swing, the gait with the next cycle. Each
// change of the gait may move that later: once per cycle, the last request with the one after.
// Where a side reverses, the legs of that side would work against each other for a whole cycle:
// there the step is finished first.
void Locomotion::change_walk() noexcept {
  walk_changed_ = false;
  const SideSpeeds wanted = side_speeds(request_.direction, request_.heading_rad);
  if (request_.speed == Speed::zero || (request_.rows && can_row_ && isolated_ == 0) ||
      reverses(sides_.left, wanted.left) || reverses(sides_.right, wanted.right)) {
    stage_ = Stage::land;
    return;
  }
  if (isolated_ != 0) {
    if (gait_stays(wanted)) {
      creep_speed_ = request_.speed;
      sides_ = wanted;
    } else {
      stage_ = Stage::land;  // between two gaits there may be no margin
    }
    return;
  }
  sides_ = wanted;
  if (gait_changed_) return;
  PerLeg<double> commanded_s = kAnyTime;
  for (std::size_t i = 0; i < kLegs; ++i) {
    if (legs_[i].landed) commanded_s[i] = schedule_.next().lift_off_s[i];
  }
  gait_changed_ = schedule_.change(gait_of(request_.speed), commanded_s);
}

// The first cycle runs at half speed, which brings legs that all start straight down into the
// steady state without working against each other: each rolls from the middle to where it lifts
// off, and touches down as far ahead as it can roll back by its next lift-off, at half speed to the
// end of this cycle and at full speed from there.
void Locomotion::push_off() noexcept {
  pushed_off_ = true;
  const PerLeg<double>& lift_off_s = schedule_.current().lift_off_s;
  const double start_s = first_s(lift_off_s);
  for (std::size_t i = 0; i < kLegs; ++i) {
    const double rolled = (lift_off_s[i] - start_s) / schedule_.steady_stance_s();
    const double from_rad = legs_[i].estimate_rad;
    const double to_rad = offset_rad_ - rolled * requested_half_sweep_rad(i);
    if (std::abs(to_rad - from_rad) < parameters_.arrived_rad) continue;
    order(i, from_rad, to_rad, start_s, lift_off_s[i], false);
  }
}

// Angle of a leg of the first cycle at the end of that cycle, and its touchdown angle for it.
double Locomotion::end_of_first_cycle_rad(std::size_t i) const noexcept {
  const PerLeg<double>& next_s = schedule_.next().lift_off_s;
  const double to_roll = 2 * (next_s[i] - first_s(next_s)) / schedule_.steady_stance_s();
  return offset_rad_ + legs_[i].half_sweep_rad * (std::min(to_roll, 2.0) - 1);
}

double Locomotion::touchdown_rad(std::size_t i) const noexcept {
  const double half_rad = legs_[i].half_sweep_rad;
  if (!first_cycle_) return offset_rad_ + half_rad;
  const double until_s = first_s(schedule_.next().lift_off_s) - schedule_.current().touchdown_s[i];
  const double end_rad = end_of_first_cycle_rad(i) - offset_rad_;
  const double touchdown_rad = end_rad + half_rad * until_s / schedule_.steady_stance_s();
  const double furthest_rad = kFurthestReach * std::abs(half_rad);
  return offset_rad_ + std::clamp(touchdown_rad, -furthest_rad, furthest_rad);
}

bool Locomotion::next_cycle_begins(double now_s) const noexcept {
  const bool all_landed =
      std::all_of(legs_.begin(), legs_.end(), [](const Leg& leg) { return leg.landed; });
  return all_landed && now_s >= first_s(schedule_.next().lift_off_s);
}

void Locomotion::begin_next_cycle(double now_s) noexcept {
  schedule_.advance();
  for (std::size_t i = 0; i < kLegs; ++i) legs_[i].lifted = legs_[i].landed = !in_service(i);
  landing_group_ = 0;
  walk_changed_ |= std::exchange(gait_changed_, false);
  if (!first_cycle_) return;
  first_cycle_ = false;
  for (std::size_t i = 0; i < kLegs; ++i) {  // from half to full speed
    const double lift_off_s = schedule_.current().lift_off_s[i];
    if (now_s < lift_off_s) roll(i, wrap_rad(reference_rad(i, now_s)), now_s, lift_off_s);
  }
}

void Locomotion::lift_off(std::size_t i) noexcept {
  Leg& leg = legs_[i];
  leg.lifted = true;
  leg.landed = leg.late = false;
  leg.half_sweep_rad = requested_half_sweep_rad(i);
  const double start_s = schedule_.current().lift_off_s[i];
  const double arrive_s = schedule_.current().touchdown_s[i];
  const double from_rad = wrap_rad(leg.to_rad);
  const double travel_rad =
      travel_through_top_rad(from_rad, touchdown_rad(i), request_.direction >= 0);
  if (std::abs(travel_rad) <= kAmbiguous_rad) {
    leg.top_s = 0;
    swing(i, from_rad, from_rad + travel_rad, start_s, arrive_s);
    return;
  }
  leg.top_s = (start_s + arrive_s) / 2;
  leg.top_to_rad = from_rad + travel_rad;
  order(i, from_rad, from_rad + travel_rad / 2, start_s, leg.top_s, true);
}

// The last or only part of a swing. A leg that cannot make it in time touches down later, and the
// schedule is updated.
void Locomotion::swing(std::size_t i, double from_rad, double to_rad, double start_s,
                       double arrive_s) noexcept {
  order(i, from_rad, to_rad, start_s, arrive_s, true);
  schedule_.postpone_touchdown(i, targets_[i].arrive_s);
}

// The leg is down: by its own report if it has one, else by the clock. While it is late, everything
// that waits for it is moved.
bool Locomotion::swing_over(std::size_t i, double now_s) noexcept {
  Leg& leg = legs_[i];
  const double& touchdown_s = schedule_.current().touchdown_s[i];
  if (leg.top_s > 0) {
    if (now_s < leg.top_s) return false;
    const double top_s = leg.top_s;
    leg.top_s = 0;
    swing(i, leg.to_rad, leg.top_to_rad, top_s, touchdown_s);
  }
  if (now_s < touchdown_s) return false;
  const bool down = !leg.usable || arrived(i);
  if (!down || leg.late) {
    leg.late = true;
    // Not yet now: what waits for it may lift off without any double stance.
    schedule_.postpone_touchdown(i, down ? now_s : std::nextafter(now_s, HUGE_VAL));
  }
  if (!down && now_s > targets_[i].arrive_s + parameters_.late_limit_s) {
    fail(static_cast<LegSet>(1u << i));
  }
  return down;
}

void Locomotion::touch_down(std::size_t i) noexcept {
  targets_[i].swing = false;
  legs_[i].landed = true;
  if (std::all_of(legs_.begin(), legs_.end(), [](const Leg& leg) { return leg.landed; })) ++steps_;
}

void Locomotion::stance(std::size_t i) noexcept {
  const double from_rad = wrap_rad(legs_[i].to_rad);
  const double touchdown_s = schedule_.current().touchdown_s[i];
  if (!first_cycle_) {
    roll(i, from_rad, touchdown_s, schedule_.next().lift_off_s[i]);
  } else if (const double to_rad = end_of_first_cycle_rad(i);
             std::abs(to_rad - from_rad) > kStill_rad) {
    order(i, from_rad, to_rad, touchdown_s, first_s(schedule_.next().lift_off_s), false);
  }
}

// To the lift-off angle of the sweep that the leg touched down with.
void Locomotion::roll(std::size_t i, double from_rad, double start_s, double lift_off_s) noexcept {
  const double to_rad = offset_rad_ - legs_[i].half_sweep_rad;
  if (std::abs(to_rad - from_rad) <= kStill_rad) return;  // it only steps on the spot
  order(i, from_rad, to_rad, start_s, lift_off_s, false);
}

// Events moved later while legs roll towards them: the same way, slower.
void Locomotion::slow_stances(double now_s) noexcept {
  for (std::size_t i = 0; i < kLegs; ++i) {
    if (targets_[i].swing || !pushed_off_) continue;
    const double end_s = !legs_[i].lifted ? schedule_.current().lift_off_s[i]
                         : first_cycle_   ? first_s(schedule_.next().lift_off_s)
                                          : schedule_.next().lift_off_s[i];
    const double here_rad = reference_rad(i, now_s);
    if (end_s < targets_[i].arrive_s + kSlower_s) continue;
    if (std::abs(legs_[i].to_rad - here_rad) < parameters_.arrived_rad) continue;
    order(i, here_rad, legs_[i].to_rad, now_s, end_s, false);
  }
}

bool Locomotion::group_landed() noexcept {
  if (landing_group_ == creep_.gait.groups) return false;
  for (std::size_t i = 0; i < kLegs; ++i) {
    if (creep_.gait.group_of[i] == landing_group_ && !legs_[i].landed) return false;
  }
  return true;
}

// A group of a creep has landed: all feet are down, and the body may roll until the next lifts off.
void Locomotion::roll_body() noexcept {
  const bool rolls = ((creep_.rolls_after >> landing_group_) & 1) != 0;
  ++landing_group_;
  if (!rolls) return;
  const int next = landing_group_ % creep_.gait.groups;
  const Events& events = next == 0 ? schedule_.next() : schedule_.current();
  double start_s = max_plus::kEps;
  double end_s = max_plus::kEps;
  for (std::size_t i = 0; i < kLegs; ++i) {
    if (creep_.gait.group_of[i] == landing_group_ - 1) {
      start_s = std::max(start_s, schedule_.current().touchdown_s[i]);
    }
    if (creep_.gait.group_of[i] == next) end_s = std::max(end_s, events.lift_off_s[i]);
  }
  for (std::size_t i = 0; i < kLegs; ++i) {
    if (!in_service(i)) continue;
    const double from_rad = wrap_rad(legs_[i].to_rad);
    const double to_rad = creep_rad(creep_, i, next, legs_[i].half_sweep_rad, offset_rad_);
    if (std::abs(to_rad - from_rad) <= kStill_rad) continue;  // it only steps on the spot
    order(i, from_rad, to_rad, start_s, end_s, false);
  }
}

bool Locomotion::landed(double now_s) noexcept {
  bool all = true;
  for (std::size_t i = 0; i < kLegs; ++i) {
    if (!targets_[i].swing) continue;
    if (swing_over(i, now_s)) {
      touch_down(i);
    } else {
      all = false;
    }
  }
  return all;
}

}  // namespace lss::gnc::zebro
