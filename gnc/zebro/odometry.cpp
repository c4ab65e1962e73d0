// Dead reckoning of Locomotion: the legs on the ground roll the body.

#include <algorithm>
#include <cmath>

#include "gnc/math.h"
#include "gnc/zebro/locomotion.h"

namespace lss::gnc::zebro {

namespace {
constexpr double kSpeedFilter_s = 1.0;
}

void Locomotion::reset_odometry() noexcept {
  distance_m_ = yaw_rad_ = 0;
  steps_ = 0;
}

void Locomotion::dead_reckon(double now_s, const PerLeg<double>& last_rad,
                             const PerLeg<bool>& comparable) noexcept {
  const double elapsed_s = now_s - last_update_s_;
  // A leg out of service that hangs below the belly props the body up, or drags.
  for (std::size_t i = 0; i < kLegs; ++i) {
    const double depth_m = hip_height_m(legs_[i].hangs_rad, parameters_.leg_diameter_m);
    if (!in_service(i) && depth_m > parameters_.belly_height_m)
      return reckon(drag(elapsed_s, last_rad, comparable), elapsed_s);
  }
  // Only angles at which a leg carries count: a leg that is still on its way down does not push.
  // Aligning does not count: legs ahead and legs behind slip against each other, and the body
  // hardly moves.
  double low_rad = 0;
  double high_rad = 0;
  if (stage_ == Stage::push || stage_ == Stage::lower || stage_ == Stage::sink) {
    high_rad = lowered_rad(parameters_.belly_height_m, parameters_.leg_diameter_m);
    low_rad = -math::acos(parameters_.belly_height_m / parameters_.leg_diameter_m);
  } else if (stage_ == Stage::step || stage_ == Stage::land) {
    high_rad = std::abs(offset_rad_) + kFurthestReach * sweep_rad_ / 2;
    low_rad = -high_rad;
  }

  struct Side {
    double advance_m = 0;
    int legs = 0;
  };
  std::array<Side, 2> sides{};
  for (std::size_t i = 0; i < kLegs; ++i) {
    if (targets_[i].swing || !comparable[i] || !in_service(i)) continue;
    const double from_rad = std::clamp(last_rad[i], low_rad, high_rad);
    const double to_rad = std::clamp(legs_[i].estimate_rad, low_rad, high_rad);
    Side& side = sides[is_left(static_cast<int>(i)) ? 0 : 1];
    side.advance_m += advance_m(to_rad, parameters_.leg_diameter_m) -
                      advance_m(from_rad, parameters_.leg_diameter_m);
    ++side.legs;
  }
  const double left_m = sides[0].legs > 0 ? sides[0].advance_m / sides[0].legs : 0;
  const double right_m = sides[1].legs > 0 ? sides[1].advance_m / sides[1].legs : 0;

  reckon({.ahead_m = (left_m + right_m) / 2, .yaw_rad = (left_m - right_m) / parameters_.track_m},
         elapsed_s);
}

// Legs out of service hang where they were last known to be.
Moved Locomotion::drag(double elapsed_s, const PerLeg<double>& last_rad,
                       const PerLeg<bool>& comparable) noexcept {
  PerLeg<double> from_rad{}, to_rad{};
  for (std::size_t i = 0; i < kLegs; ++i) {
    to_rad[i] = in_service(i) ? legs_[i].estimate_rad : legs_[i].hangs_rad;
    from_rad[i] = in_service(i) && comparable[i] ? last_rad[i] : to_rad[i];
  }
  return dragging_.step({.hips = parameters_.hips,
                         .leg_diameter_m = parameters_.leg_diameter_m,
                         .belly_height_m = parameters_.belly_height_m},
                        from_rad, to_rad, elapsed_s);
}

void Locomotion::reckon(const Moved& moved, double elapsed_s) noexcept {
  distance_m_ += moved.ahead_m;
  yaw_rad_ += moved.yaw_rad;
  if (elapsed_s > 0) {
    speed_m_s_ +=
        (moved.ahead_m / elapsed_s - speed_m_s_) * elapsed_s / (elapsed_s + kSpeedFilter_s);
  }
}

}  // namespace lss::gnc::zebro
