// The rover that only rolls goes where the one in physics goes, on level ground.

#include "tools/lss-sim/ardito/kinematic.h"

#include <gtest/gtest.h>

#include <cmath>

namespace lss::sim::ardito {
namespace {

constexpr double kDrives_Nm = 15, kOpen_Nm = 0.5;
constexpr double kRadius_m = dimensions::kWheelRadius_m;

struct Way {
  std::array<double, kWheels> tread_m_s{};
  std::array<double, kSteered> angle_rad{};
  std::array<double, kWheels> torque_Nm{kDrives_Nm, kDrives_Nm, kDrives_Nm,
                                        kDrives_Nm, kDrives_Nm, kDrives_Nm};
};

Way ahead(double speed_m_s) {
  Way way;
  way.tread_m_s.fill(speed_m_s);
  return way;
}

// Wheels at these speeds after a ramp of half a second, steering at these angles.
void run(RoverPlant& rover, const Way& way, double seconds) {
  for (int i = 0; i < std::lround(seconds / kStep_s); ++i) {
    std::array<ShaftDrive, kWheels> drives;
    for (std::size_t w = 0; w < kWheels; ++w)
      drives[w] = {way.tread_m_s[w] / kRadius_m * std::min(1.0, i * kStep_s / 0.5),
                   way.torque_Nm[w]};
    std::array<ShaftDrive, kSteered> turns;
    for (std::size_t s = 0; s < kSteered; ++s) {
      const double error_rad = way.angle_rad[s] - rover.steering()[s].angle_rad;
      turns[s] = {std::clamp(20 * error_rad, -0.5, 0.5), 20};
    }
    rover.step(drives, turns);
  }
}

double yaw_rad(const RoverPlant& rover) {
  const Eigen::Vector3d ahead = rover.body().attitude * Eigen::Vector3d::UnitX();
  return std::atan2(ahead.y(), ahead.x());
}

TEST(KinematicRover, GoesAsFarAsTheOneInPhysics) {
  Rover physics({});
  KinematicRover rolling(9.81);
  for (RoverPlant* rover : {static_cast<RoverPlant*>(&physics), static_cast<RoverPlant*>(&rolling)})
    run(*rover, ahead(0.3), 4);
  const double far_m = physics.body().position_m.x();
  EXPECT_NEAR(rolling.body().position_m.x(), far_m, 0.05 * far_m);
  EXPECT_NEAR(rolling.body().position_m.y(), 0, 1e-9);
  for (std::size_t i = 0; i < kWheels; ++i) {
    EXPECT_NEAR(rolling.wheels()[i].velocity_rad_s, 0.3 / kRadius_m, 1e-9);
    EXPECT_NEAR(rolling.wheels()[i].torque_Nm,
                kRollingResistance * rolling.loads_N()[i] * kRadius_m, 1e-3);
  }
  run(rolling, ahead(0), 1);
  EXPECT_LT(rolling.body().velocity_m_s.norm(), 1e-3);
}

TEST(KinematicRover, TurnsOnTheSpotAsTheOneInPhysics) {
  Way way;
  const double front = std::atan2(dimensions::kFront_m, dimensions::kTrack_m / 2);
  const double rear = std::atan2(dimensions::kRear_m, dimensions::kTrack_m / 2);
  way.angle_rad = {-front, front, rear, -rear};  // to the left, the left wheels backward
  Rover physics({});
  KinematicRover rolling(9.81);
  for (RoverPlant* rover :
       {static_cast<RoverPlant*>(&physics), static_cast<RoverPlant*>(&rolling)}) {
    way.tread_m_s.fill(0);
    run(*rover, way, 4);
    for (std::size_t i = 0; i < kWheels; ++i) way.tread_m_s[i] = i % 2 == 0 ? -0.2 : 0.2;
    run(*rover, way, 3);
  }
  EXPECT_GT(yaw_rad(rolling), 0.5);
  EXPECT_NEAR(yaw_rad(rolling), yaw_rad(physics), 0.25 * yaw_rad(physics));
}

TEST(KinematicRover, AWheelThatDoesNotDriveRollsAlongAndOneThatIsBlockedBrakes) {
  Way way = ahead(0.3);
  way.tread_m_s[2] = 0;
  way.torque_Nm[2] = kOpen_Nm;
  KinematicRover open(9.81);
  run(open, way, 3);
  EXPECT_NEAR(open.wheels()[2].velocity_rad_s, 0.3 / kRadius_m, 0.1);
  EXPECT_EQ(open.wheels()[2].torque_Nm, 0);
  way.torque_Nm[2] = kDrives_Nm;
  KinematicRover blocked(9.81);
  run(blocked, way, 3);
  EXPECT_EQ(blocked.wheels()[2].velocity_rad_s, 0);
  EXPECT_LT(blocked.body().velocity_m_s.x(), open.body().velocity_m_s.x() - 0.02);
  EXPECT_LT(blocked.slip_m_s(2), -0.1);
}

}  // namespace
}  // namespace lss::sim::ardito
