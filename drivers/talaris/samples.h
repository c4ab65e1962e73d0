#pragma once

// Sensor data of TALARIS as plain numbers in SI units, each stamped on CLOCK_MONOTONIC. Bytes:
// docs/icd-talaris.md.

#include <array>
#include <cstdint>
#include <variant>

#include "drivers/time.h"

namespace lss::talaris {

inline constexpr std::size_t kHopperValves = 8;  // index i: valve i + 1
inline constexpr std::size_t kHopperFans = 4;

// CAN nodes in the order of the driver, independent of their numbers on the bus.
inline constexpr std::size_t kValveNode = 0, kFanNode = 1, kLoadCellNode = 2;
inline constexpr std::size_t kHopperNodes = 3;

inline constexpr std::size_t kCornerAltimeters = 4;

// One packet of the IMU, in the axes of the sensor.
struct ImuPacket {
  std::array<double, 3> rate_rad_s{};
  std::array<double, 3> force_m_s2{};  // specific force
  double temperature_degC = 0;
  // Packets of the sensor since the line was opened, lost ones included: the sensor's own counter,
  // unwrapped. Frames are counted by it.
  std::uint64_t count = 0;
  std::uint8_t status = 0;  // LandMark 30: as sent
};

// Reports of the IMU on itself, the first time and at each change. From `scale` on packets are
// converted by the new factors.
struct ImuStatus {
  enum class Kind : std::uint8_t {
    firmware_major,
    firmware_minor,
    product,
    release,
    filter,
    board_number,   // byte `index` 0..3
    serial_number,  // byte `index` 0..3
    test_flags,     // not 0: a self-test failed
    scale,
  };
  Kind kind = Kind::test_flags;
  std::uint8_t index = 0;
  std::uint8_t value = 0;      // as sent
  double rate_unit_rad_s = 0;  // of `scale`: of one bit
  double force_unit_m_s2 = 0;  // of `scale`: of one bit
};

// One line of an altimeter.
struct Range {
  static constexpr std::uint8_t kOutOfRange = 255;  // an implausible number
  double range_m = 0;                               // 0 with an error
  std::uint8_t error = 0;   // 0: none; its own number, 15 for E15 (weak signal); kOutOfRange
  std::uint8_t corner = 0;  // 1 to 4: of an altimeter at a corner
};

// One frame of the camera: how far the ground passed since the frame before, as the angle at the
// camera, towards +y and +z of the body.
struct Flow {
  std::array<double, 2> angle_rad{};
  std::uint8_t quality = 0;  // 0 to 255, as sent
  bool usable = false;       // the quality suffices
};

// Of the valve node.
struct GasState {
  double tank_Pa = 0;
  double regulated_Pa = 0;
  double voltage_V = 0;
  double temperature_degC = 0;
};

struct FanSpeeds {
  std::array<double, kHopperFans> rpm{};
};

// Of the load cell: both its PDOs of one moment.
struct Load {
  std::array<double, 3> force_N{};
  std::array<double, 3> moment_Nm{};
};

// One packet of the second IMU.
struct StandbyPacket {
  ImuPacket packet{};
};

using Reading =
    std::variant<ImuPacket, ImuStatus, Range, GasState, FanSpeeds, Load, Flow, StandbyPacket>;

// Stamped with the arrival of the first byte, or of the CAN frame.
struct TalarisSample {
  TimeNs time_ns = 0;
  Reading reading{};
};

// What the line of the second IMU says, which has the driver of a first one. False: nothing of it
// is used.
inline bool of_standby(TalarisSample& sample) noexcept {
  const auto* packet = std::get_if<ImuPacket>(&sample.reading);
  if (packet == nullptr) return false;
  const ImuPacket copy = *packet;
  sample.reading = StandbyPacket{copy};
  return true;
}

// The same of an altimeter at corner 1 to 4, which has the driver of the one in the middle.
inline void of_corner(TalarisSample& sample, std::uint8_t corner) noexcept {
  if (auto* range = std::get_if<Range>(&sample.reading)) range->corner = corner;
}

}  // namespace lss::talaris
