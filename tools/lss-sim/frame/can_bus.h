#pragma once

// The timing of a CAN bus: one frame at a time, the lowest waiting identifier first, each for the
// time of its bits with stuffing. The master's frames wait in one queue, like the kernel's; each
// node has its own queue. Uses no file descriptor and no clock: one thread passes both in. Also
// simulates the faults of a bus.

#include <deque>
#include <optional>
#include <random>
#include <span>
#include <vector>

#include "drivers/can/frame.h"
#include "tools/lss-sim/frame/faults.h"

namespace lss::sim {

// The devices on the bus. Called from the bus's thread.
class CanDevice {
 public:
  virtual ~CanDevice() = default;
  // A whole frame of another node.
  virtual void receive(const CanFrame& frame) = 0;
  // The next frame to send from one of its nodes, if any.
  virtual std::optional<CanFrame> send() = 0;
  virtual bool wants_to_send() const = 0;  // from any thread
};

// Bits on the wire of a data or remote frame with its stuff bits and the three bits after it.
int bits_on_wire(const CanFrame& frame);

// Types: noise, drop, duplicate, late, bus-cut, bus-off.
std::span<const FaultKind> can_fault_kinds();

class CanBus {
 public:
  struct Parameters {
    int bit_rate = 500'000;
    bool paced = true;  // false: every frame arrives at once
    unsigned seed = 1;
  };

  CanBus(const Parameters& parameters, CanDevice& device);

  void from_master(const CanFrame& frame, TimeNs now);
  // Delivers the frames that have passed the wire by now.
  void advance(TimeNs now);
  // The frames that the master has received by now; valid until the next call.
  std::span<const CanFrame> take(TimeNs now);
  // The time of the next action; the far future when there is none.
  TimeNs next_wake() const;
  void forget();  // the interface was unplugged
  // The master's controller goes bus-off and recovers after this time, 0: at once.
  void bus_off(TimeNs now, TimeNs duration_ns);
  bool is_off() const { return off_until_ns_ != 0; }

  WireFaults faults;

 private:
  struct Waiting {
    TimeNs ready_ns;
    CanFrame frame;
  };
  struct OnWire {
    TimeNs end_ns;
    CanFrame frame;
    bool by_master;
  };

  void collect(TimeNs now);
  bool begin(TimeNs now);
  void deliver(const CanFrame& frame, bool by_master, TimeNs at_ns);
  void to_master(const CanFrame& frame, TimeNs at_ns);
  CanFrame through_noise(CanFrame frame);

  Parameters parameters_;
  CanDevice& device_;
  std::mt19937 random_;
  std::deque<Waiting> master_, nodes_, arriving_;
  std::optional<OnWire> wire_;
  TimeNs free_ns_ = 0, off_until_ns_ = 0;
  std::vector<CanFrame> taken_;
};

}  // namespace lss::sim
