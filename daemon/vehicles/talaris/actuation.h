#pragma once

// The work of the actuate thread of TALARIS: orders of a frame at T_k + offset, the edges of the
// valves at their own times, and an all-stop that does not wait for the frame. It writes valve
// frames to the CAN bus itself; the bus thread sends all others. Time is data; actuate thread,
// unless noted otherwise. Between releases and edges the timing of the valves has a second copy; if
// neither is as it was left, all valves are shut until the next release, and the frame thread gets
// a report. Nothing here allocates, locks or logs.

#include <array>
#include <atomic>
#include <cstdint>

#include "daemon/cycle/twins.h"
#include "daemon/runtime/can_bus.h"
#include "daemon/runtime/latest.h"
#include "daemon/runtime/stop_latch.h"
#include "drivers/can/can_sender.h"
#include "drivers/talaris/hopper_bus.h"
#include "drivers/talaris/valves.h"

namespace lss::talaris {

using HopperCan =
    CanBus<HopperBus, HopperBusParameters, TalarisOrders, TalarisSample, HopperStatus>;

// The last edges that were sent to each valve; a frame has one pulse for each.
struct EdgeReport {
  ValveCounters counters{};
  CanSender::Counters sender{};
  std::array<TimeNs, kHopperValves> opened_ns{}, shut_ns{};  // 0: never
  TimeNs last_ns = 0;                                        // of the last frame with an edge
  TimeNs last_late_ns = 0;                                   // its delay
  std::uint8_t open = 0;                                     // bit i: valve i + 1, as last sent
  // An all-stop was obeyed; the orders of the cycle do not pass until it has confirmed.
  bool all_stop_pending = false;
  std::uint64_t refused_orders = 0;  // that did not pass

  // Frames that were due were sent; `before`: the valves that were open until then.
  void sent(std::uint8_t before, const ValveSequencer& valves, TimeNs due_ns, TimeNs now) noexcept;
};

class Actuation {
 public:
  Actuation(const ValveParameters& parameters, HopperCan& can);

  CanSender& sender() noexcept { return sender_; }  // start-up: for the port

  // At its release; pulses count from `release_ns`, of a repeated command, too.
  void release(const TalarisOrders& orders, TimeNs release_ns, TimeNs now) noexcept;
  // Between releases (NoWork in daemon/runtime/frames.h).
  TimeNs next_wake() const noexcept { return valves_.next_wake(); }
  void run(TimeNs now) noexcept;

  // Any thread; afterwards the actuate thread has to be woken.
  void all_stop(TimeNs now) noexcept { latch_.ask(now); }

  // Frame thread.
  const EdgeReport& report() noexcept { return report_.get(); }
  // Frame thread. Both copies of the valves' timing were damaged since the last call.
  bool take_memory_lost() noexcept {
    return memory_lost_.exchange(false, std::memory_order_relaxed);
  }

 private:
  void check(TimeNs now) noexcept;
  void obey(TimeNs now) noexcept;
  void send(TimeNs due_ns, TimeNs now) noexcept;

  HopperCan& can_;
  CanSender sender_;
  const ValveParameters parameters_;
  ValveSequencer valves_;
  Twin<sizeof(ValveSequencer)> twin_;
  StopLatch latch_;
  std::uint32_t generation_ = 0;
  std::uint32_t reset_serial_ = 0;  // of the orders that passed last
  EdgeReport said_{};
  Latest<EdgeReport> report_;
  std::atomic<bool> memory_lost_{false};
};

}  // namespace lss::talaris
