#include "gnc/zebro/locomotion.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <type_traits>

#include "gnc/zebro/stability.h"
#include "idl/angles.h"

namespace lss::gnc::zebro {

static_assert(std::is_trivially_copyable_v<Locomotion>, "snapshots and replay copy it as bytes");

namespace {

constexpr double kUpright_rad = 0.52;  // 30 deg: a leg this near to straight down carries
// Share of the swing limit, for movements without a configured time.
constexpr double kShareOfLimit = 0.75;
constexpr double kLongestOrder_s = 60;  // a leg module counts its time in 16 bits of milliseconds
// Two frames: an order must not end before it is on the wire.
constexpr double kSoonest_s = 0.04;
// A little more than one revolution in three orders: the sense of a half turn would be ambiguous.
constexpr std::uint8_t kTurns = 3;
constexpr double kTurn_rad = 2 * kPi * 1.05 / kTurns;
constexpr double kBack_rad = 100 * kDegree;  // from the lying attitude to past the top

}  // namespace

Locomotion::Locomotion(const LocomotionParameters& parameters) noexcept
    : parameters_(parameters),
      ends_(stroke_ends(parameters)),
      times_(footing(0, parameters).times),
      sweep_rad_(parameters.sweep_rad),
      offset_rad_(parameters.offset_rad),
      can_row_(rowing_margin_m(0, parameters) >= kLeastMargin_m) {}

bool Locomotion::isolate(LegSet legs) noexcept {
  const bool possible = legs < 1 << kLegs && std::popcount(legs) <= kMostIsolated;
  if (progress_ == Progress::running || !possible) return false;
  if (legs == isolated_) return true;
  isolated_ = legs;
  dragging_.reset();
  const Footing f = footing(legs, parameters_);
  times_ = f.times;
  sweep_rad_ = f.sweep_rad;
  offset_rad_ = f.offset_rad;
  can_walk_ = can_walk_without(legs, parameters_);
  rows_ = legs != 0 && can_walk_ && !creeps_without(legs, parameters_);
  for (std::size_t i = 0; i < kLegs; ++i) {
    if (in_service(i)) continue;
    targets_[i].rotation = 0;
    targets_[i].swing = false;
    legs_[i].ordered = legs_[i].searching = false;
    legs_[i].top_s = 0;
  }
  return true;
}

bool Locomotion::configure(const LocomotionParameters& parameters) noexcept {
  if (progress_ == Progress::running) return false;
  parameters_ = parameters;
  times_ = footing(isolated_, parameters_).times;
  return true;
}

void Locomotion::begin(Motion motion) noexcept {
  motion_ = motion;
  progress_ = Progress::running;
  late_ = 0;
  calibration_tried_ = false;
  walk_changed_ = false;
  const bool walking = stage_ == Stage::step || stage_ == Stage::land;
  stage_ = walking ? Stage::land : Stage::decide;
}

void Locomotion::hold(double) noexcept {
  motion_ = Motion::hold;
  progress_ = Progress::done;
  stage_ = Stage::rest;
  for (LegTarget& target : targets_) {
    target.rotation = 0;
    target.swing = false;
  }
}

void Locomotion::stand_up(double) noexcept { begin(Motion::stand_up); }
void Locomotion::finish_step(double) noexcept {
  const bool rises = rows_ && stage_ == Stage::push && progress_ == Progress::running;
  begin(Motion::finish_step);
  if (rises) stage_ = Stage::push;  // ends where the step shall end
}
void Locomotion::lay_down(double) noexcept { begin(Motion::lay_down); }
void Locomotion::stow(double) noexcept { begin(Motion::stow); }

void Locomotion::walk(double, const WalkRequest& request) noexcept {
  const bool steps_off = walks();
  request_ = request;
  const bool under_way = motion_ == Motion::walk && progress_ == Progress::running;
  if (!under_way) {
    begin(Motion::walk);
  } else if (stage_ == Stage::step) {
    walk_changed_ = true;
  } else if (isolated_ != 0 && stage_ == Stage::align && walks() != steps_off) {
    stage_ = Stage::decide;
  }  // else it is settling, and then walks by the last request
}

void Locomotion::update(double now_s, const std::array<LegMeasured, kLegs>& measured) noexcept {
  sense(now_s, measured);
  // A stage without work ends at once; no motion has more stages than this.
  constexpr int kMostStages = 10;
  for (int i = 0; i < kMostStages && progress_ == Progress::running; ++i) {
    if (!run_stage(now_s)) break;
  }
}

void Locomotion::sense(double now_s, const std::array<LegMeasured, kLegs>& measured) noexcept {
  PerLeg<double> last_rad{};
  PerLeg<bool> comparable{};
  PerLeg<bool> found{};
  for (std::size_t i = 0; i < kLegs; ++i) {
    Leg& leg = legs_[i];
    const bool was_usable = leg.usable;
    leg.known = measured[i].known && std::isfinite(measured[i].angle_rad);
    found[i] = leg.known && measured[i].calibrated && !leg.calibrated;
    if (leg.known) leg.calibrated = measured[i].calibrated;
    leg.usable = leg.known && measured[i].calibrated;
    if (leg.known) leg.measured_rad = wrap_rad(measured[i].angle_rad);
    if (leg.known && targets_[i].rotation == 0) {  // no order: it shall stay where it is
      leg.from_rad = leg.to_rad = targets_[i].angle_rad = leg.measured_rad;
    }
    last_rad[i] = leg.estimate_rad;
    leg.estimate_rad = leg.usable ? leg.measured_rad : wrap_rad(reference_rad(i, now_s));
    if (leg.usable && in_service(i)) leg.hangs_rad = leg.measured_rad;
    comparable[i] = updated_ && leg.usable == was_usable;
  }
  if (updated_) dead_reckon(now_s, last_rad, comparable);
  last_update_s_ = now_s;
  updated_ = true;
  for (std::size_t i = 0; i < kLegs; ++i) {
    if (found[i]) order_again(i);
  }
}

// A leg passed its sensor on the way and its angle jumped to the true value, but its order used the
// old count: order the same angle in the same sense, from its true angle.
void Locomotion::order_again(std::size_t i) noexcept {
  const LegTarget target = targets_[i];
  const bool moves = progress_ == Progress::running && target.rotation != 0 && !arrived(i);
  if (!moves || stage_ == Stage::calibrate) return;
  const double from_rad = legs_[i].measured_rad;
  const double to_rad = target.rotation > 0 ? from_rad - fall_rad(from_rad, target.angle_rad)
                                            : from_rad + fall_rad(target.angle_rad, from_rad);
  order(i, from_rad, to_rad, last_update_s_, target.arrive_s, target.swing);
  if (target.swing && legs_[i].top_s == 0) {
    schedule_.postpone_touchdown(i, targets_[i].arrive_s);
  }
}

bool Locomotion::run_stage(double now_s) noexcept {
  switch (stage_) {
    case Stage::rest: return false;
    case Stage::decide:
      if (walks() && upright()) choose_rowing();
      enter(first_stage(), now_s);
      return true;
    case Stage::land:
      if (!landed(now_s)) return false;
      stage_ = Stage::decide;
      return true;
    case Stage::calibrate:
      if (!calibration_over(now_s)) return false;
      stage_ = Stage::decide;
      return true;
    case Stage::step: step(now_s); return stage_ != Stage::step;
    default:
      if (!ordered_legs_arrived(now_s)) return false;
      if (walks() && (stage_ == Stage::push || stage_ == Stage::align)) choose_rowing();
      enter(stage_after(stage_), now_s);
      return true;
  }
}

Locomotion::Stage Locomotion::first_stage() const noexcept {
  if (motion_ == Motion::walk || motion_ == Motion::finish_step) {
    return rows_ && !upright() ? Stage::lift : Stage::align;
  }
  // A standing robot does not turn a leg without a reference only to lie down; it is searched when
  // standing up.
  bool lost = false;
  for (std::size_t i = 0; i < kLegs; ++i) lost |= in_service(i) && !legs_[i].usable;
  const bool stands = upright();
  if (lost && !calibration_tried_ && (motion_ == Motion::stand_up || !stands)) {
    return Stage::calibrate;
  }
  return stands ? Stage::align : Stage::lift;
}

Locomotion::Stage Locomotion::stage_after(Stage stage) const noexcept {
  const bool goes_down = motion_ == Motion::lay_down || motion_ == Motion::stow;
  if (stage == Stage::lift && !goes_down) return Stage::push;
  if (stage == Stage::align && goes_down) return Stage::lower;
  if (stage == Stage::align && walks()) return rows_ ? Stage::sink : Stage::step;
  if (stage == Stage::push && walks()) return rows_ ? Stage::sink : Stage::align;
  if (stage == Stage::sink) return Stage::lift;
  return Stage::rest;
}

void Locomotion::enter(Stage stage, double now_s) noexcept {
  const Stage before = stage_;
  stage_ = stage;
  stage_due_s_ = now_s;
  for (Leg& leg : legs_) leg.ordered = false;
  switch (stage) {
    case Stage::rest: progress_ = Progress::done; break;
    case Stage::calibrate:
      calibration_tried_ = true;
      search_ = Search::back;
      begin_calibration(now_s);
      break;
    case Stage::step: begin_stepping(now_s); break;
    case Stage::sink:
      if (before == Stage::push) ++steps_;
      if (before == Stage::align) begin_rowing();
      move_together(now_s);
      break;
    case Stage::lift:
      if (rows_ && walks()) choose_strokes();
      move_together(now_s);
      break;
    case Stage::align:
      if (walks() && isolated_ != 0 && !rows_ && !choose_gait()) {
        progress_ = Progress::failed;
        break;
      }
      move_together(now_s);
      break;
    default: move_together(now_s);
  }
}

// Travel of a leg in this stage, with its sense.
double Locomotion::travel_rad(std::size_t leg) const noexcept {
  const double from_rad = legs_[leg].estimate_rad;
  switch (stage_) {
    case Stage::lift:
      return rows_ && walks() ? swing_to_stroke_rad(leg) : lift_rad(from_rad, ends_.ahead_rad);
    case Stage::sink: return end_rad(stroke_of(leg), ends_) - from_rad;
    case Stage::lower: return ends_.ahead_rad - from_rad;
    case Stage::align: {
      const double to_rad =
          !walks() || rows_ ? 0
          : isolated_ != 0  ? creep_rad(creep_, leg, 0, requested_half_sweep_rad(leg), offset_rad_)
                            : offset_rad_;  // the middle of the stance
      return std::abs(from_rad) <= 2 * kUpright_rad ? to_rad - from_rad
                                                    : -fall_rad(from_rad, to_rad);
    }
    default:  // push; from behind by rowing only
      return from_rad < 0 && rows_ ? -from_rad : -fall_rad(from_rad, 0);
  }
}

void Locomotion::move_together(double now_s) noexcept {
  const bool rows = rows_ && walks() && stage_ != Stage::align;
  const double nominal_s = rows                     ? 0
                           : stage_ == Stage::lift  ? parameters_.lift_s
                           : stage_ == Stage::push  ? parameters_.stand_up_s
                           : stage_ == Stage::lower ? parameters_.lay_down_s
                                                    : parameters_.align_s;
  const double rate_rad_s =
      kShareOfLimit * parameters_.swing_limit_rad_s / (rows ? rowing_slowness() : 1);
  standing_ = stage_ == Stage::push || stage_ == Stage::align;
  PerLeg<double> travel{};
  double duration_s = nominal_s;
  for (std::size_t i = 0; i < kLegs; ++i) {
    if (!in_service(i)) continue;
    travel[i] = travel_rad(i);
    duration_s = std::max(duration_s, std::abs(travel[i]) / rate_rad_s);
  }
  if (rows) duration_s = std::min(duration_s, kLongestOrder_s);
  for (std::size_t i = 0; i < kLegs; ++i) {
    targets_[i].swing = false;
    if (!in_service(i)) continue;
    // A leg that is there needs no order, and must not get one: "forward" to an angle that it has
    // just passed is a full turn.
    const double to_rad = legs_[i].estimate_rad + travel[i];
    const bool rests = now_s >= targets_[i].arrive_s ||
                       std::abs(wrap_rad(targets_[i].angle_rad - to_rad)) < parameters_.arrived_rad;
    if (rests && std::abs(wrap_rad(travel[i])) < parameters_.arrived_rad) continue;
    const double from_rad = legs_[i].estimate_rad;
    order(i, from_rad, from_rad + travel[i], now_s, now_s + duration_s,
          rows && stage_ == Stage::lift);
  }
}

bool Locomotion::ordered_legs_arrived(double now_s) noexcept {
  if (now_s < stage_due_s_) return false;
  unsigned late = 0;
  for (std::size_t i = 0; i < kLegs; ++i) {
    if (legs_[i].ordered && legs_[i].usable && !arrived(i)) late |= 1u << i;
  }
  if (late != 0 && now_s > stage_due_s_ + parameters_.late_limit_s) fail(static_cast<LegSet>(late));
  return late == 0;
}

bool Locomotion::upright() const noexcept {
  PerLeg<bool> carries{};
  PerLeg<double> theta_rad{};
  for (std::size_t i = 0; i < kLegs; ++i) {
    if (!in_service(i)) continue;
    theta_rad[i] = legs_[i].usable ? legs_[i].estimate_rad : 0;
    carries[i] = legs_[i].usable ? std::abs(theta_rad[i]) < kUpright_rad : standing_;
  }
  return static_margin_m(carries, theta_rad, parameters_.leg_diameter_m, parameters_.hips) > 0;
}

void Locomotion::fail(LegSet late) noexcept {
  late_ = static_cast<LegSet>(late_ | late);
  progress_ = Progress::failed;
}

void Locomotion::begin_calibration(double now_s) noexcept {
  const std::uint8_t tripod = search_ == Search::first_tripod ? 0 : 1;
  for (std::size_t i = 0; i < kLegs; ++i) {
    legs_[i].searching = in_service(i) && !legs_[i].usable;
    if (!legs_[i].searching) continue;
    if (search_ == Search::back) {
      legs_[i].turns_left = 0;
      turn(i, kBack_rad, now_s);
    } else if (kTripod.group_of[i] == tripod) {
      legs_[i].turns_left = kTurns;
      turn_on(i, now_s);
    }
  }
}

void Locomotion::turn_on(std::size_t i, double now_s) noexcept {
  --legs_[i].turns_left;
  turn(i, -kTurn_rad, now_s);
}

void Locomotion::turn(std::size_t i, double way_rad, double now_s) noexcept {
  const double from_rad = legs_[i].known ? legs_[i].measured_rad : reference_rad(i, now_s);
  order(i, from_rad, from_rad + way_rad, now_s,
        now_s + std::abs(way_rad) / (kShareOfLimit * parameters_.swing_limit_rad_s), false);
}

bool Locomotion::calibration_over(double now_s) noexcept {
  bool over = true;
  for (std::size_t i = 0; i < kLegs; ++i) {
    Leg& leg = legs_[i];
    if (!leg.ordered) continue;
    if (leg.searching && leg.usable) {
      // Its angle has just jumped to the true value; its order used the old count. Park it in the
      // air.
      const double travel = fall_rad(leg.measured_rad, ends_.ahead_rad);
      leg.searching = false;
      order(i, leg.measured_rad, leg.measured_rad - travel, now_s,
            now_s + travel / (kShareOfLimit * parameters_.swing_limit_rad_s), false);
      over = false;
    } else if (now_s < targets_[i].arrive_s) {
      over = false;
    } else if (leg.searching && leg.turns_left > 0) {
      turn_on(i, now_s);
      over = false;
    } else if (leg.usable && !arrived(i)) {
      over = false;
      if (now_s > targets_[i].arrive_s + parameters_.late_limit_s)
        fail(static_cast<LegSet>(1u << i));
    }
  }
  if (!over || search_ == Search::second_tripod) return over;
  search_ = search_ == Search::back ? Search::first_tripod : Search::second_tripod;
  for (Leg& leg : legs_) leg.ordered = false;
  begin_calibration(now_s);
  return false;
}

void Locomotion::order(std::size_t i, double from_rad, double to_rad, double start_s,
                       double arrive_s, bool swing) noexcept {
  Leg& leg = legs_[i];
  leg.from_rad = from_rad;
  leg.to_rad = to_rad;
  leg.start_s = start_s;
  leg.ordered = true;
  LegTarget& target = targets_[i];
  target.angle_rad = wrap_rad(to_rad);
  // The module starts from its own reported angle, calibrated or not. Over a short way the leg may
  // have passed the target already, and the ordered sense would make a full turn: then go back.
  const double here_rad = leg.known ? leg.measured_rad : leg.estimate_rad;
  const double direct_rad = wrap_rad(to_rad - here_rad);
  const bool is_short = std::abs(to_rad - from_rad) < kPi / 2 && std::abs(direct_rad) < kPi / 2;
  const bool falls = is_short ? direct_rad < 0 : to_rad < from_rad;
  target.rotation = falls ? 1 : -1;
  const double way_rad = falls ? fall_rad(here_rad, to_rad) : fall_rad(to_rad, here_rad);
  target.arrive_s = std::max({arrive_s, last_update_s_ + way_rad / parameters_.swing_limit_rad_s,
                              last_update_s_ + kSoonest_s});
  target.swing = swing;
  ++target.segment;
  stage_due_s_ = std::max(stage_due_s_, target.arrive_s);
}

double Locomotion::reference_rad(std::size_t i, double now_s) const noexcept {
  const Leg& leg = legs_[i];
  const double duration_s = targets_[i].arrive_s - leg.start_s;
  if (now_s >= targets_[i].arrive_s || duration_s <= 0) return leg.to_rad;
  const double share = std::max(0.0, (now_s - leg.start_s) / duration_s);
  return leg.from_rad + share * (leg.to_rad - leg.from_rad);
}

bool Locomotion::arrived(std::size_t i) const noexcept {
  return std::abs(wrap_rad(legs_[i].measured_rad - targets_[i].angle_rad)) <
         parameters_.arrived_rad;
}

}  // namespace lss::gnc::zebro
