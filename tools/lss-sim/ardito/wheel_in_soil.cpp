#include "tools/lss-sim/ardito/wheel_in_soil.h"

#include <algorithm>
#include <cmath>

#include "tools/lss-sim/ardito/rover.h"

namespace lss::sim::ardito {
namespace {

constexpr soil::Wheel kWheel = {.radius_m = dimensions::kWheelRadius_m, .width_m = kWheelWidth_m};
constexpr double kDeepest_m = 0.9 * kWheel.radius_m, kShallowest_m = 1e-4;
constexpr double kLeastLoad_N = 1;
// Shear is in proportion to the slip below this one. It is at least this share of the load times
// the slip: rim and ground move together somewhere near, not exactly at slip 0.
constexpr double kLeastSlip = 0.05, kLeastShear = 0.1;
constexpr double kMostShare = 1.5;  // of a load above what the ground carries at this depth
constexpr double kStanding_m_s = 1e-7;

// Soil in front is pushed this far before it yields; its damping as for an eighth of the rover.
constexpr double kYield_m = 0.0005;
constexpr double kPushed_kg = dimensions::kMass_kg / 8;

// A load sinks in within this time plus some times that in which it falls as deep, so that it does
// not bounce; over this length of sliding a wheel digs itself in.
constexpr double kSinking_s = 0.03, kSinkingFalls = 1.5, kDigging_m = 0.5;
constexpr double kSmoothing_s = 0.15;  // of the load that sinks: contacts shake
constexpr double kLeastPatch_m = 0.02, kFastest_m_s = 0.3;
constexpr double kExit = 1.1;         // of the rim in the ground, in front and behind the axle
constexpr double kTurningArm = 0.19;  // of a square patch's sides together: mean arm of its shear

// Depth at which the load is carried: it grows with the depth to the power of n + 1/2.
double carried_at_m(double depth_m, double load_N, double carries_N, const soil::Soil& soil) {
  if (load_N < kLeastLoad_N) return 0;
  const double share = std::clamp(load_N / carries_N, 0.1, 10.0);
  return depth_m * std::pow(share, 1 / (soil.exponent + 0.5));
}

double patch_m(double depth_m) { return std::sqrt(depth_m * (2 * kWheel.radius_m - depth_m)); }

}  // namespace

WheelInSoil::WheelInSoil(const soil::Soil& soil, double load_N)
    : soil_(soil), load_N_(load_N), sinkage_m_(soil::sinkage_m(soil, kWheel, load_N, 0)) {}

SoilGrip WheelInSoil::step(const WheelMotion& m) {
  const double over_m_s = std::hypot(m.ahead_m_s, m.left_m_s);
  const double fastest_m_s = std::max(std::abs(m.rim_m_s), over_m_s);
  const double sliding_m_s = std::hypot(m.rim_m_s - m.ahead_m_s, m.left_m_s);
  const bool pulls = std::abs(m.rim_m_s) >= std::abs(m.ahead_m_s);
  const double slip = fastest_m_s < kStanding_m_s ? 0 : std::min(sliding_m_s / fastest_m_s, 1.0);
  const double judged = std::max(slip, kLeastSlip);

  const double depth_m = std::max(sinkage_m_, kShallowest_m);
  const soil::WheelForces forces = soil::on_soil(soil_, kWheel, depth_m, pulls ? judged : -judged);
  const double load_N = std::max(m.load_N, kLeastLoad_N);
  const double share = std::min(load_N / forces.load_N, kMostShare);
  const double shear_N =
      std::max((pulls ? 1 : -1) * forces.thrust_N * share, kLeastShear * judged * load_N);

  SoilGrip grip;
  const double rim_m2 =
      kExit * std::acos(1 - depth_m / kWheel.radius_m) * kWheel.radius_m * kWheel.width_m;
  const double strength_N =
      soil_.factor * soil_.cohesion_Pa * rim_m2 + load_N * std::tan(soil_.friction_rad);
  grip.friction = strength_N / load_N;
  grip.compliance_m_sN = judged * fastest_m_s / shear_N;
  grip.rolling_Nm = std::max(0.0, std::abs(forces.torque_Nm) * share - shear_N * kWheel.radius_m);
  grip.turning_Nm = strength_N * kTurningArm * (patch_m(depth_m) + kWheel.width_m);

  const double most_N = m.load_N < kLeastLoad_N ? 0 : forces.resistance_N;
  const double stiffness_N_m = most_N / kYield_m;
  pushed_m_ = std::clamp(pushed_m_ + m.ahead_m_s * kStep_s, -kYield_m, kYield_m);
  const double damping_Ns_m = std::sqrt(stiffness_N_m * kPushed_kg);
  grip.resistance_N =
      -std::clamp(stiffness_N_m * pushed_m_ + damping_Ns_m * m.ahead_m_s, -most_N, most_N);

  grip.sinking_m_s = sink(m, sliding_m_s, forces);
  return grip;
}

// A load sinks in at once. Rolling comes to fresh ground, and sliding carries soil away: both lead
// to the depth that belongs to the slip.
double WheelInSoil::sink(const WheelMotion& m, double sliding_m_s,
                         const soil::WheelForces& forces) {
  const double depth_m = std::max(sinkage_m_, kShallowest_m);
  const double still_N = soil::on_soil(soil_, kWheel, depth_m, 0).load_N;
  load_N_ += (m.load_N - load_N_) * (kStep_s / kSmoothing_s);
  const double rest_m = carried_at_m(depth_m, load_N_, still_N, soil_);
  const double moving_m = carried_at_m(depth_m, load_N_, forces.load_N, soil_);
  const double renewed =
      std::abs(m.ahead_m_s) / std::max(patch_m(depth_m), kLeastPatch_m) + sliding_m_s / kDigging_m;
  double rate_m_s = (moving_m - sinkage_m_) * renewed;
  if (rest_m > sinkage_m_) {
    const double sinking_s = kSinking_s + kSinkingFalls * std::sqrt(depth_m / soil_.measured_m_s2);
    rate_m_s = std::max(rate_m_s, (rest_m - sinkage_m_) / sinking_s);
  }
  rate_m_s = std::clamp(rate_m_s, -kFastest_m_s, kFastest_m_s);
  const double before_m = sinkage_m_;
  sinkage_m_ = std::clamp(sinkage_m_ + rate_m_s * kStep_s, 0.0, kDeepest_m);
  return (sinkage_m_ - before_m) / kStep_s;
}

}  // namespace lss::sim::ardito
