#include "gnc/zebro/rowing.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "gnc/math.h"
#include "gnc/zebro/locomotion.h"
#include "idl/angles.h"

namespace lss::gnc::zebro {

namespace {
constexpr double kClear_rad = 0.05;  // past the angle where the belly carries: no load on the leg
constexpr double kToe_rad = 50 * kDegree;
}  // namespace

// Ahead: halfway between the angle where the arc would touch the ground and the one where the toe
// would rise above the body, whose top is as far from the hips as its bottom.
StrokeEnds stroke_ends(const LocomotionParameters& p) noexcept {
  const double arc_rad = lowered_rad(p.belly_height_m, p.leg_diameter_m);
  const double above_rad = math::acos(-p.belly_height_m / p.leg_diameter_m);
  const double toe_rad = math::acos(p.belly_height_m / p.leg_diameter_m);
  return {.ahead_rad = std::max((arc_rad + above_rad) / 2, arc_rad + kClear_rad),
          .behind_rad = -(toe_rad + kClear_rad),
          .toe_rad = -std::min(toe_rad, kToe_rad)};
}

Stroke next_stroke(double& owed) noexcept {
  const double whole = std::clamp(std::round(owed), -1.0, 1.0);
  owed -= whole;
  return static_cast<Stroke>(whole);
}

double rowing_margin_m(LegSet isolated, const LocomotionParameters& p) noexcept {
  const double arc_rad = lowered_rad(p.belly_height_m, p.leg_diameter_m);
  const double toe_rad = stroke_ends(p).toe_rad;
  const std::array<std::array<double, 2>, 5> sides = {
      {{0, 0}, {arc_rad, arc_rad}, {arc_rad, toe_rad}, {toe_rad, arc_rad}, {toe_rad, toe_rad}}};
  double smallest_m = std::numeric_limits<double>::infinity();
  for (const std::array<double, 2>& side : sides) {
    PerLeg<bool> in_stance{};
    PerLeg<double> theta_rad{};
    for (std::size_t i = 0; i < kLegs; ++i) {
      in_stance[i] = !contains(isolated, i);
      theta_rad[i] = side[is_left(static_cast<int>(i)) ? 0 : 1];
    }
    smallest_m =
        std::min(smallest_m, static_margin_m(in_stance, theta_rad, p.leg_diameter_m, p.hips));
  }
  return smallest_m;
}

// ---- Locomotion

// Where the legs stand straight down, so that both ways to go on are possible. With legs out of
// service isolate() chooses.
void Locomotion::choose_rowing() noexcept {
  if (isolated_ == 0) rows_ = request_.rows && can_row_;
}

void Locomotion::begin_rowing() noexcept {
  owed_ = {};
  choose_strokes();
}

// Chooses the next strokes of the sides, for the requested walk.
void Locomotion::choose_strokes() noexcept {
  const SideSpeeds wanted = side_speeds(request_.direction, request_.heading_rad);
  owed_.left += wanted.left;
  owed_.right += wanted.right;
  strokes_ = {next_stroke(owed_.left), next_stroke(owed_.right)};
}

Stroke Locomotion::stroke_of(std::size_t leg) const noexcept {
  return strokes_[is_left(static_cast<int>(leg)) ? 0 : 1];
}

// Signed travel of a leg to its stroke, without moving the body.
double Locomotion::swing_to_stroke_rad(std::size_t leg) const noexcept {
  const double from_rad = legs_[leg].estimate_rad;
  const double to_rad = begin_rad(stroke_of(leg), ends_);
  return to_rad > 0 ? lift_rad(from_rad, to_rad) : -lift_rad(-from_rad, -to_rad);
}

// High is the speed of movements without a configured time.
double Locomotion::rowing_slowness() const noexcept {
  return request_.speed == Speed::high ? 1 : request_.speed == Speed::medium ? 2 : 4;
}

}  // namespace lss::gnc::zebro
