#pragma once

// Telemetry of D.I.A.N.A. Ardito, once per frame: filled by the frame thread, passed to the publish
// thread, converted in daemon/dds/ardito.cpp to idl/ardito.idl, whose fields it mirrors. Plain and
// trivially copyable.

#include <array>
#include <cstdint>
#include <limits>

#include "daemon/core/messages.h"
#include "drivers/time.h"
#include "idl/ardito_commands.h"

namespace lss::ardito {

inline constexpr std::uint64_t kNeverHeard_ms = std::numeric_limits<std::uint64_t>::max();

struct NodeTelemetry {
  std::uint8_t id = 0;       // 1..12, as kNodeNames counts
  std::uint8_t address = 0;  // CANopen node number
  bool online = false;
  bool isolated = false;
  std::uint8_t link = 0;   // index into kLinkNames
  std::uint8_t drive = 0;  // index into kDriveNames
  std::uint16_t emergency = 0;
  std::uint32_t emergencies = 0;
  std::uint64_t age_ms = kNeverHeard_ms;
};

struct WheelTelemetry {
  std::uint8_t id = 0;     // 1..6
  std::uint8_t state = 0;  // of the failure detection
  bool clutch = false;
  bool stopped = false;
  double target_rad_s = 0;
  double motor_rad_s = 0;  // at the wheel
  double hall_rad_s = 0;   // at the wheel
  double reduction_rad_s = 0;
  double current_A = 0;
  double temperature_degC = 0;
  double voltage_V = 0;
};

struct SteeringTelemetry {
  std::uint8_t id = 0;  // 1..4: of wheels 1, 2, 5, 6
  std::uint8_t state = 0;
  bool stopped = false;
  double target_rad = 0;  // of the wheel, positive to the left
  double motor_rad = 0;   // at the wheel
  double reduction_rad = 0;
  double current_A = 0;
};

struct Telemetry {
  TimeNs time_ns = 0;
  std::uint64_t frame = 0;
  State state = State::idle;
  Mode mode = Mode::none;
  bool autonomous = false;
  bool correction = false;
  double limit_m_s = 0;
  double speed_m_s = 0;    // commanded
  double heading_rad = 0;  // commanded, positive to the right
  double measured_m_s = 0;
  double measured_rad = 0;
  double distance_m = 0;  // dead reckoning since start
  double yaw_rad = 0;     // clockwise positive
  double x_m = 0;
  double y_m = 0;
  std::array<WheelTelemetry, kDriveWheels> wheels{};
  std::array<SteeringTelemetry, kSteeredWheels> steering{};
  std::array<NodeTelemetry, kBusNodes> nodes{};
  double beta_rad = 0;
  std::array<double, 2> rho_rad{};
  bool imu_valid = false;
  double imu_speed_m_s = 0;
  double imu_heading_rad = 0;
  double imu_yaw_rate_rad_s = 0;
  bool emergency_button = false;
  bool power_good = false;
  bool beacon = false;
  std::uint8_t disagreeing = 0;  // 1..3; 0: none
  std::uint64_t disagreements = 0;
  std::uint64_t bus_frames_sent = 0;
  std::uint64_t bus_frames_received = 0;
  std::uint64_t bus_frames_dropped = 0;
  std::uint64_t bus_overflows = 0;
  std::uint64_t bus_offs = 0;
  bool port_open = false;
};

}  // namespace lss::ardito
