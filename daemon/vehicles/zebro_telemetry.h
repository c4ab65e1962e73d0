#pragma once

// Telemetry of Lunar Zebro, once per frame: filled by the frame thread, passed to the publish
// thread, converted in daemon/dds/zebro.cpp to idl/zebro.idl, whose fields it mirrors. Plain and
// trivially copyable.

#include <array>
#include <cstdint>
#include <limits>

#include "daemon/core/messages.h"
#include "drivers/time.h"
#include "idl/zebro_commands.h"

namespace lss::zebro {

inline constexpr std::uint64_t kNeverHeard_ms = std::numeric_limits<std::uint64_t>::max();

struct ModuleTelemetry {
  std::uint8_t id = 0;       // 1..7, as kModuleNames counts
  std::uint8_t address = 0;  // on the bus
  bool online = false;
  bool calibrated = false;
  bool motion_control = false;
  bool moving = false;
  bool isolated = false;  // out of service
  bool swing = false;
  std::uint16_t flags = 0;  // as the module sent them
  double position_rad = 0;
  double velocity_rad_s = 0;
  double set_point_rad = 0;
  double time_left_s = 0;
  double current_A = 0;
  double temperature_degC = 0;
  double supply_V = 0;
  double uptime_s = 0;
  std::uint8_t firmware_major = 0;
  std::uint8_t firmware_minor = 0;
  std::uint8_t reset_cause = 0;
  std::uint8_t dropped_frames = 0;        // mod 256
  std::uint64_t age_ms = kNeverHeard_ms;  // since its last reply
  std::uint64_t replies = 0;
  std::uint64_t resends = 0;
};

struct Telemetry {
  TimeNs time_ns = 0;
  std::uint64_t frame = 0;
  State state = State::idle;
  Mode mode = Mode::none;
  std::uint8_t speed = 0;  // index into kSpeeds
  double heading_rad = 0;  // commanded, clockwise positive
  double direction = 1;    // +1 forward, -1 backward
  double distance_m = 0;   // dead reckoning, along the body
  double yaw_rad = 0;      // dead reckoning, clockwise positive
  double speed_m_s = 0;
  std::uint32_t steps = 0;  // gait cycles completed since start
  std::array<ModuleTelemetry, kModules> modules{};
  std::uint64_t bus_frames_sent = 0;
  std::uint64_t bus_frames_received = 0;
  std::uint64_t bus_frames_dropped = 0;
  std::uint64_t bus_overflows = 0;
  TimeNs bus_cycle_ns = 0;  // last complete bus cycle
  bool port_open = false;
};

}  // namespace lss::zebro
