#pragma once

// Telemetry of TALARIS, once per frame: filled by the frame thread, passed to the publish thread,
// converted in daemon/dds/talaris.cpp to idl/talaris.idl, whose fields it mirrors. Plain and
// trivially copyable.

#include <array>
#include <cstdint>
#include <limits>

#include "daemon/core/messages.h"
#include "drivers/time.h"
#include "idl/talaris_commands.h"

namespace lss::talaris {

inline constexpr std::uint64_t kNeverHeard_ms = std::numeric_limits<std::uint64_t>::max();

struct ModuleTelemetry {
  std::uint8_t id = 0;  // 1..5, as kModuleNames counts
  bool online = false;
  std::uint8_t link = 0;  // of a node: canopen::NodeState; IMU and altimeter: 0
  std::uint64_t age_ms = kNeverHeard_ms;
  std::uint64_t samples = 0;
  std::uint64_t errors = 0;
  std::uint64_t lost = 0;
};

struct ValveTelemetry {
  std::uint8_t id = 0;  // 1..8
  bool enabled = false;
  bool open = false;
  double on_s = 0;
  double delay_s = 0;
  double fired_s = 0;
  std::uint64_t pulses = 0;
};

struct FanTelemetry {
  std::uint8_t id = 0;  // 1..4
  bool armed = false;
  double throttle = 0;
  double target_rpm = 0;
  double rpm = 0;
};

struct Telemetry {
  TimeNs time_ns = 0;
  std::uint64_t frame = 0;
  State state = State::idle;
  Mode mode = Mode::none;
  Phase phase = Phase::none;
  Program program = Program::hop;
  std::uint8_t gains = 1;
  bool calibrated = false;
  bool planned = false;
  bool airborne = false;
  double calibrated_share = 0;
  double phase_s = 0;
  double remaining_s = 0;
  std::array<double, 3> position_m{};
  std::array<double, 3> velocity_m_s{};
  std::array<double, 4> attitude_wxyz{1, 0, 0, 0};
  std::array<double, 3> rate_rad_s{};
  std::array<double, 3> acceleration_m_s2{};
  std::array<double, 3> position_sigma_m{};
  std::array<double, 3> attitude_sigma_rad{};
  std::array<double, 3> gyro_bias_rad_s{};
  std::array<double, 3> accelerometer_bias_m_s2{};
  double innovation_m = 0;
  std::uint64_t ranges_used = 0;
  std::uint64_t ranges_gated = 0;
  std::array<double, 3> target_position_m{};
  std::array<double, 3> target_velocity_m_s{};
  std::array<double, 3> thrust_N{};
  std::array<double, 3> attitude_error_rad{};
  double range_m = 0;
  std::array<double, 2> pressure_Pa{};
  double gas_thruster_s = 0;
  double gas_left_thruster_s = 0;
  double voltage_V = 0;
  double temperature_degC = 0;
  std::array<double, 3> load_N{};
  std::array<double, 3> load_Nm{};
  std::array<ValveTelemetry, kValveCount> valves{};
  std::array<FanTelemetry, kFanCount> fans{};
  std::array<ModuleTelemetry, kModuleCount> modules{};
  std::uint32_t script_id = 0;  // 0: none
  std::uint16_t script_steps = 0;
  std::uint16_t script_done = 0;
  double script_s = 0;
  std::uint64_t edges = 0;
  double edge_worst_s = 0;
  bool imu_port_open = false;
  bool altimeter_port_open = false;
  bool can_port_open = false;
  std::uint64_t bus_frames_sent = 0;
  std::uint64_t bus_frames_received = 0;
  std::uint64_t bus_frames_dropped = 0;
  std::uint64_t bus_offs = 0;
};

}  // namespace lss::talaris
