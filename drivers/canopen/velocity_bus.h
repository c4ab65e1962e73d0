#pragma once

// Master of a CAN bus whose nodes are servos in profile velocity mode (CiA 402): for vehicles that
// need nothing else. See drivers/canopen/drive_bus.h.

#include <array>
#include <cstdint>
#include <span>

#include "drivers/canopen/drive_bus.h"
#include "drivers/canopen/drive_pdo.h"

namespace lss::canopen {

inline constexpr std::size_t kMostVelocityDrives = 8;

struct VelocityBusParameters : DriveBusTimes {
  std::array<std::uint8_t, kMostVelocityDrives> node{};  // numbers on the bus; 0 ends the list
  HeartbeatParameters heartbeat{};
  double acceleration_rpm_s = 4000;  // of the motor; also deceleration, quick stop
};

struct VelocityOrder {
  bool enabled = false;  // else the power stage is off
  double motor_rpm = 0;
  bool operator==(const VelocityOrder&) const = default;
};

struct VelocityOrders : BusOrders {
  std::array<VelocityOrder, kMostVelocityDrives> drive{};
  bool operator==(const VelocityOrders&) const = default;
};

// No drive is enabled by these orders.
bool stops_all(const VelocityOrders& orders) noexcept;

// TPDO1 of a drive, stamped with the arrival of its frame.
struct VelocitySample {
  TimeNs time_ns = 0;
  std::uint8_t drive = 0;  // index in the parameters
  std::uint16_t statusword = 0;
  double motor_rpm = 0;
  double current_permille = 0;  // of the rated current
};

struct VelocityStatus {
  std::array<DriveLink, kMostVelocityDrives> link{};
  DriveBusCounters counters{};
};

class VelocityBus final : public DriveBus {
 public:
  explicit VelocityBus(const VelocityBusParameters& parameters) noexcept;

  // New orders, or the same with a new time.
  void release(const VelocityOrders& orders, TimeNs now) noexcept;
  void receive(std::span<const CanFrame> frames) noexcept;  // each by its time_ns
  // Samples since the last call; at most kMaxSamples are stored, the oldest dropped.
  static constexpr std::size_t kMaxSamples = 64;
  std::size_t take(std::span<VelocitySample> out) noexcept { return samples_.take(out); }
  // Valid until the next call.
  const VelocityStatus& status() noexcept;

 private:
  Order order(std::size_t drive) const noexcept override;
  void send_order(std::size_t drive, bool enabled, TimeNs now) noexcept override;
  void send_stop(std::size_t drive, std::uint16_t controlword) noexcept override;
  void forget_samples() noexcept override { samples_.clear(); }

  VelocityOrders orders_{};
  VelocityStatus status_{};
  SampleRing<VelocitySample, kMaxSamples> samples_;
};

}  // namespace lss::canopen
