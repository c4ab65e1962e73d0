#include "drivers/canopen/drive_pdo.h"

#include <algorithm>
#include <limits>

namespace lss::canopen {
namespace {

constexpr std::uint32_t kVelocityMode = 3;
constexpr Pdo kVelocityRpdo1 = {1, kEvent, 0, 0, {0x6040'0010, 0x60FF'0020}};
constexpr Pdo kVelocityTpdo1 = {1, kOnSync, 0, 0, {0x6041'0010, 0x606C'0020, 0x6078'0010}};

}  // namespace

std::int32_t field_i32(double value) noexcept {
  using Limits = std::numeric_limits<std::int32_t>;
  if (!std::isfinite(value)) return 0;
  return static_cast<std::int32_t>(
      std::clamp<double>(std::round(value), Limits::min(), Limits::max()));
}

DriveRpdo drive_rpdo(std::uint16_t controlword, std::int32_t target) noexcept {
  const auto t = static_cast<std::uint32_t>(target);
  const auto byte = [](std::uint32_t value, int shift) {
    return static_cast<std::uint8_t>(value >> shift);
  };
  return {byte(controlword, 0), byte(controlword, 8), byte(t, 0),
          byte(t, 8),           byte(t, 16),          byte(t, 24)};
}

NodeParameters velocity_drive(std::uint8_t node, double acceleration_rpm_s) noexcept {
  const std::uint32_t rpm_s = object_u32(acceleration_rpm_s);
  return {node,
          kServo,
          {{kInhibitEmergencies,
            kFallBack,
            kStopOnLoss,
            kHoldWhenStopped,
            {kModeOfOperation, 0, 1, kVelocityMode},
            {kAcceleration, 0, 4, rpm_s},
            {kDeceleration, 0, 4, rpm_s},
            {kQuickStopDeceleration, 0, 4, rpm_s}}},
          {kVelocityRpdo1},
          {kVelocityTpdo1}};
}

}  // namespace lss::canopen
