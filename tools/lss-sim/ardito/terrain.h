#pragma once

// The ground under D.I.A.N.A. Ardito as a height over the plane: flat, hills or rough, infinite and
// determined by the seed. SI units, world frame x forward at the start, y left, z up. Pure
// functions after construction; any thread.

#include <array>
#include <cmath>
#include <cstddef>

namespace lss::sim::ardito {

enum class Ground {
  flat,
  hills,  // smooth, wavelengths of 5 to 12 m, slopes to about 12 deg
  rough   // lower hills, with bumps of 0.7 to 2 m length and some centimetres height
};

struct GroundPoint {
  double x_m = 0, y_m = 0, z_m = 0;
  std::array<double, 3> normal{0, 0, 1};  // unit length, upwards
};

// A sum of sine waves with directions, lengths and phases from the seed; level around the start.
class Terrain {
 public:
  Terrain(Ground ground, unsigned seed);

  double height_m(double x_m, double y_m) const;
  // The point of the ground next to a wheel's centre: found by iteration, exact to micrometres for
  // wheels of 150 mm, whose curvature is more than twice that of any bump. Begins at `last`.
  GroundPoint nearest(double x_m, double y_m, double z_m, const GroundPoint& last) const;

 private:
  struct Wave {
    double x_rad_m, y_rad_m, phase_rad, amplitude_m;
  };
  struct Value {
    double height_m, slope_x, slope_y;
  };

  Value at(double x_m, double y_m) const;
  void add_wave(double length_m, double amplitude_m, double direction_rad, double phase_rad);

  static constexpr std::size_t kMostWaves = 16;
  static constexpr double kLevel_m = 1.0, kFull_m = 3.0;  // from the start
  std::array<Wave, kMostWaves> waves_{};
  std::size_t count_ = 0;
};

}  // namespace lss::sim::ardito
