#pragma once

// One CAN bus of a simulator: moves frames between the master's end and the bus of the nodes, on
// time. Its own thread; start, stop, faults and plugging from the others.

#include <atomic>
#include <mutex>
#include <string>
#include <thread>
#include <tl/expected.hpp>

#include "tools/lss-sim/frame/can_bus.h"
#include "tools/lss-sim/frame/can_end.h"

namespace lss::sim {

class CanThread {
 public:
  CanThread(std::string address, const CanBus::Parameters& parameters, CanDevice& device);
  ~CanThread();

  // Opens the end and begins. The error says what failed.
  tl::expected<void, std::string> start();
  // The same without a thread: the caller calls serve, in simulated time.
  tl::expected<void, std::string> open() { return end_.open(); }
  // Does all due work; returns the time of the next work, unless a message comes before.
  TimeNs serve(TimeNs now);

  void set_fault(const Fault& fault, bool attach);  // of can_fault_kinds()
  bool is_off();                                    // bus-off
  void unplug(TimeNs duration_ns);                  // 0: plug in at once
  bool unplugged() const;
  void wake();  // a node has a frame to send
  const std::string& address() const { return end_.address(); }

 private:
  void loop();

  std::mutex mutex_;  // of the bus and its end
  CanEnd end_;
  CanBus bus_;
  std::atomic<TimeNs> plug_at_ns_ = 0;
  std::atomic<bool> stop_ = false;
  File wake_;
  std::thread thread_;
};

}  // namespace lss::sim
