#pragma once

// Contents of the PDOs of D.I.A.N.A. Ardito, to and from physical units. Layouts, units and signs:
// docs/icd-ardito.md sections 3 and 5; objects, sizes and units by the device descriptions. Pure.

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <variant>

#include "drivers/ardito/profile.h"
#include "drivers/time.h"

namespace lss::ardito {

inline constexpr std::size_t kWheels = 6;   // LF RF LM RM LR RR
inline constexpr std::size_t kSteered = 4;  // wheels LF RF LR RR
inline constexpr std::array<std::size_t, kSteered> kSteeredWheel = {0, 1, 4, 5};

// Nodes in the order of the driver, independent of their numbers on the bus.
inline constexpr std::size_t kFirstSteering = kWheels, kIo = kWheels + kSteered, kImu = kIo + 1;
inline constexpr std::size_t kNodes = kImu + 1;

// `wheel` is the index 0..5 of the wheel, also of steering drives.
struct WheelMotion {
  std::uint8_t wheel = 0;
  std::uint16_t statusword = 0;
  double motor_rpm = 0;         // by the motor encoder
  double current_permille = 0;  // of the rated current
};
struct WheelSpeeds {
  std::uint8_t wheel = 0;
  double hall_rpm = 0;       // of the motor, by its Hall sensors
  double reduction_rpm = 0;  // of the wheel, by the reduction encoder
};
struct WheelHealth {
  std::uint8_t wheel = 0;
  double temperature_degC = 0;  // of the motor
  double link_V = 0;
};
struct SteeringMotion {
  std::uint8_t wheel = 0;
  std::uint16_t statusword = 0;
  double motor_rad = 0;  // at the motor shaft: 50 times the wheel's
  double current_permille = 0;
};
struct SteeringAngle {
  std::uint8_t wheel = 0;
  double reduction_rad = 0;  // of the wheel
};
struct Inputs {
  bool emergency_button = false;
  bool power_good = false;
};
struct Rocker {
  double beta_rad = 0;
  double rho1_rad = 0;
  double rho2_rad = 0;
};
struct Imu {
  double Vtan_mm_s = 0;
  double sigma_rad = 0;
  double yaw_rate_rad_s = 0;
  std::uint16_t counter = 0;  // constant when the sensor is dead
};
using Reading = std::variant<WheelMotion, WheelSpeeds, WheelHealth, SteeringMotion, SteeringAngle,
                             Inputs, Rocker, Imu>;

// Data of TPDO `number` of a node (index, see above). None: there is no such PDO, or its length is
// wrong.
std::optional<Reading> decode(const Profiles& profiles, std::size_t node, int number,
                              std::span<const std::uint8_t> data) noexcept;

using RpdoBytes = std::array<std::uint8_t, 6>;
// Counts of a target in the unit of its field. Values outside its range are clipped to it; a value
// that is not finite becomes 0.
RpdoBytes drive_rpdo(std::uint16_t controlword, std::int32_t counts) noexcept;
std::int32_t counts(const Field& field, double value) noexcept;
// `clutches`: bit i, wheel i is engaged.
std::uint8_t io_rpdo(std::uint8_t clutches, bool beacon) noexcept;

}  // namespace lss::ardito
