#pragma once

// The rover in physics with its shafts turned directly, for tests.

#include <algorithm>
#include <array>
#include <cmath>

#include "tests/support/cpu_time.h"
#include "tools/lss-sim/ardito/rover.h"

namespace lss::sim::ardito {

class Driver {
 public:
  explicit Driver(const RoverOptions& options) : rover(options) {}

  // Wheels at these speeds of their treads, after a ramp of 0.5 s; steering at these angles.
  void run(double seconds) {
    for (long i = std::lround(seconds / kStep_s); i > 0; --i) {
      std::array<ShaftDrive, kWheels> drives;
      for (std::size_t w = 0; w < kWheels; ++w) {
        const double wanted = treads_m_s[w] / dimensions::kWheelRadius_m;
        speeds_[w] += std::clamp(wanted - speeds_[w], -0.01, 0.01);
        drives[w] = {speeds_[w], torque_Nm[w]};
      }
      std::array<ShaftDrive, kSteered> turns;
      for (std::size_t s = 0; s < kSteered; ++s) {
        const double error_rad = angles_rad[s] - rover.steering()[s].angle_rad;
        turns[s] = {std::clamp(20 * error_rad, -0.5, 0.5), 20};
      }
      rover.step(drives, turns);
    }
  }
  void drive(double speed_m_s) { treads_m_s.fill(speed_m_s); }
  double x_m() const { return rover.body().position_m.x(); }

  Rover rover;
  std::array<double, kWheels> treads_m_s{};
  std::array<double, kWheels> torque_Nm{15, 15, 15, 15, 15, 15};
  std::array<double, kSteered> angles_rad{};

 private:
  std::array<double, kWheels> speeds_{};
};

// Ackermann angles and speeds for a circle around a point `radius_m` to the right on the middle
// axle, worked out from the ground plan.
inline void follow_circle(Driver& driver, double radius_m, double rate_rad_s) {
  const double ahead_m[] = {dimensions::kFront_m, dimensions::kFront_m, 0, 0,
                            -dimensions::kRear_m, -dimensions::kRear_m};
  for (std::size_t wheel = 0; wheel < kWheels; ++wheel) {
    const double side_m =
        radius_m + (wheel % 2 == 0 ? dimensions::kTrack_m / 2 : -dimensions::kTrack_m / 2);
    const double angle_rad = -std::atan(ahead_m[wheel] / side_m);
    driver.treads_m_s[wheel] =
        std::copysign(std::hypot(ahead_m[wheel], side_m), side_m) * rate_rad_s;
    const auto* steered = std::ranges::find(kSteeredWheels, wheel);
    if (steered == kSteeredWheels.end()) continue;
    driver.angles_rad[static_cast<std::size_t>(steered - kSteeredWheels.begin())] = angle_rad;
  }
}

// Steers for `steering_s`, then drives round that circle.
inline void drive_circle(Driver& driver, double radius_m, double steering_s, double rate_rad_s,
                         double seconds) {
  follow_circle(driver, radius_m, 0);
  driver.run(steering_s);
  follow_circle(driver, radius_m, rate_rad_s);
  driver.run(seconds);
}

// CPU time of this thread for so long of it.
inline double cpu_s_of(Driver& driver, double seconds) {
  return testing_support::cpu_s_of([&] { driver.run(seconds); });
}

}  // namespace lss::sim::ardito
