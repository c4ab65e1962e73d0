#include "drivers/ardito/pdo.h"

#include "drivers/canopen/drive_pdo.h"

namespace lss::ardito {
namespace {

using Bytes = std::span<const std::uint8_t>;

constexpr double kAngle_rad = 1e-4;

using canopen::i16;
using canopen::i32;
using canopen::u16;

// The node sends TPDOs 1, 2, 3 of these lengths; 0: none.
using Lengths = std::array<std::size_t, 3>;
constexpr Lengths kWheelLengths = {8, 8, 4}, kSteeringLengths = {8, 4, 0};
constexpr Lengths kIoLengths = {1, 6, 0}, kImuLengths = {8, 0, 0};

const Lengths& lengths(std::size_t node) {
  if (node < kFirstSteering) return kWheelLengths;
  if (node < kIo) return kSteeringLengths;
  return node == kIo ? kIoLengths : kImuLengths;
}

Reading wheel(std::uint8_t index, int number, Bytes data) {
  if (number == 1)
    return WheelMotion{index, u16(data, 0), static_cast<double>(i32(data, 2)),
                       static_cast<double>(i16(data, 6))};
  if (number == 2)
    return WheelSpeeds{index, static_cast<double>(i32(data, 0)), i32(data, 4) / 100.0};
  return WheelHealth{index, i16(data, 0) / 10.0, u16(data, 2) / 100.0};
}

Reading steering(std::uint8_t index, int number, Bytes data) {
  if (number == 1) {
    return SteeringMotion{index, u16(data, 0), i32(data, 2) * kAngle_rad,
                          static_cast<double>(i16(data, 6))};
  }
  return SteeringAngle{index, i32(data, 0) * kAngle_rad};
}

Reading io(int number, Bytes data) {
  if (number == 1) return Inputs{(data[0] & 1) != 0, (data[0] & 2) != 0};
  return Rocker{i16(data, 0) * kAngle_rad, i16(data, 2) * kAngle_rad, i16(data, 4) * kAngle_rad};
}

}  // namespace

std::optional<Reading> decode(std::size_t node, int number, Bytes data) noexcept {
  if (node >= kNodes || number < 1 || number > 3) return std::nullopt;
  const std::size_t length = lengths(node)[static_cast<std::size_t>(number - 1)];
  if (length == 0 || data.size() != length) return std::nullopt;
  if (node < kFirstSteering) return wheel(static_cast<std::uint8_t>(node), number, data);
  if (node < kIo) {
    const auto index = static_cast<std::uint8_t>(kSteeredWheel[node - kFirstSteering]);
    return steering(index, number, data);
  }
  if (node == kIo) return io(number, data);
  return Imu{static_cast<double>(i16(data, 0)), i16(data, 2) * kAngle_rad, i16(data, 4) / 1000.0,
             u16(data, 6)};
}

RpdoBytes wheel_rpdo(std::uint16_t controlword, double motor_rpm) noexcept {
  return canopen::drive_rpdo(controlword, canopen::field_i32(motor_rpm));
}

RpdoBytes steering_rpdo(std::uint16_t controlword, std::int32_t position) noexcept {
  return canopen::drive_rpdo(controlword, position);
}

std::int32_t steering_counts(double motor_rad) noexcept {
  return canopen::field_i32(motor_rad / kAngle_rad);
}

std::uint8_t io_rpdo(std::uint8_t clutches, bool beacon) noexcept {
  return static_cast<std::uint8_t>((clutches & 0x3F) | (beacon ? 0x40 : 0));
}

}  // namespace lss::ardito
