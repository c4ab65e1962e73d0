#pragma once

// The bus of Lunar Zebro as the chain turns it: the bus master on one side, the modules on the
// other. Two types: BusLine, every byte at its instant; FrameBus, frames as a whole, for missions.
// One thread.

#include <span>
#include <vector>

#include "daemon/vehicles/zebro/vehicle.h"

namespace lss::zebro {

// A frame from the master to the modules.
struct WireFrame {
  TimeNs begin_ns = 0;  // its start bit
  TimeNs end_ns = 0;    // its last stop bit: then the modules have it
  Frame frame;

  Code code() const { return static_cast<Code>(frame.code); }
};

class Bus {
 public:
  using Report = Vehicle::BusReport;
  virtual ~Bus() = default;

  // Its view from the frame and actuate threads.
  virtual void release(const BusOrders& orders) = 0;
  virtual bool pop(ModuleReply& reply, TimeNs end) = 0;
  // An emergency stop was taken: the thread wakes and obeys.
  void all_stop(TimeNs now) {
    latch_.ask(now);
    turn(now, {});
  }
  virtual const Report& report() const = 0;

  // The port goes away or is there again.
  virtual void plug(bool plugged, TimeNs now) = 0;
  // `bytes` arrived, or orders were released, or next_wake() has come.
  virtual void turn(TimeNs now, std::span<const std::uint8_t> bytes) = 0;
  virtual TimeNs next_wake() const = 0;

  std::vector<WireFrame> wire;  // may be cleared by any reader

 protected:
  StopLatch latch_;
};

}  // namespace lss::zebro
