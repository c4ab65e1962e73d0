#pragma once

// The motion of Lunar Zebro from six shafts: the interface of its plants, and the robot's
// dimensions. Frames: world x forward along the start heading, y left, z up; body the same, origin
// at its centre. Shaft angles: 0 = leg straight down, growing with forward rotation, unbounded.
// Legs LF, RF, LM, RM, LH, RH. Used by one thread (physics).

#include <Eigen/Geometry>
#include <array>
#include <memory>
#include <numbers>
#include <optional>
#include <vector>

#include "tools/lss-sim/frame/shaft.h"
#include "tools/lss-sim/soil/patch.h"
#include "tools/lss-sim/soil/soil.h"

namespace lss::sim::zebro {

inline constexpr int kLegs = 6;
inline constexpr double kStep_s = 0.001;  // of the simulator, and the only one for rigid bodies
inline constexpr double kHipHeightLying_m = 0.025;  // hip above the underside of the body

// The body is a box with the hips at half its height; a leg is a half circle with a round tread.
inline constexpr double kMass_kg = 1.5;
inline constexpr double kBodyLength_m = 0.200, kBodyWidth_m = 0.130;
inline constexpr double kLegDiameter_m = 0.053;
inline constexpr double kTread_m = 0.004;  // radius
inline constexpr double kHipX_m[kLegs] = {0.080, 0.080, 0.0, 0.0, -0.080, -0.080};
inline constexpr double kHipY_m[kLegs] = {0.065, -0.065, 0.080, -0.080, 0.065, -0.065};

struct TerrainOptions {
  double gravity_m_s2 = 1.625;
  double slope_rad = 0;  // positive: uphill ahead
  bool rocks = false;
  double friction = 0.8;               // of hard ground
  std::optional<soil::Soil> soil{};    // unset: hard ground
  std::vector<soil::Patch> patches{};  // in the soil; of several the last one counts
  double scatter_rad = 0.35;           // legs boot at up to this from stowed
  unsigned seed = 1;                   // of the legs' angles at boot and of the rocks
};

struct BodyState {
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  Eigen::Quaterniond attitude = Eigen::Quaterniond::Identity();  // body to world
  Eigen::Vector3d velocity_m_s = Eigen::Vector3d::Zero();
};

// The leg angles at boot: near the stowed position for the flight, exact value unknown.
std::array<double, kLegs> boot_angles(const TerrainOptions& terrain);

// An overloaded shaft stands still. The load is that of the last step.
void turn(std::array<ShaftState, kLegs>& shafts, const std::array<ShaftDrive, kLegs>& drives,
          double step_s);

// How a leg is in the soil; 0 in the air and on hard ground.
struct LegInSoil {
  double sinkage_m = 0;  // of its deepest point
  double slip_m_s = 0;   // that point's speed to the rear through the soil
};

class Plant {
 public:
  virtual ~Plant() = default;
  virtual void step(const std::array<ShaftDrive, kLegs>& drives) = 0;
  virtual const std::array<ShaftState, kLegs>& shafts() const = 0;
  virtual BodyState body() const = 0;
  virtual const std::array<LegInSoil, kLegs>& legs_in_soil() const;
};

enum class PlantKind { dart, kinematic };

}  // namespace lss::sim::zebro
