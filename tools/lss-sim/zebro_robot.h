#pragma once

// Lunar Zebro's body, legs and ground as rigid bodies (DART): what turning six shafts does to the
// robot. Frames: world x forward along the start heading, y left, z up; body the same, origin at
// its centre. Shaft angles: 0 = leg straight down, growing with forward rotation, unbounded. Legs
// LF, RF, LM, RM, LH, RH. Used by one thread (physics). One step is 1 ms and takes about 0.1 ms.

#include <Eigen/Geometry>
#include <array>
#include <memory>

namespace lss::sim::zebro {

inline constexpr int kLegs = 6;
inline constexpr double kStep_s = 0.001;
inline constexpr double kHipHeightLying_m = 0.025;  // hip above the underside of the body

struct TerrainOptions {
  double gravity_m_s2 = 1.625;
  double slope_rad = 0;  // positive: uphill ahead
  bool rocks = false;
  double friction = 0.8;
  double scatter_rad = 0.35;  // legs boot at up to this from stowed
  unsigned seed = 1;          // of the legs' angles at boot and of the rocks
};

// What the gear does with its shaft in one step: turns it at this speed as far as the torque
// suffices.
struct ShaftDrive {
  double velocity_rad_s = 0;
  double torque_limit_Nm = 0;
};

struct ShaftState {
  double angle_rad = 0;
  double velocity_rad_s = 0;
  double torque_Nm = 0;  // that the gear gave in the last step
};

struct BodyState {
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  Eigen::Quaterniond attitude = Eigen::Quaterniond::Identity();  // body to world
  Eigen::Vector3d velocity_m_s = Eigen::Vector3d::Zero();
};

class Robot {
 public:
  // The robot lies on its belly, its legs off the ground at angles that nobody knows.
  explicit Robot(const TerrainOptions& terrain);
  ~Robot();
  Robot(const Robot&) = delete;
  Robot& operator=(const Robot&) = delete;

  void step(const std::array<ShaftDrive, kLegs>& drives);

  const std::array<ShaftState, kLegs>& shafts() const { return shafts_; }
  BodyState body() const;

 private:
  struct World;
  std::unique_ptr<World> world_;
  std::array<ShaftState, kLegs> shafts_{};
};

}  // namespace lss::sim::zebro
