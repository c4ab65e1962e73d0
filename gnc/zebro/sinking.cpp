#include "gnc/zebro/sinking.h"

#include <algorithm>

#include "idl/angles.h"

namespace lss::gnc::zebro {
namespace {

// Ahead of the hip, where the arc is in soil whose surface is as high as the belly: after where it
// meets the surface, and deep in it.
constexpr double kHigh_rad[] = {3 * kDegree, 18 * kDegree};
constexpr double kLow_rad[] = {33 * kDegree, 53 * kDegree};
constexpr std::int64_t kLeastSamples = 3;
constexpr double kLeast_A = 0.005;  // modules report whole milliamperes; less is no soil

bool within(double theta_rad, const double (&range)[2]) noexcept {
  return theta_rad >= range[0] && theta_rad < range[1];
}

}  // namespace

void Sinking::Mean::add(double value) noexcept {
  sum += value;
  ++count;
}

bool Sinking::Flight::whole() const noexcept {
  return std::min({low.count, high.count, air.count}) >= kLeastSamples;
}

double Sinking::Flight::share() const noexcept {
  const double soil_A = low.value() - air.value();
  return soil_A < kLeast_A ? 0 : std::clamp((high.value() - air.value()) / soil_A, 0.0, 1.0);
}

bool Sinking::update(const PerLeg<Leg>& legs) noexcept {
  for (std::size_t i = 0; i < kLegs; ++i) {
    Flight& flight = under_way_[i];
    if (!legs[i].flies) {
      if (flight.whole()) {
        of_leg_[i] = flight.share();
        ++ended_[i];
      }
      flight = {};
      continue;
    }
    if (!legs[i].known) continue;
    const double theta_rad = wrap_rad(legs[i].theta_rad);
    if (within(belly_rad_ - theta_rad, kLow_rad)) flight.low.add(legs[i].current_A);
    if (within(belly_rad_ - theta_rad, kHigh_rad)) flight.high.add(legs[i].current_A);
    // As far behind, where the toe is above the belly: in the air at each depth, and the leg's own
    // weight is felt the same.
    if (within(belly_rad_ + theta_rad, kHigh_rad)) flight.air.add(legs[i].current_A);
  }
  if (std::ranges::min(ended_) == 0) return false;
  ended_ = {};
  shares_ = {1, 1};
  for (std::size_t i = 0; i < kLegs; ++i) {
    double& side = shares_[is_left(static_cast<int>(i)) ? 0 : 1];
    side = std::min(side, of_leg_[i]);
  }
  return true;
}

}  // namespace lss::gnc::zebro
