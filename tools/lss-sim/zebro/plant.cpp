#include "tools/lss-sim/zebro/plant.h"

#include <algorithm>
#include <random>

namespace lss::sim::zebro {
namespace {

// Stowed is to the rear and up. Up to 262 deg legs keep clear of the ground; a wider scatter
// therefore moves its middle upwards.
constexpr double kStowed_rad = 235 * std::numbers::pi / 180;
constexpr double kLowest_rad = 262 * std::numbers::pi / 180;

}  // namespace

const std::array<LegInSoil, kLegs>& Plant::legs_in_soil() const {
  static constexpr std::array<LegInSoil, kLegs> kNone{};
  return kNone;
}

std::array<double, kLegs> boot_angles(const TerrainOptions& terrain) {
  std::mt19937 random(terrain.seed);
  const double middle_rad = std::min(kStowed_rad, kLowest_rad - terrain.scatter_rad);
  std::uniform_real_distribution<double> boot(middle_rad - terrain.scatter_rad,
                                              middle_rad + terrain.scatter_rad);
  std::array<double, kLegs> angles{};
  for (double& angle : angles) angle = boot(random);
  return angles;
}

}  // namespace lss::sim::zebro
