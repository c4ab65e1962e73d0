#pragma once

// One serial line of a simulator: moves bytes between its pseudo-terminal and the UART of the
// devices, on time. Its own thread; start, stop, faults and plugging from the others.

#include <atomic>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <tl/expected.hpp>

#include "drivers/lockstep/wire.h"
#include "drivers/time.h"
#include "tools/lss-sim/frame/pty_port.h"
#include "tools/lss-sim/frame/uart.h"

namespace lss::sim {

TimeNs monotonic_now();  // or simulated time

// For the calling thread: hardware does not wait for a loaded machine. SCHED_FIFO when allowed, and
// precise waits in any case.
void keep_time(int fifo_priority);

class LineThread {
 public:
  LineThread(std::filesystem::path link, const Uart::Parameters& parameters, LineDevice& device);
  ~LineThread();

  // Creates the port and starts. The error names the failure.
  tl::expected<void, std::string> start();
  // The same without a thread: the caller calls serve, in simulated time.
  tl::expected<void, std::string> open();
  // Does all due work; returns the time of the next work, unless bytes come before.
  TimeNs serve(TimeNs now);

  void set_fault(const Fault& fault, bool attach);  // of line_fault_kinds()
  void unplug(TimeNs duration_ns);                  // 0: plug in at once
  bool unplugged() const { return monotonic_now() < plug_at_ns_; }
  void wake();  // the device has bytes to send
  const PtyPort& port() const { return port_; }

 private:
  void loop();
  void read(TimeNs now);

  std::mutex mutex_;  // of the UART and the port
  PtyPort port_;
  lockstep::Wire wire_{lockstep::Wire::Side::simulator};
  Uart uart_;
  std::atomic<TimeNs> plug_at_ns_ = 0;
  std::atomic<bool> stop_ = false;
  File wake_;
  std::thread thread_;
};

}  // namespace lss::sim
