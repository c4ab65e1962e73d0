#pragma once

// The interface of a leg module as bytes: codes, flags, layouts and scales (the same table as
// docs/icd-zebro.md sections 4 and 5). For the master's side: commands are encoded, replies
// decoded; the simulator is written from the document. Pure functions, callable from every thread.

#include <array>
#include <cstdint>

#include "drivers/zebro/ascii_codec.h"

namespace lss::zebro {

inline constexpr int kBusModules = 7;
inline constexpr std::uint8_t kBroadcast = 0;        // emergency stop only
inline constexpr std::uint16_t kTurn_cdeg = 36'000;  // positions are below it

enum class Code : std::uint8_t {
  // to the module, no reply
  start_motion_control = 0x01,
  stop_motion_control = 0x02,
  rotate_forward = 0x03,
  rotate_backward = 0x04,
  request_data = 0x05,  // replies with one of those below
  emergency_stop = 0x06,
  reset = 0x07,
  // from the module
  status = 0x40,
  health = 0x41,
  identity = 0x42,
};

enum class Page : std::uint8_t { status, health, identity };

constexpr Code reply_code(Page page) {
  return static_cast<Code>(static_cast<std::uint8_t>(Code::status) +
                           static_cast<std::uint8_t>(page));
}

// Bits of Status::flags.
inline constexpr std::uint16_t kFlagMotionControl = 1u << 0;
inline constexpr std::uint16_t kFlagCalibrated = 1u << 1;
inline constexpr std::uint16_t kFlagMoving = 1u << 2;
inline constexpr std::uint16_t kFlagOverCurrent = 1u << 3;
inline constexpr std::uint16_t kFlagDriverFault = 1u << 4;
inline constexpr std::uint16_t kFlagWatchdog = 1u << 5;
inline constexpr std::uint16_t kFlagHallSensor = 1u << 6;
inline constexpr std::uint16_t kFlagReset = 1u << 7;  // since the last status
inline constexpr std::uint16_t kFlagHot = 1u << 8;
inline constexpr std::uint16_t kFlagsReserved = 0xFE00;  // always 0

enum class ResetCause : std::uint8_t { power_on, watchdog, brown_out, command, software };

struct Status {
  std::uint16_t flags = 0;
  double position_rad = 0;  // [0, 2 pi), 0 = straight down, growing with forward rotation
  double velocity_rad_s = 0;
  double current_A = 0;
};

struct Health {
  double temperature_degC = 0;
  double supply_V = 0;
  double set_point_rad = 0;
  double time_left_s = 0;
};

struct Identity {
  std::uint8_t firmware_major = 0;
  std::uint8_t firmware_minor = 0;
  std::uint8_t reset_cause = 0;     // ResetCause, or a number of a newer firmware
  std::uint8_t dropped_frames = 0;  // mod 256
  double uptime_s = 0;
};

using Payload = std::array<std::uint8_t, kFrameData>;

Status decode_status(const Payload& data) noexcept;
Health decode_health(const Payload& data) noexcept;
Identity decode_identity(const Payload& data) noexcept;

// Whether every value is in the range of docs/icd-zebro.md section 5: reserved flags 0, positions
// in [0, 2 pi), and speed, current, temperature and supply that a module can have.
bool possible(const Status& status) noexcept;
bool possible(const Health& health) noexcept;

// Any finite angle to the bus unit, [0, 36000).
std::uint16_t position_cdeg(double angle_rad) noexcept;

// Commands without data: start, stop, emergency stop, reset.
Frame command(std::uint8_t address, Code code) noexcept;
// code: rotate_forward or rotate_backward.
Frame rotate(std::uint8_t address, Code code, std::uint16_t position_cdeg,
             std::uint16_t delta_ms) noexcept;
Frame request(std::uint8_t address, Page page) noexcept;

}  // namespace lss::zebro
