#include "tools/lss-sim/ardito/terrain.h"

#include <algorithm>
#include <numbers>
#include <random>

namespace lss::sim::ardito {
namespace {

constexpr double kTurn_rad = 2 * std::numbers::pi;

}  // namespace

Terrain::Terrain(Ground ground, unsigned seed) {
  if (ground == Ground::flat) return;
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> direction(0, kTurn_rad), phase(0, kTurn_rad), share(0, 1);
  const double hills = ground == Ground::hills ? 1.0 : 0.4;
  for (int i = 0; i < 5; ++i) {
    const double length_m = 5 + 7 * (i + share(random)) / 5;
    add_wave(length_m, hills * 0.012 * length_m, direction(random), phase(random));
  }
  if (ground == Ground::hills) return;
  for (int i = 0; i < 10; ++i) {
    const double length_m = 0.7 + 1.3 * (i + share(random)) / 10;
    add_wave(length_m, 0.0065 * length_m, direction(random), phase(random));
  }
}

void Terrain::add_wave(double length_m, double amplitude_m, double direction_rad,
                       double phase_rad) {
  const double wave_rad_m = kTurn_rad / length_m;
  waves_[count_++] = {wave_rad_m * std::cos(direction_rad), wave_rad_m * std::sin(direction_rad),
                      phase_rad, amplitude_m};
}

Terrain::Value Terrain::at(double x_m, double y_m) const {
  Value value{0, 0, 0};
  const double from_m = std::hypot(x_m, y_m);
  const double t = std::clamp((from_m - kLevel_m) / (kFull_m - kLevel_m), 0.0, 1.0);
  if (count_ == 0 || t == 0) return value;
  for (std::size_t i = 0; i < count_; ++i) {
    const Wave& wave = waves_[i];
    const double angle_rad = wave.x_rad_m * x_m + wave.y_rad_m * y_m + wave.phase_rad;
    const double slope = wave.amplitude_m * std::cos(angle_rad);
    value.height_m += wave.amplitude_m * std::sin(angle_rad);
    value.slope_x += slope * wave.x_rad_m;
    value.slope_y += slope * wave.y_rad_m;
  }
  if (t == 1) return value;
  const double blend = t * t * (3 - 2 * t);
  const double steeper_1_m = 6 * t * (1 - t) / (kFull_m - kLevel_m);
  value.slope_x = blend * value.slope_x + steeper_1_m * x_m / from_m * value.height_m;
  value.slope_y = blend * value.slope_y + steeper_1_m * y_m / from_m * value.height_m;
  value.height_m *= blend;
  return value;
}

double Terrain::height_m(double x_m, double y_m) const { return at(x_m, y_m).height_m; }

// The line from the ground point to the centre is the normal there: q = c + (c_z - h(q)) grad h(q).
GroundPoint Terrain::nearest(double x_m, double y_m, double z_m, const GroundPoint& last) const {
  GroundPoint point = last;
  Value value = at(point.x_m, point.y_m);
  for (int i = 0; i < 4 && count_ > 0; ++i) {
    point.x_m = x_m + (z_m - value.height_m) * value.slope_x;
    point.y_m = y_m + (z_m - value.height_m) * value.slope_y;
    value = at(point.x_m, point.y_m);
  }
  if (count_ == 0) {
    point.x_m = x_m;
    point.y_m = y_m;
  }
  point.z_m = value.height_m;
  const double length =
      std::sqrt(1 + value.slope_x * value.slope_x + value.slope_y * value.slope_y);
  point.normal = {-value.slope_x / length, -value.slope_y / length, 1 / length};
  return point;
}

}  // namespace lss::sim::ardito
