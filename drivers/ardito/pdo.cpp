#include "drivers/ardito/pdo.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace lss::ardito {
namespace {

using Bytes = std::span<const std::uint8_t>;

constexpr double kAngle_rad = 1e-4;

std::uint16_t u16(Bytes data, std::size_t at) {
  return static_cast<std::uint16_t>(data[at] | data[at + 1] << 8);
}
double i16(Bytes data, std::size_t at) { return static_cast<std::int16_t>(u16(data, at)); }
double i32(Bytes data, std::size_t at) {
  return static_cast<std::int32_t>(u16(data, at) | std::uint32_t{u16(data, at + 2)} << 16);
}

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
  if (number == 1) return WheelMotion{index, u16(data, 0), i32(data, 2), i16(data, 6)};
  if (number == 2) return WheelSpeeds{index, i32(data, 0), i32(data, 4) / 100};
  return WheelHealth{index, i16(data, 0) / 10, u16(data, 2) / 100.0};
}

Reading steering(std::uint8_t index, int number, Bytes data) {
  if (number == 1) {
    return SteeringMotion{index, u16(data, 0), i32(data, 2) * kAngle_rad, i16(data, 6)};
  }
  return SteeringAngle{index, i32(data, 0) * kAngle_rad};
}

Reading io(int number, Bytes data) {
  if (number == 1) return Inputs{(data[0] & 1) != 0, (data[0] & 2) != 0};
  return Rocker{i16(data, 0) * kAngle_rad, i16(data, 2) * kAngle_rad, i16(data, 4) * kAngle_rad};
}

std::int32_t rounded(double value) {
  using Limits = std::numeric_limits<std::int32_t>;
  if (!std::isfinite(value)) return 0;
  return static_cast<std::int32_t>(
      std::clamp<double>(std::round(value), Limits::min(), Limits::max()));
}

RpdoBytes rpdo(std::uint16_t controlword, std::int32_t target) {
  const auto t = static_cast<std::uint32_t>(target);
  const auto byte = [](std::uint32_t value, int shift) {
    return static_cast<std::uint8_t>(value >> shift);
  };
  return {byte(controlword, 0), byte(controlword, 8), byte(t, 0),
          byte(t, 8),           byte(t, 16),          byte(t, 24)};
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
  return Imu{i16(data, 0), i16(data, 2) * kAngle_rad, i16(data, 4) / 1000, u16(data, 6)};
}

RpdoBytes wheel_rpdo(std::uint16_t controlword, double motor_rpm) noexcept {
  return rpdo(controlword, rounded(motor_rpm));
}

RpdoBytes steering_rpdo(std::uint16_t controlword, std::int32_t position) noexcept {
  return rpdo(controlword, position);
}

std::int32_t steering_counts(double motor_rad) noexcept { return rounded(motor_rad / kAngle_rad); }

std::uint8_t io_rpdo(std::uint8_t clutches, bool beacon) noexcept {
  return static_cast<std::uint8_t>((clutches & 0x3F) | (beacon ? 0x40 : 0));
}

}  // namespace lss::ardito
