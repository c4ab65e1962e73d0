#pragma once

// The bus of Lunar Zebro as the chain turns it: the bus master on one side, the modules on the
// other. Two types: BusLine, every byte at its instant; FrameBus, frames as a whole, for missions.
// One thread.

#include <array>
#include <span>
#include <utility>
#include <vector>

#include "daemon/cycle/twins.h"
#include "daemon/runtime/sample_queue.h"
#include "daemon/vehicles/zebro/vehicle.h"
#include "tests/support/daemon_work.h"

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
  explicit Bus(const LegBusParameters& parameters)
      : driver_(parameters),
        overheard_(parameters.check, parameters.stop),
        frame_ns_(frame_time_ns(parameters.baud, parameters.stop)) {
    twin_.seal(bytes_of(driver_));
  }
  virtual ~Bus() = default;

  // Its view from the frame and actuate threads.
  void release(const BusOrders& orders) {
    orders_ = orders;
    released_ = true;
  }
  bool pop(ModuleReply& reply, TimeNs end) { return replies_.pop(reply, end); }
  // An emergency stop was taken: the thread wakes and obeys.
  void all_stop(TimeNs now) {
    latch_.ask(now);
    turn(now, {});
  }
  const Report& report() const { return report_; }
  // What the daemon's threads keep in memory.
  std::vector<std::span<std::uint8_t>> memory() {
    return {bytes_of(driver_), bytes_of(latch_), bytes_of(orders_), bytes_of(report_),
            bytes_of(replies_)};
  }
  std::span<std::uint8_t> second_copy() { return bytes_of(twin_); }
  bool protect = true;

  // The port goes away or is there again.
  virtual void plug(bool plugged, TimeNs now) = 0;
  // `bytes` arrived, or orders were released, or next_wake() has come.
  virtual void turn(TimeNs now, std::span<const std::uint8_t> bytes) = 0;
  virtual TimeNs next_wake() const = 0;

  std::vector<WireFrame> wire;  // may be cleared by any reader

 protected:
  // At the begin of a turn; what it returns seals the driver at its end.
  auto hold(TimeNs now) {
    testing_support::bus_work([&] {
      if (!protect || twin_.check(bytes_of(driver_)) != MemoryCheck::lost) return;
      driver_.restart(now);
      latch_.ask(now);
    });
    struct Seal {
      Bus& bus;
      ~Seal() {
        testing_support::bus_work([this] { bus.twin_.seal(bytes_of(bus.driver_)); });
      }
    };
    return Seal{*this};
  }
  // The driver gets orders that were released since the last time.
  void obey(TimeNs now) {
    testing_support::bus_work(
        [&] { latch_.obey(driver_, std::exchange(released_, false) ? &orders_ : nullptr, now); });
  }
  void take_replies() {
    testing_support::bus_work([this] {
      std::array<ModuleReply, LegBus::kMaxReplies> replies;
      const std::size_t count = driver_.take(replies);
      for (std::size_t i = 0; i < count; ++i) replies_.push(replies[i]);
    });
  }

  LegBus driver_;
  Twin<sizeof(LegBus)> twin_;
  Receiver overheard_;
  TimeNs frame_ns_;
  StopLatch latch_;
  BusOrders orders_{};
  bool released_ = false;
  Report report_{};
  SampleQueue<ModuleReply> replies_;
};

}  // namespace lss::zebro
