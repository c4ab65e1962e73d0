#pragma once

// Bytes and configuration that drives of CiA 402 have in common. Pure.

#include <array>
#include <cmath>
#include <cstdint>
#include <span>

#include "drivers/canopen/node.h"

namespace lss::canopen {

// Little-endian fields of a PDO; `at` and the field lie within the data.
inline std::uint16_t u16(std::span<const std::uint8_t> data, std::size_t at) noexcept {
  return static_cast<std::uint16_t>(data[at] | data[at + 1] << 8);
}
inline std::int16_t i16(std::span<const std::uint8_t> data, std::size_t at) noexcept {
  return static_cast<std::int16_t>(u16(data, at));
}
inline std::int32_t i32(std::span<const std::uint8_t> data, std::size_t at) noexcept {
  return static_cast<std::int32_t>(u16(data, at) | std::uint32_t{u16(data, at + 2)} << 16);
}

// Nearest whole number, clipped to the range of the field; 0 for what is not finite.
std::int32_t field_i32(double value) noexcept;

// Controlword and target: RPDO1 of velocity and position drives.
using DriveRpdo = std::array<std::uint8_t, 6>;
DriveRpdo drive_rpdo(std::uint16_t controlword, std::int32_t target) noexcept;

// Entries of every node: EMCY inhibit time of 10 ms, and pre-operational when the bus fails.
// CiA 301 has both as optional: a node may be without them.
inline constexpr Entry kInhibitEmergencies = {kEmergencyInhibit, 0, 2, 100, true};
inline constexpr Entry kFallBack = {kErrorBehaviour, 1, 1, 0, true};
// ... and of every drive: quick stop when the master's heartbeat is lost, then hold.
inline constexpr Entry kStopOnLoss = {kAbortConnection, 0, 2, 3};
inline constexpr Entry kHoldWhenStopped = {kQuickStopOption, 0, 2, 6};

// A number as an object of 32 bits; 0 when it is none.
inline std::uint32_t object_u32(double value) noexcept {
  return value > 0 && value < 4e9 ? static_cast<std::uint32_t>(std::lround(value)) : 0;
}

// A servo in profile velocity mode, rpm of the motor: RPDO1 controlword and target, TPDO1 at SYNC
// statusword, speed, and current in per mille of the rated one. Acceleration: rpm/s, also of
// deceleration and quick stop.
inline constexpr std::uint32_t kServo = 0x0002'0192;
NodeParameters velocity_drive(std::uint8_t node, double acceleration_rpm_s) noexcept;

}  // namespace lss::canopen
