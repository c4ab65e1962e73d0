#pragma once

// What buses with drives of CiA 402 have in common: a master that sends orders, boots the nodes,
// and checks whether the drives follow. Knows only frames and time, no file descriptor and no
// thread: the bus thread passes both in, so tests drive it without either. Nothing here allocates,
// locks or logs.
//
// Orders are a desired state, not a queue: newer ones replace older ones. Stop first: when the bus
// begins, when it was opened again and when orders are stale it sends quick stop to all drives by
// itself. Orders from before an emergency are never sent after it: motion needs a new serial.

#include <array>
#include <cstdint>

#include "drivers/canopen/master.h"
#include "drivers/sample_ring.h"
#include "drivers/time.h"

namespace lss::canopen {

struct DriveBusTimes {
  TimeNs period_ns = 100 * kMillisecond;    // of the frame and of SYNC
  TimeNs sync_lead_ns = 10 * kMillisecond;  // SYNC before the frame boundary
  // Orders older than this: quick stop to all by itself.
  TimeNs stale_after_ns = 300 * kMillisecond;
  TimeNs stand_still_ns = 500 * kMillisecond;  // from the first quick stop to the first reset
  TimeNs disobeys_after_ns = 2 * kSecond;      // ordered state not reached
};

// The part of the orders that concerns all nodes.
struct BusOrders {
  TimeNs issued_ns = 0;      // when the frame computed them, to check freshness
  std::uint32_t serial = 0;  // a new number is new orders; begins at 1
  // A new number: quick stop to all, overrides all orders. Motion needs a serial after this one's.
  std::uint32_t emergency_serial = 0;
  std::uint32_t fault_reset_serial = 0;  // a new number: drives in fault are reset
  std::uint32_t node_reset_serial = 0;   // a new number: `reset_nodes` are booted again
  std::uint16_t reset_nodes = 0;         // bit i: node i of the master's parameters
  TimeNs next_frame_ns = 0;  // a coming frame boundary, for SYNC; 0: SYNC goes on in its rhythm
  bool quick_stop = false;   // of all drives, overrides their orders; power stays on
  bool standing = false;     // nodes that were lost may be reset, configured and started
  bool operator==(const BusOrders&) const = default;
};

// State of a node besides its readings.
struct DriveLink {
  NodeStatus node{};
  DriveState drive = DriveState::unknown;  // unknown: no drive, or no statusword
  std::uint16_t statusword = 0;
  bool disobeys = false;       // operational, and for long not in the ordered state
  std::uint64_t dropouts = 0;  // times that it left operation enabled while that was ordered
  std::uint64_t sdo_aborts = 0;
  std::uint64_t sdo_repeats = 0;
};

struct DriveBusCounters {
  MasterCounters master{};
  std::uint64_t releases = 0;
  std::uint64_t safe_commands = 0;  // stops of all by itself, orders being stale
  std::uint64_t stale_orders = 0;   // too old when they arrived
  std::uint64_t old_orders = 0;     // of a serial before an emergency
  std::uint64_t bad_orders = 0;     // orders that were no finite number: the drive was disabled
  std::uint64_t overflows = 0;      // samples that were not taken
};

// Drives are the first nodes of the master's parameters. A vehicle derives from it.
class DriveBus {
 public:
  static constexpr std::size_t kMaxDrives = kMaxNodes;

  // The bus was opened (again), or came back from bus-off: discards partial messages, stops all
  // drives, since they may still follow earlier orders, and boots all nodes. Earlier motion is not
  // resumed.
  void restart(TimeNs now) noexcept;
  // Quick stop to all drives, before anything else is sent; earlier orders are void.
  void all_stop(TimeNs now) noexcept;
  // True: `frame` is to be sent now. Call until it returns false.
  bool transmit(TimeNs now, CanFrame& frame) noexcept;
  // When transmit has to be called again; never later than the stale deadline.
  TimeNs next_wake() const noexcept;
  // False: two nodes have one number. Then nothing is sent.
  bool parameters_fit() const noexcept { return master_.parameters_fit(); }

 protected:
  DriveBus(const MasterParameters& master, const DriveBusTimes& times, std::size_t drives) noexcept
      : times_(times), master_(master), drives_(drives) {}
  ~DriveBus() = default;

  // What the orders say of a drive.
  struct Order {
    bool enabled = false;
    double value = 0;  // speed or position, of any unit
  };
  virtual Order order(std::size_t drive) const noexcept = 0;
  // Its RPDO: while it may move, and as a stop with this controlword.
  virtual void send_order(std::size_t drive, bool enabled, TimeNs now) noexcept = 0;
  virtual void send_stop(std::size_t drive, std::uint16_t controlword) noexcept = 0;
  virtual void send_others() noexcept {}     // nodes that are no drives
  virtual void send_due(TimeNs) noexcept {}  // at next_due()
  virtual TimeNs next_due() const noexcept { return kNever; }
  virtual void forget_samples() noexcept = 0;

  // New orders, or the same with a new time; the vehicle has stored them before.
  void release_orders(const BusOrders& orders, TimeNs now) noexcept;
  bool operational(std::size_t node) const noexcept;
  DriveState state(std::size_t drive) const noexcept { return drive_[drive].state; }
  // The next controlword of a drive whose orders say this.
  std::uint16_t controlword(std::size_t drive, bool enabled) noexcept;
  void heard(std::size_t drive, std::uint16_t statusword) noexcept;
  // The common part of the status.
  void describe(std::size_t node, DriveLink& link) const noexcept;
  void describe(DriveBusCounters& counters) const noexcept;

  DriveBusTimes times_;
  Master master_;
  DriveBusCounters counters_{};

 private:
  // One drive and the last messages to and from it.
  struct Drive {
    DriveState state = DriveState::unknown;
    std::uint16_t statusword = 0;
    int reset_step = 0;    // of a fault: 1 edge down is due, 2 edge up is due
    TimeNs obeyed_ns = 0;  // when it was last in the ordered state
    bool disobeys = false;
    std::uint64_t dropouts = 0;
  };

  bool moves() const noexcept { return !stopping_ && !orders_.quick_stop; }
  void stop_stale(TimeNs now) noexcept;
  void send_all(TimeNs now) noexcept;
  void send_drive(std::size_t drive, TimeNs now) noexcept;
  bool ordered(std::size_t drive) noexcept;
  void watch(std::size_t drive, TimeNs now) noexcept;

  std::size_t drives_;
  std::array<Drive, kMaxDrives> drive_{};
  BusOrders orders_{};
  std::uint32_t emergency_serial_ = 0, fault_reset_serial_ = 0, node_reset_serial_ = 0;
  std::uint32_t ended_serial_ = 0;  // orders up to this serial move nothing
  bool released_ = false, stale_ = false;
  bool stopping_ = true;      // until new orders come
  TimeNs stop_again_ns_ = 0;  // the next quick stop, without new orders
};

}  // namespace lss::canopen
