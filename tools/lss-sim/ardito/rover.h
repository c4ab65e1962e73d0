#pragma once

// The motion of D.I.A.N.A. Ardito from six wheels and four steering shafts: the interface of its
// plants, and chassis, rockers, bogies, steering and wheels on their ground as rigid bodies (DART);
// kinematic.h has the other. Frames: world x forward at the start, y left, z up; body the
// same, its origin at the thesis' centre of mass. Angles: wheels grow with forward rotation;
// steering to the left is positive; a rocker or bogie angle is positive when it lifts its front
// wheel (Ardito thesis 13, erratum on the frames). Wheels 1..6 are LF, RF, LM, RM, LR, RR; steering
// shafts belong to wheels 1, 2, 5, 6. Used by one thread (physics). One step is 1 ms.

#include <Eigen/Geometry>
#include <array>
#include <memory>
#include <optional>
#include <vector>

#include "tools/lss-sim/ardito/patch.h"
#include "tools/lss-sim/ardito/terrain.h"
#include "tools/lss-sim/frame/shaft.h"
#include "tools/lss-sim/soil/soil.h"

namespace lss::sim::ardito {

inline constexpr std::size_t kWheels = 6;
inline constexpr std::size_t kSteered = 4;
inline constexpr std::array<std::size_t, kSteered> kSteeredWheels = {0, 1, 4, 5};
inline constexpr double kStep_s = 0.001;

// Ardito thesis 14 (a = b = c, d, e, f) and 13.4 (the pivots). Both sections give the positions of
// the wheels, and they differ (erratum): the plan is that of section 14, which steering uses.
namespace dimensions {
inline constexpr double kTrack_m = 0.782;
inline constexpr double kFront_m = 0.612;   // ahead of the middle axle
inline constexpr double kRear_m = 0.587;    // behind it
inline constexpr double kCentre_m = 0.070;  // from the middle axle forward to the centre of mass
inline constexpr double kWheelRadius_m = 0.150;
inline constexpr double kMass_kg = 50;
}  // namespace dimensions

enum class StepSide { both, left, right };
enum class PlantKind { dart, kinematic };

struct RoverOptions {
  PlantKind plant = PlantKind::dart;
  Ground ground = Ground::flat;
  std::optional<soil::Soil> soil{};  // as measured, not in this gravity; unset: hard ground
  std::vector<Patch> patches{};      // in the soil; of several the last one counts
  double gravity_m_s2 = 9.81;
  double rocks = 0;            // share of the square metres with one (rocks.h), of hard ground
  double friction = 0.3;       // of hard ground
  double slope_rad = 0;        // uphill ahead
  double step_height_m = 0;    // a kerb across the way; 0: none
  double step_at_m = 1.5;      // distance of its edge from the start
  double step_length_m = 100;  // length of the raised ground
  StepSide step_side = StepSide::both;
  unsigned seed = 1;  // of the ground
};

struct BodyState {
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  Eigen::Quaterniond attitude = Eigen::Quaterniond::Identity();  // body to world
  Eigen::Vector3d velocity_m_s = Eigen::Vector3d::Zero();        // world
  Eigen::Vector3d velocity_B_m_s = Eigen::Vector3d::Zero();      // the same in body axes
  double yaw_rate_rad_s = 0;                                     // about the body's z
};

struct Suspension {
  double beta_rad = 0;  // left rocker; the right one has the opposite, but for the bar's twist
  double rho1_rad = 0, rho2_rad = 0;  // left and right bogie against their rockers
};

class RoverPlant {
 public:
  virtual ~RoverPlant() = default;

  virtual void step(const std::array<ShaftDrive, kWheels>& wheels,
                    const std::array<ShaftDrive, kSteered>& steering) = 0;

  const std::array<ShaftState, kWheels>& wheels() const { return wheels_; }
  const std::array<ShaftState, kSteered>& steering() const { return steering_; }
  const std::array<double, kWheels>& loads_N() const { return loads_N_; }  // on the ground
  // The speed of a wheel's tread minus that of its hub.
  virtual double slip_m_s(std::size_t wheel) const = 0;
  // Under the untouched surface; 0 on hard ground.
  virtual double sinkage_m(std::size_t) const { return 0; }
  virtual Suspension suspension() const = 0;
  virtual BodyState body() const = 0;

 protected:
  std::array<ShaftState, kWheels> wheels_{};
  std::array<ShaftState, kSteered> steering_{};
  std::array<double, kWheels> loads_N_{};
};

class Rover final : public RoverPlant {
 public:
  // The rover stands on its wheels at the origin. Throws std::invalid_argument when options
  // contradict each other.
  explicit Rover(const RoverOptions& options);
  ~Rover() override;
  Rover(const Rover&) = delete;
  Rover& operator=(const Rover&) = delete;

  void step(const std::array<ShaftDrive, kWheels>& wheels,
            const std::array<ShaftDrive, kSteered>& steering) override;
  double slip_m_s(std::size_t wheel) const override;
  double sinkage_m(std::size_t wheel) const override;
  Suspension suspension() const override;
  BodyState body() const override;

 private:
  struct World;
  std::unique_ptr<World> world_;
};

// Of hard ground: elastic wheels with grousers on firm sand, and of a contact patch that is turned
// in place.
inline constexpr double kRollingResistance = 0.06;
inline constexpr double kPatchRadius_m = 0.03;

}  // namespace lss::sim::ardito
