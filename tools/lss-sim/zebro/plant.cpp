#include "tools/lss-sim/zebro/plant.h"

#include <algorithm>
#include <cmath>
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

void turn(std::array<ShaftState, kLegs>& shafts, const std::array<ShaftDrive, kLegs>& drives,
          double step_s) {
  for (std::size_t i = 0; i < drives.size(); ++i) {
    ShaftState& shaft = shafts[i];
    const bool against = shaft.torque_Nm * drives[i].velocity_rad_s > 0;
    const bool stalled = against && std::abs(shaft.torque_Nm) > drives[i].torque_limit_Nm;
    shaft.velocity_rad_s = stalled ? 0 : drives[i].velocity_rad_s;
    shaft.angle_rad += shaft.velocity_rad_s * step_s;
  }
}

}  // namespace lss::sim::zebro
