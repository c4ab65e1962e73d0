#pragma once

// Lunar Zebro as geometry and statics, without inertia: a thousand times faster than rigid bodies,
// and in steps of any length. Each leg turns as ordered by its servo unless the load exceeds its
// torque. The body lies on the legs, or corners of its belly, that carry its weight; it moves as
// these roll on the ground without slip, by least squares, weighted by load, when they disagree.
// Level ground or a slope. Not modelled: falling and bouncing, slipping of the whole robot, stones,
// legs that touch the belly's edge. Angles of roll and pitch are small. Constructed once, then
// nothing allocates.

#include "tools/lss-sim/zebro/plant.h"

namespace lss::sim::zebro {

class KinematicRobot final : public Plant {
 public:
  // The robot lies on its belly, as Robot does with the same terrain. Throws std::invalid_argument
  // for a terrain with rocks.
  KinematicRobot(const TerrainOptions& terrain, double step_s);

  void step(const std::array<ShaftDrive, kLegs>& drives) override;

  const std::array<ShaftState, kLegs>& shafts() const override { return shafts_; }
  BodyState body() const override;

 private:
  static constexpr int kPoints = kLegs + 4;  // that may carry load: legs, and corners of the belly
  using Support = std::array<int, 3>;

  // A point that may touch the ground, relative to the body's centre: ahead, left, minimum depth of
  // the ground there; and the distance that the body rolls ahead on it per radian.
  struct Point {
    double x_m = 0, y_m = 0, depth_m = 0, roll_m = 0;
  };
  // The ground as a plane under the body; its slopes are the body's pitch, nose up, and roll, left
  // up.
  struct Ground {
    double depth_m = 0, ahead = 0, left = 0;
    double lacks_m(const Point& p) const {
      return p.depth_m - (depth_m + ahead * p.x_m + left * p.y_m);
    }
  };

  void roll();
  double twist(const std::array<double, 3>& weight, const std::array<double, 3>& rolls_m_s);
  void reach();
  void settle();
  bool lie_on(const Support& support, double load_x_m);
  void load();

  TerrainOptions terrain_;
  double step_s_;
  double grade_;  // of the slope
  std::array<ShaftState, kLegs> shafts_{};
  std::array<Point, kPoints> points_{};
  Support support_{};               // the three points that carry
  std::array<double, 3> share_{};   // of the weight, on each
  std::array<double, 3> thrust_{};  // of the ground ahead on each, as a share of the weight
  Ground ground_{};
  double x_m_ = 0, y_m_ = 0, yaw_rad_ = 0;  // on the slope
  double ahead_m_s_ = 0, left_m_s_ = 0, up_m_s_ = 0, nose_up_rad_s_ = 0;
};

}  // namespace lss::sim::zebro
