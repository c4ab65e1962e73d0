#include "tools/lss-sim/talaris/pad_in_soil.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace lss::sim::talaris {
namespace {

constexpr double kPad_m2 = std::numbers::pi * kPadRadius_m * kPadRadius_m;

// How far the ground gives way in a step: there the force of the leg, which falls by `leg_N_m`, is
// that of the ground, which does not fall.
template <class Ground>
double gives_way_m(double force_N, double leg_N_m, Ground&& ground_N) {
  double least_m = 0, most_m = force_N / leg_N_m;
  for (int i = 0; i < 40; ++i) {
    const double middle_m = (least_m + most_m) / 2;
    (force_N - leg_N_m * middle_m > ground_N(middle_m) ? least_m : most_m) = middle_m;
  }
  return most_m;
}

}  // namespace

PadInSoil::PadInSoil(const soil::Soil& soil, const Leg& leg, const Vector3& normal)
    : soil_(soil), leg_(leg), normal_(normal) {}

// The smaller dimension of a round plate in Bekker's formula is its radius.
double PadInSoil::carries_N(double depth_m) const {
  return kPad_m2 * soil::pressure_Pa(soil_, kPadRadius_m, depth_m);
}

double PadInSoil::carries_at_m(double load_N) const {
  return std::pow(load_N / carries_N(1), 1 / soil_.exponent);
}

double PadInSoil::holds_N(double load_N, double sheared_m) const {
  const double strength_N =
      soil_.factor * soil_.cohesion_Pa * kPad_m2 + load_N * std::tan(soil_.friction_rad);
  return strength_N * -std::expm1(-sheared_m / soil_.shear_m);
}

Vector3 PadInSoil::step(const LegEnd& end) {
  const double in_step_N_m = leg_.spring_N_m + leg_.damper_Ns_m / kStep_s;
  if (pad_m_) bent_m_ = end.into_m - depth_m_;
  if (end.into_m <= 0) depth_m_ = sheared_m_ = 0;
  // After the step, if nothing changes the velocity: a leg without load, and how far below the
  // bottom its pad would be.
  const double unloaded_m = leg_.damper_Ns_m / kStep_s / in_step_N_m * bent_m_;
  const Vector3 at_m = end.at_m + kStep_s * end.velocity_m_s;
  const double below_m =
      end.into_m - kStep_s * normal_.dot(end.velocity_m_s) - unloaded_m - depth_m_;
  if (end.into_m <= 0 || below_m <= 0) {
    bent_m_ = unloaded_m;
    pad_m_.reset();
    return Vector3::Zero();
  }
  double load_N = in_step_N_m * below_m;
  if (load_N > carries_N(depth_m_)) {
    const double sinks_m = gives_way_m(load_N, in_step_N_m,
                                       [&](double more_m) { return carries_N(depth_m_ + more_m); });
    depth_m_ += sinks_m;
    load_N -= in_step_N_m * sinks_m;
  }

  if (!pad_m_) pad_m_ = end.at_m;
  Vector3 pull_N = along(leg_.spring_N_m * (*pad_m_ - at_m) - leg_.damper_Ns_m * end.velocity_m_s);
  const double size_N = pull_N.norm();
  if (size_N > holds_N(load_N, sheared_m_)) {
    const double slides_m = gives_way_m(
        size_N, in_step_N_m, [&](double more_m) { return holds_N(load_N, sheared_m_ + more_m); });
    sheared_m_ += slides_m;
    *pad_m_ -= slides_m / size_N * pull_N;
    pull_N *= 1 - in_step_N_m * slides_m / size_N;
  }
  return load_N * normal_ + pull_N;
}

double PadInSoil::leg_J(const LegEnd& end) const {
  if (!pad_m_) return 0;
  const double pressed_m = std::max(end.into_m - depth_m_, 0.0);
  const double bent_m = along(end.at_m - *pad_m_).norm();
  return leg_.spring_N_m / 2 * (pressed_m * pressed_m + bent_m * bent_m);
}

}  // namespace lss::sim::talaris
