#pragma once

// The common part of a serial line and a CAN bus of a simulator: a thread that does its due work on
// time, and plugging. Start, stop, faults and plugging from other threads.

#include <atomic>
#include <mutex>
#include <string>
#include <thread>
#include <tl/expected.hpp>

#include "drivers/file.h"
#include "drivers/time.h"
#include "tools/lss-sim/frame/faults.h"

namespace lss::sim {

TimeNs monotonic_now();  // or simulated time

// For the calling thread: hardware does not wait for a loaded machine. SCHED_FIFO when allowed, and
// precise waits in any case.
void keep_time(int fifo_priority);

class WireThread {
 public:
  WireThread();
  virtual ~WireThread() = default;

  // Opens the master's end and begins. The error says what failed.
  tl::expected<void, std::string> start();
  // The same without a thread: the caller calls serve, in simulated time.
  virtual tl::expected<void, std::string> open() = 0;
  // Does all due work; returns the time of the next work, unless something comes before.
  TimeNs serve(TimeNs now);

  virtual void set_fault(const Fault& fault, bool attach) = 0;
  virtual bool wants_to_send() const = 0;  // its device
  void unplug(TimeNs duration_ns);         // 0: plug in at once
  bool unplugged() const { return monotonic_now() < plug_at_ns_; }
  void wake();                            // its device has something to send
  virtual std::string place() const = 0;  // for people

 protected:
  void stop();  // in the destructor of each

  // With the lock.
  virtual bool is_open() const = 0;
  virtual int fd() const = 0;
  virtual void close(TimeNs now) = 0;       // unplugged: what is under way is lost
  virtual TimeNs exchange(TimeNs now) = 0;  // as serve, with the end open

  std::mutex mutex_;  // of the end and what is behind it

 private:
  void loop();

  std::atomic<TimeNs> plug_at_ns_ = 0;
  std::atomic<bool> stop_ = false;
  File wake_;
  std::thread thread_;
};

}  // namespace lss::sim
