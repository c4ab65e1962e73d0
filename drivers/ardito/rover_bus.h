#pragma once

// Master of the CAN bus of D.I.A.N.A. Ardito: sends orders, receives reports, and checks whether
// the drives follow their orders. Knows only frames and time, no file descriptor and no thread: the
// bus thread passes both in, so tests drive it without either. Nothing here allocates, locks or
// logs. Schedule of messages: docs/icd-ardito.md.
//
// The orders are a desired state, not a queue: newer ones replace older ones.
//
// Stop first: when the bus begins, when it was opened again and when orders are stale it sends
// quick stop to all drives by itself. Orders from before an emergency are never sent after it:
// motion needs a new serial.

#include <array>
#include <cstdint>
#include <span>

#include "drivers/ardito/pdo.h"
#include "drivers/canopen/master.h"
#include "drivers/time.h"

namespace lss::ardito {

struct RoverBusParameters {
  std::array<std::uint8_t, kWheels> wheel_node = {0x01, 0x02, 0x03, 0x04, 0x05, 0x06};
  std::array<std::uint8_t, kSteered> steering_node = {0x11, 0x12, 0x15, 0x16};
  std::uint8_t io_node = 0x20;
  std::uint8_t imu_node = 0x21;
  std::uint8_t master_node = 0x7F;
  TimeNs period_ns = 100 * kMillisecond;    // of the frame and of SYNC
  TimeNs sync_lead_ns = 10 * kMillisecond;  // SYNC before the frame boundary
  // Orders older than this: quick stop to all by itself.
  TimeNs stale_after_ns = 300 * kMillisecond;
  TimeNs heartbeat_period_ns = 100 * kMillisecond;
  TimeNs heartbeat_timeout_ns = 300 * kMillisecond;
  TimeNs stand_still_ns = 500 * kMillisecond;  // from the first quick stop to the first reset
  TimeNs set_point_gap_ns = 5 * kMillisecond;  // between the edges of new set-point
  TimeNs disobeys_after_ns = 2 * kSecond;      // ordered state not reached
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

struct RoverOrders {
  TimeNs issued_ns = 0;      // when the frame computed them, to check freshness
  std::uint32_t serial = 0;  // a new number is new orders; begins at 1
  // A new number: quick stop to all, overrides all orders. Motion needs a serial after this one's.
  std::uint32_t emergency_serial = 0;
  std::uint32_t fault_reset_serial = 0;  // a new number: drives in fault are reset
  std::uint32_t node_reset_serial = 0;   // a new number: `reset_nodes` are booted again
  std::uint16_t reset_nodes = 0;         // bit i: node i in the order of pdo.h
  TimeNs next_frame_ns = 0;  // a coming frame boundary, for SYNC; 0: SYNC goes on in its rhythm
  bool quick_stop = false;   // of all drives, overrides the orders below; power stays on
  bool standing = false;     // nodes that were lost may be reset, configured and started
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

// State of a node besides its readings.
struct RoverLink {
  canopen::NodeStatus node{};
  canopen::DriveState drive = canopen::DriveState::unknown;  // unknown: no drive, or no statusword
  std::uint16_t statusword = 0;
  bool disobeys = false;                 // operational, and for long not in the ordered state
  std::uint64_t set_points = 0;          // steering: sent
  std::uint64_t set_points_refused = 0;  // not acknowledged in the next statusword
  std::uint64_t sdo_aborts = 0;
  std::uint64_t sdo_repeats = 0;
};

struct RoverCounters {
  canopen::MasterCounters master{};
  std::uint64_t releases = 0;
  std::uint64_t safe_commands = 0;  // stops of all by itself, orders being stale
  std::uint64_t stale_orders = 0;   // too old when they arrived
  std::uint64_t old_orders = 0;     // of a serial before an emergency
  std::uint64_t bad_orders = 0;     // orders that were no finite number: the drive was disabled
  std::uint64_t overflows = 0;      // samples that were not taken
};

struct RoverStatus {
  std::array<RoverLink, kNodes> link{};
  RoverCounters counters{};
};

class RoverBus {
 public:
  explicit RoverBus(const RoverBusParameters& parameters) noexcept;

  // The bus was opened (again), or came back from bus-off: discards partial messages, stops all
  // drives, since they may still follow earlier orders, and boots all nodes. Earlier motion is not
  // resumed.
  void restart(TimeNs now) noexcept;

  // New orders, or the same with a new time.
  void release(const RoverOrders& orders, TimeNs now) noexcept;

  // Quick stop to all drives, before anything else is sent; earlier orders are void.
  void all_stop(TimeNs now) noexcept { stop_all(now); }

  void receive(std::span<const CanFrame> frames) noexcept;  // each by its time_ns

  // True: `frame` is to be sent now. Call until it returns false.
  bool transmit(TimeNs now, CanFrame& frame) noexcept;

  // When transmit has to be called again; never later than the stale deadline.
  TimeNs next_wake() const noexcept;

  // Readings since the last call; at most kMaxSamples are kept, the oldest dropped.
  static constexpr std::size_t kMaxSamples = 128;
  std::size_t take(std::span<RoverSample> out) noexcept;

  // False: two nodes have one number. Then nothing is sent.
  bool parameters_fit() const noexcept { return master_.parameters_fit(); }

  // Of all nodes, in the order of pdo.h. Valid until the next call.
  const RoverStatus& status() noexcept;

 private:
  // One drive and the last messages to and from it.
  struct Drive {
    canopen::DriveState state = canopen::DriveState::unknown;
    std::uint16_t statusword = 0;
    int reset_step = 0;    // of a fault: 1 edge down is due, 2 edge up is due
    TimeNs obeyed_ns = 0;  // when it was last in the ordered state
    bool disobeys = false;
    std::int32_t target = 0;      // steering: the set-point last sent, 0.0001 rad
    bool has_target = false;      // ... as the orders want
    bool edge_due = false;        // of its handshake, at edge_ns
    bool unacknowledged = false;  // the edge went out at edge_ns
    TimeNs edge_ns = 0;
    std::uint64_t set_points = 0, refused = 0;
  };

  bool moves() const noexcept { return !stopping_ && !orders_.quick_stop; }
  bool operational(std::size_t node) const noexcept;
  void stop_all(TimeNs now) noexcept;
  void stop_stale(TimeNs now) noexcept;
  void send_all(TimeNs now) noexcept;
  void send_drive(std::size_t node, TimeNs now) noexcept;
  void send_wheel(std::size_t wheel, bool enabled) noexcept;
  void send_steering(std::size_t steered, bool enabled, TimeNs now) noexcept;
  void send_edges(TimeNs now) noexcept;
  std::uint16_t controlword(Drive& drive, bool enabled) noexcept;
  bool ordered(std::size_t node) noexcept;
  void watch(std::size_t node, TimeNs now) noexcept;
  void heard(Drive& drive, std::uint16_t statusword) noexcept;
  void keep(const RoverSample& sample) noexcept;

  RoverBusParameters parameters_;
  canopen::Master master_;
  RoverStatus status_{};
  RoverCounters counters_{};

  std::array<Drive, kWheels + kSteered> drive_{};
  RoverOrders orders_{};
  std::uint32_t emergency_serial_ = 0, fault_reset_serial_ = 0, node_reset_serial_ = 0;
  std::uint32_t ended_serial_ = 0;  // orders up to this serial move nothing
  bool released_ = false, stale_ = false;
  bool stopping_ = true;                           // until new orders come
  TimeNs stop_again_ns_ = 0;                       // the next quick stop, without new orders
  std::array<RoverSample, kMaxSamples> sample_{};  // ring
  std::size_t first_sample_ = 0, sample_count_ = 0;
};

// The bus of docs/icd-ardito.md for the CANopen master.
canopen::MasterParameters master_parameters(const RoverBusParameters& parameters) noexcept;

}  // namespace lss::ardito
