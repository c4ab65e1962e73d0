#pragma once

// Master of the CAN bus of TALARIS: valves, fans, load cell. Knows only frames and time, no file
// descriptor and no thread; the bus thread passes both in. Nothing here allocates, locks or logs.
// Schedule of messages: docs/icd-talaris.md.
//
// The edges of valves are the actuate thread's (valves.h). The master shuts them by itself, and
// turns the fans off, when the bus begins, was opened again on the ground, when orders are stale
// and when they have all_stop set.

#include <array>
#include <cstdint>
#include <span>

#include "drivers/canopen/master.h"
#include "drivers/sample_ring.h"
#include "drivers/talaris/orders.h"
#include "drivers/talaris/samples.h"

namespace lss::talaris {

struct HopperBusParameters {
  std::array<std::uint8_t, kHopperNodes> node = {0x20, 0x21, 0x22};
  bool load_cell = false;  // it is there: test stands only
  std::uint8_t master_node = 0x7F;
  TimeNs heartbeat_period_ns = 25 * kMillisecond;    // ours
  TimeNs heartbeat_timeout_ns = 100 * kMillisecond;  // after which nodes shut and stop
  TimeNs node_period_ns = 50 * kMillisecond;         // heartbeats of the nodes
  TimeNs node_timeout_ns = 200 * kMillisecond;       // after which they are lost
  TimeNs renewal_ns = 250 * kMillisecond;            // after which a node drops an output
  TimeNs fan_ramp_ns = 2 * kSecond;                  // of dropped fans, from full throttle to off
  TimeNs fan_period_ns = 20 * kMillisecond;          // pulse widths are sent again
  TimeNs shut_period_ns = 50 * kMillisecond;         // "all shut" is sent again, while it applies
  TimeNs stale_after_ns = 450 * kMillisecond;  // orders older than this: everything shut and off
  TimeNs settle_ns = 50 * kMillisecond;        // from the first "all shut" to the first reset
  TimeNs load_pair_ns = 2 * kMillisecond;      // largest distance of both PDOs of the load cell
};

struct HopperLink {
  canopen::NodeStatus node{};
  std::uint64_t sdo_aborts = 0;
  std::uint64_t sdo_repeats = 0;
};

struct HopperCounters {
  canopen::MasterCounters master{};
  std::uint64_t releases = 0;
  std::uint64_t safe_commands = 0;  // stops of all by itself, orders being stale
  std::uint64_t stale_orders = 0;   // too old when they arrived
  std::uint64_t bad_orders = 0;     // pulse widths outside 1000..2000 us: clipped
  std::uint64_t load_unpaired = 0;  // halves of load samples
  std::uint64_t overflows = 0;      // samples that were not taken, or were too many of one kind
};

struct HopperStatus {
  std::array<HopperLink, kHopperNodes> link{};  // without a load cell the last one is unused
  HopperCounters counters{};
};

class HopperBus {
 public:
  explicit HopperBus(const HopperBusParameters& parameters) noexcept;

  // All shut, then all nodes are booted.
  void restart(TimeNs now) noexcept;
  // The bus was opened (again), or came back from bus-off: the same, but in the air, which is where
  // orders do not allow boots, it goes on.
  void reopened(TimeNs now) noexcept;
  // Nothing in the memory of this object can be trusted: the same, with the orders that the thread
  // had last, and with counts and nodes as they were reported last.
  void begin_again(const HopperBusParameters& parameters, const HopperStatus& said,
                   const TalarisOrders& last, TimeNs now) noexcept;
  // New orders, or the same with a new time.
  void release(const TalarisOrders& orders, TimeNs now) noexcept;
  void receive(std::span<const CanFrame> frames) noexcept;  // each by its time_ns
  // True: `frame` is to be sent now. Call until it returns false.
  bool transmit(TimeNs now, CanFrame& frame) noexcept;
  TimeNs next_wake() const noexcept;  // never later than the stale deadline

  // Readings since the last call; at most kMaxSamples are kept, the oldest dropped.
  static constexpr std::size_t kMaxSamples = 256;
  std::size_t take(std::span<TalarisSample> out) noexcept { return samples_.take(out); }

  // False: two nodes have one number. Then nothing is sent.
  bool parameters_fit() const noexcept { return master_.parameters_fit(); }
  // Of all nodes, in the order of samples.h. Valid until the next call.
  const HopperStatus& status() noexcept;

 private:
  bool safe() const noexcept { return !released_ || stale_ || orders_.all_stop; }
  void allow_boot(bool all, bool fallen_back) noexcept;
  void shut(TimeNs now) noexcept;
  void send_fans(TimeNs now) noexcept;
  bool too_many(const canopen::PdoSample& raw) noexcept;
  void heard(const canopen::PdoSample& raw) noexcept;
  void keep(const TalarisSample& sample) noexcept;

  HopperBusParameters parameters_;
  canopen::Master master_;
  HopperStatus status_{};
  HopperCounters counters_{};
  TalarisOrders orders_{};
  std::uint32_t node_reset_serial_ = 0;
  bool released_ = false, stale_ = false;
  TimeNs fans_ns_ = 0, shut_ns_ = 0;  // when they are sent again
  TalarisSample half_{};              // of the load cell: forces without moments yet
  bool has_half_ = false;
  struct Heard {
    TimeNs begun_ns = 0;
    std::int64_t count = 0;  // since then
  };
  std::array<std::array<Heard, 2>, kHopperNodes> heard_{};  // TPDO 1 and 2 of each
  SampleRing<TalarisSample, kMaxSamples> samples_;
};

// The bus of docs/icd-talaris.md for the CANopen master.
canopen::MasterParameters master_parameters(const HopperBusParameters& parameters) noexcept;

// Data of TPDO `number` of a node, in SI units: GasState, FanSpeeds, or a half of Load (TPDO 1 the
// forces, TPDO 2 the moments). False: there is no such PDO, or its length is wrong.
bool decode(std::size_t node, int number, std::span<const std::uint8_t> data,
            Reading& reading) noexcept;
// The event timer of that TPDO; 0: there is none.
TimeNs event_timer(std::size_t node, int number) noexcept;

}  // namespace lss::talaris
