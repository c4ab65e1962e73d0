#pragma once

// Rocks on the ground under D.I.A.N.A. Ardito: caps of hard spheres, at most one in a square metre,
// determined by the seed. SI units, the world frame of terrain.h. Pure functions after
// construction; any thread.

#include <optional>

#include "tools/lss-sim/ardito/terrain.h"

namespace lss::sim::ardito {

struct Rock {
  double x_m = 0, y_m = 0;
  double height_m = 0;  // above the ground
  double radius_m = 0;  // of its sphere
};

class Rocks {
 public:
  // share: of the square metres that have one; 0: none.
  Rocks(double share, unsigned seed) : share_(share), seed_(seed) {}

  // Of the square metre whose corner is (column, row); none within kClear_m of the start.
  std::optional<Rock> at(int column, int row) const;
  // The surface point next to a wheel's centre, of the rock that is nearest to it; none: all are
  // farther than kReach_m.
  std::optional<GroundPoint> nearest(double x_m, double y_m, double z_m,
                                     const Terrain& terrain) const;

  static constexpr double kLeast_m = 0.01, kMost_m = 0.06;  // heights: most of them are low
  static constexpr double kClear_m = 1.5;
  static constexpr double kReach_m = 0.3;  // level distance of centres

 private:
  double share_;
  unsigned seed_;
};

}  // namespace lss::sim::ardito
