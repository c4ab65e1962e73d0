#pragma once

// D.I.A.N.A. Ardito on level ground, as pure rolling without rigid bodies: a hundredth of their
// cost, for slow machines. Driven wheels turn at their own speed. The body's motion is the mean of
// the treads' motions, weighted by the pull that each can give. Wheels that are not driven roll
// freely. No suspension, no terrain, no load transfer. Used by one thread (physics). One step is 1
// ms.

#include "tools/lss-sim/ardito/rover.h"

namespace lss::sim::ardito {

class KinematicRover final : public RoverPlant {
 public:
  explicit KinematicRover(double gravity_m_s2);

  void step(const std::array<ShaftDrive, kWheels>& wheels,
            const std::array<ShaftDrive, kSteered>& steering) override;
  double slip_m_s(std::size_t wheel) const override;
  Suspension suspension() const override { return {}; }
  BodyState body() const override;

 private:
  double steering_rad(std::size_t wheel) const;
  double ground_m_s(std::size_t wheel) const;  // under a wheel, in its plane
  void agree(const std::array<ShaftDrive, kWheels>& wheels);

  double load_N_ = 0;
  Eigen::Vector3d rate_ = Eigen::Vector3d::Zero();  // of the body: ahead, left (m/s), yaw (rad/s)
  double x_m_ = 0, y_m_ = 0, yaw_rad_ = 0;
  double pull_Nm_ = 0;  // of each wheel, that changes the body's speed
};

}  // namespace lss::sim::ardito
