#pragma once

// A robot with six C-shaped legs on soil that gives way: its body is a rigid body on legs without
// mass, and the forces on legs and underside are those of granular resistive force theory
// (tools/lss-sim/soil/resistive.h). The surface stays as it was: no ruts, no stones. Legs are
// strips along an arc; their edges and the body's sides feel nothing. An overloaded leg stands
// still, as in kinematic.h. A patch is met by pieces of its legs, each where it is, and by the
// underside where one of these legs is nearest, on the centre line where both sides' are. Lunar
// Zebro by default; other robots for validation. Used by one thread (physics). Nothing allocates
// after construction.

#include <vector>

#include "tools/lss-sim/soil/patch.h"
#include "tools/lss-sim/soil/resistive.h"
#include "tools/lss-sim/soil/soil.h"
#include "tools/lss-sim/zebro/plant.h"

namespace lss::sim::zebro {

struct RobotShape {
  double mass_kg = kMass_kg;
  double length_m = kBodyLength_m, width_m = kBodyWidth_m;
  double hip_height_m = kHipHeightLying_m;                      // above the underside
  double leg_diameter_m = kLegDiameter_m, leg_width_m = 0.020;  // as built (Zebro thesis B.3.2)
  // Of the arc from hip to toe, which are a diameter apart, times half of that. 1: a half circle
  // whose convex side goes first; -1: whose hollow side does. Not 0: for a flat leg almost 0.
  double leg_curvature = 1;
  std::array<double, kLegs> hip_x_m = std::to_array(kHipX_m), hip_y_m = std::to_array(kHipY_m);
};

class SoilRobot final : public Plant {
 public:
  // The robot lies on its belly, as Robot does with the same terrain, whose soil must be set.
  // Throws std::invalid_argument for a terrain with rocks.
  SoilRobot(const TerrainOptions& terrain, double step_s, const RobotShape& shape = {});

  void step(const std::array<ShaftDrive, kLegs>& drives) override;

  const std::array<ShaftState, kLegs>& shafts() const override { return shafts_; }
  BodyState body() const override;
  const std::array<LegInSoil, kLegs>& legs_in_soil() const override { return in_soil_; }

 private:
  static constexpr int kPieces = 32;             // of a leg's arc
  static constexpr int kAlong = 8, kAcross = 5;  // of the underside
  using Twist = Eigen::Matrix<double, 6, 1>;     // velocity, then rate of turn; slope's axes

  // A piece of the robot in the soil.
  struct Piece {
    int leg;                   // -1: underside
    Eigen::Vector3d arm_m;     // from the centre of mass
    Eigen::Vector3d turn_m_s;  // its velocity relative to the body
    double depth_m;
    double strength_N;  // area times depth times stiffness
    soil::Plate plate;
    Eigen::Vector3d force_N = Eigen::Vector3d::Zero();
  };

  // A patch, with the stiffness of its soil in this gravity.
  struct Soft {
    soil::Patch patch;
    double leg_Pa_m, belly_Pa_m;
  };

  double stiffness_Pa_m(int leg, const Eigen::Vector3d& arm_B_m, double x_m) const;
  double share_of_belly(const soil::Patch& patch, const Eigen::Vector3d& arm_B_m, double x_m) const;
  void immerse();
  void immerse(int leg, const Eigen::Vector3d& arm_B_m, const Eigen::Vector3d& normal_B,
               const Eigen::Vector3d& turn_B_m_s, double area_m2);
  Twist pushes(const Twist& twist, Eigen::Matrix<double, 6, 6>* slope);
  void move();
  void feel();

  TerrainOptions terrain_;
  RobotShape shape_;
  double step_s_;  // inner
  int steps_;      // inner, in one step
  double stiffness_leg_Pa_m_, stiffness_belly_Pa_m_;
  std::vector<Soft> soft_;
  Eigen::Vector3d gravity_m_s2_;  // in the slope's axes
  Eigen::Vector3d inertia_kg_m2_;
  std::array<ShaftState, kLegs> shafts_{};
  std::array<LegInSoil, kLegs> in_soil_{};
  Eigen::Vector3d position_m_;
  Eigen::Quaterniond attitude_ = Eigen::Quaterniond::Identity();
  Twist twist_ = Twist::Zero();
  Eigen::Matrix3d axes_ = Eigen::Matrix3d::Identity();  // of the motion: ahead, left, up
  std::vector<Piece> pieces_;
};

}  // namespace lss::sim::zebro
