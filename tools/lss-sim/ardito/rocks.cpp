#include "tools/lss-sim/ardito/rocks.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace lss::sim::ardito {
namespace {

// splitmix64, by Sebastiano Vigna, public domain.
std::uint64_t next(std::uint64_t& state) {
  std::uint64_t z = state += 0x9e3779b97f4a7c15;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9;
  z = (z ^ (z >> 27)) * 0x94d049bb133111eb;
  return z ^ (z >> 31);
}

// 0 to 1.
double share(std::uint64_t& state) { return static_cast<double>(next(state) >> 11) * 0x1p-53; }

}  // namespace

std::optional<Rock> Rocks::at(int column, int row) const {
  std::uint64_t state = seed_;
  state = next(state) ^ static_cast<std::uint32_t>(column);
  state = next(state) ^ static_cast<std::uint32_t>(row);
  if (share(state) >= share_) return std::nullopt;
  const double x_m = column + share(state), y_m = row + share(state);
  if (std::hypot(x_m, y_m) < kClear_m) return std::nullopt;
  const double size = share(state);
  const double height_m = kLeast_m + (kMost_m - kLeast_m) * size * size;
  const double base_m = height_m * (1 + share(state));  // radius on the ground
  const double radius_m = (base_m * base_m + height_m * height_m) / (2 * height_m);
  return Rock{.x_m = x_m, .y_m = y_m, .height_m = height_m, .radius_m = radius_m};
}

std::optional<GroundPoint> Rocks::nearest(double x_m, double y_m, double z_m,
                                          const Terrain& terrain) const {
  std::optional<GroundPoint> found;
  if (share_ <= 0) return found;
  double least_m = kReach_m;
  const auto square = [](double at_m) { return static_cast<int>(std::floor(at_m)); };
  for (int column = square(x_m - kReach_m); column <= square(x_m + kReach_m); ++column) {
    for (int row = square(y_m - kReach_m); row <= square(y_m + kReach_m); ++row) {
      const std::optional<Rock> rock = at(column, row);
      if (!rock || std::hypot(x_m - rock->x_m, y_m - rock->y_m) > kReach_m) continue;
      const double centre_m =
          terrain.height_m(rock->x_m, rock->y_m) + rock->height_m - rock->radius_m;
      const std::array<double, 3> from = {x_m - rock->x_m, y_m - rock->y_m, z_m - centre_m};
      const double far_m = std::hypot(from[0], from[1], from[2]);
      if (far_m - rock->radius_m >= least_m) continue;
      least_m = far_m - rock->radius_m;
      found.emplace();
      found->normal = {from[0] / far_m, from[1] / far_m, from[2] / far_m};
      found->x_m = rock->x_m + rock->radius_m * found->normal[0];
      found->y_m = rock->y_m + rock->radius_m * found->normal[1];
      found->z_m = centre_m + rock->radius_m * found->normal[2];
    }
  }
  return found;
}

}  // namespace lss::sim::ardito
