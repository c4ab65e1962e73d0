#pragma once

// Master of the CAN bus of D.I.A.N.A. Ardito: what buses with drives have in common
// (drivers/canopen/drive_bus.h), wheels, steering, the I/O node and the IMU. Schedule of messages:
// docs/icd-ardito.md.

#include <array>
#include <cstdint>
#include <span>

#include "drivers/ardito/pdo.h"
#include "drivers/canopen/drive_bus.h"
#include "drivers/time.h"

namespace lss::ardito {

struct RoverBusParameters : canopen::DriveBusTimes {
  std::array<std::uint8_t, kWheels> wheel_node = {0x01, 0x02, 0x03, 0x04, 0x05, 0x06};
  std::array<std::uint8_t, kSteered> steering_node = {0x11, 0x12, 0x15, 0x16};
  std::uint8_t io_node = 0x20;
  std::uint8_t imu_node = 0x21;
  std::uint8_t master_node = 0x7F;
  TimeNs heartbeat_period_ns = 100 * kMillisecond;
  TimeNs heartbeat_timeout_ns = 300 * kMillisecond;
  TimeNs set_point_gap_ns = 5 * kMillisecond;  // between the edges of new set-point
  Profiles profile = default_profiles();       // of the kinds of nodes, by their descriptions
  double gear_ratio = 50;                      // of the steering
  double wheel_acceleration_rpm_s = 8000;      // of the motor; also deceleration, quick stop
  double steering_speed_rad_s = 0.5;           // of the wheel
  double steering_acceleration_rad_s2 = 2.0;   // of the wheel
};

struct WheelOrder {
  bool enabled = false;  // else the power stage is off: the wheel turns freely with its gear
  double motor_rpm = 0;  // forward is positive, on either side
  bool operator==(const WheelOrder&) const = default;
};

struct SteeringOrder {
  bool enabled = false;
  double position_rad = 0;  // of the wheel, left is positive
  bool operator==(const SteeringOrder&) const = default;
};

struct RoverOrders : canopen::BusOrders {
  std::array<WheelOrder, kWheels> wheel{};
  std::array<SteeringOrder, kSteered> steering{};
  std::uint8_t clutches = 0;  // bit i: of wheel i engaged
  bool beacon = false;
  bool operator==(const RoverOrders&) const = default;
};

// No drive is enabled by these orders.
bool stops_all(const RoverOrders& orders) noexcept;

// A measurement of the vehicle, stamped with the arrival of its frame.
struct RoverSample {
  TimeNs time_ns = 0;
  Reading reading{};
};

struct RoverLink : canopen::DriveLink {
  std::uint64_t set_points = 0;          // steering: sent
  std::uint64_t set_points_refused = 0;  // not acknowledged in the next statusword
};

using RoverCounters = canopen::DriveBusCounters;

struct RoverStatus {
  std::array<RoverLink, kNodes> link{};
  RoverCounters counters{};
};

class RoverBus final : public canopen::DriveBus {
 public:
  explicit RoverBus(const RoverBusParameters& parameters) noexcept;

  // New orders, or the same with a new time.
  void release(const RoverOrders& orders, TimeNs now) noexcept;

  void receive(std::span<const CanFrame> frames) noexcept;  // each by its time_ns

  // Readings since the last call; at most kMaxSamples are kept, the oldest dropped.
  static constexpr std::size_t kMaxSamples = 128;
  std::size_t take(std::span<RoverSample> out) noexcept { return samples_.take(out); }

  // Of all nodes, in the order of pdo.h. Valid until the next call.
  const RoverStatus& status() noexcept;

 private:
  // The set-point of a steering drive.
  struct SetPoint {
    std::int32_t target = 0;      // last sent, counts
    bool has_target = false;      // ... as the orders want
    bool edge_due = false;        // of its handshake, at edge_ns
    bool unacknowledged = false;  // the edge went out at edge_ns
    TimeNs edge_ns = 0;
    std::uint64_t sent = 0, refused = 0;
  };

  Order order(std::size_t drive) const noexcept override;
  void send_order(std::size_t drive, bool enabled, TimeNs now) noexcept override;
  void send_stop(std::size_t drive, std::uint16_t controlword) noexcept override;
  void send_others() noexcept override;
  void send_due(TimeNs now) noexcept override;
  TimeNs next_due() const noexcept override;
  void forget_samples() noexcept override { samples_.clear(); }
  void send_steering(std::size_t steered, bool enabled, TimeNs now) noexcept;
  void heard_steering(const SteeringMotion& motion, std::size_t node, TimeNs now) noexcept;

  Profiles profile_;
  double gear_ratio_;
  TimeNs set_point_gap_ns_;
  RoverStatus status_{};
  std::array<SetPoint, kSteered> set_point_{};
  RoverOrders orders_{};
  SampleRing<RoverSample, kMaxSamples> samples_;
};

// The bus of docs/icd-ardito.md for the CANopen master.
canopen::MasterParameters master_parameters(const RoverBusParameters& parameters) noexcept;

}  // namespace lss::ardito
