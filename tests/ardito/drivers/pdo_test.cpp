// PDO data to and from physical units, to the byte of docs/icd-ardito.md section 5.

#include "drivers/ardito/pdo.h"

#include <gtest/gtest.h>
#include <rapidcheck.h>
#include <rapidcheck/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

namespace lss::ardito {
namespace {

using Bytes = std::vector<std::uint8_t>;

RpdoBytes wheel_rpdo(std::uint16_t controlword, double motor_rpm) {
  const Profile& wheel = default_profiles()[static_cast<std::size_t>(Kind::wheel)];
  return drive_rpdo(controlword, counts(wheel.of(WheelSignal::target_velocity), motor_rpm));
}
std::int32_t steering_counts(double motor_rad) {
  const Profile& steering = default_profiles()[static_cast<std::size_t>(Kind::steering)];
  return counts(steering.of(SteeringSignal::target_position), motor_rad);
}

template <class T>
T read(std::size_t node, int number, const Bytes& data) {
  const auto reading = decode(default_profiles(), node, number, data);
  EXPECT_TRUE(reading.has_value());
  return std::get<T>(*reading);
}

TEST(Pdo, ReadsTheGoldenFrames) {
  const auto motion = read<WheelMotion>(0, 1, {0x37, 0x02, 0x37, 0x06, 0x00, 0x00, 0x78, 0x00});
  EXPECT_EQ(motion.wheel, 0);
  EXPECT_EQ(motion.statusword, 0x0237);
  EXPECT_EQ(motion.motor_rpm, 1591);
  EXPECT_EQ(motion.current_permille, 120);
  const auto speeds = read<WheelSpeeds>(5, 2, {0x36, 0x06, 0x00, 0x00, 0x6F, 0x0C, 0x00, 0x00});
  EXPECT_EQ(speeds.wheel, 5);
  EXPECT_EQ(speeds.hall_rpm, 1590);
  EXPECT_DOUBLE_EQ(speeds.reduction_rpm, 31.83);
  const auto health = read<WheelHealth>(2, 3, {0xFD, 0x00, 0x65, 0x09});
  EXPECT_DOUBLE_EQ(health.temperature_degC, 25.3);
  EXPECT_DOUBLE_EQ(health.link_V, 24.05);
  const auto steering =
      read<SteeringMotion>(kFirstSteering + 2, 1, {0x37, 0x12, 0x48, 0xE8, 0x01, 0x00, 0xC9, 0xFF});
  EXPECT_EQ(steering.wheel, 4) << "the third steering drive is that of wheel 5";
  EXPECT_EQ(steering.statusword, 0x1237);
  EXPECT_DOUBLE_EQ(steering.motor_rad, 12.5);
  EXPECT_EQ(steering.current_permille, -55);
  const auto angle = read<SteeringAngle>(kFirstSteering, 2, {0xC4, 0x09, 0x00, 0x00});
  EXPECT_DOUBLE_EQ(angle.reduction_rad, 0.25);
  const auto inputs = read<Inputs>(kIo, 1, {0x02});
  EXPECT_FALSE(inputs.emergency_button);
  EXPECT_TRUE(inputs.power_good);
  const auto rocker = read<Rocker>(kIo, 2, {0xE8, 0x03, 0x0C, 0xFE, 0x00, 0x00});
  EXPECT_DOUBLE_EQ(rocker.beta_rad, 0.1);
  EXPECT_DOUBLE_EQ(rocker.rho1_rad, -0.05);
  EXPECT_EQ(rocker.rho2_rad, 0);
  const auto imu = read<Imu>(kImu, 1, {0x0C, 0xFE, 0x69, 0x03, 0x0C, 0x00, 0x02, 0x01});
  EXPECT_EQ(imu.Vtan_mm_s, -500);
  EXPECT_DOUBLE_EQ(imu.sigma_rad, 0.0873);
  EXPECT_DOUBLE_EQ(imu.yaw_rate_rad_s, 0.012);
  EXPECT_EQ(imu.counter, 258);
}

TEST(Pdo, WritesTheGoldenFrames) {
  EXPECT_EQ(wheel_rpdo(0x000F, -1592), (RpdoBytes{0x0F, 0x00, 0xC8, 0xF9, 0xFF, 0xFF}));
  EXPECT_EQ(wheel_rpdo(0x0002, 0), (RpdoBytes{0x02, 0, 0, 0, 0, 0}));
  EXPECT_EQ(steering_counts(25), 250'000);
  EXPECT_EQ(drive_rpdo(0x003F, 250'000), (RpdoBytes{0x3F, 0x00, 0x90, 0xD0, 0x03, 0x00}));
  EXPECT_EQ(io_rpdo(0x3F, true), 0x7F);
  EXPECT_EQ(io_rpdo(0xFF, false), 0x3F);
}

TEST(Pdo, ValuesBeyondTheirFieldAreCutAndNoNumberIsZero) {
  using Limits = std::numeric_limits<double>;
  EXPECT_EQ(wheel_rpdo(0, 1e12), (RpdoBytes{0, 0, 0xFF, 0xFF, 0xFF, 0x7F}));
  EXPECT_EQ(wheel_rpdo(0, -1e12), (RpdoBytes{0, 0, 0x00, 0x00, 0x00, 0x80}));
  for (const double no : {Limits::quiet_NaN(), Limits::infinity(), -Limits::infinity()}) {
    EXPECT_EQ(wheel_rpdo(0, no), RpdoBytes{});
    EXPECT_EQ(steering_counts(no), 0);
  }
}

RC_GTEST_PROP(Pdo, ReadsOnlyWhatHasTheLengthOfItsPdo, (Bytes bytes)) {
  const auto node = *rc::gen::inRange<std::size_t>(0, 20);
  const int number = *rc::gen::inRange(-1, 6);
  const auto reading = decode(default_profiles(), node, number, bytes);
  const std::vector<std::vector<std::size_t>> lengths = {{8, 8, 4}, {8, 4}, {1, 6}, {8}};
  const std::size_t kind = node < 6 ? 0 : node < 10 ? 1 : node - 8;
  const bool known = node < kNodes && number >= 1 &&
                     static_cast<std::size_t>(number) <= lengths[kind].size() &&
                     bytes.size() == lengths[kind][static_cast<std::size_t>(number) - 1];
  RC_ASSERT(reading.has_value() == known);
}

}  // namespace
}  // namespace lss::ardito
