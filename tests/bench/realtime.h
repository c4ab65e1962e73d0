#pragma once

// FIFO threads of lss-bench: common part of the rows with real-time threads.

#include <sys/types.h>

#include <functional>
#include <string>
#include <utility>

#include "daemon/runtime/thread.h"
#include "tests/bench/bench.h"

namespace lss::bench {

// Priorities of config/zebro.toml; hardware at the far end of a wire is below them.
inline constexpr int kActuatePriority = 85, kBusPriority = 80, kFramePriority = 70,
                     kHardwarePriority = 60;

// Subject and reference share one CPU, the last; the simulated hardware is on the first.
int measured_cpu();
inline constexpr int kHardwareCpu = 0;

// Locks memory; throws NotHere without the permission for FIFO threads.
void prepare_real_time();

// A FIFO thread; the destructor waits for the end of its body.
class Fifo {
 public:
  Fifo(const std::string& name, int priority, int cpu, std::function<void()> body);

 private:
  rt::Thread thread_;
};

// One that is waited for.
inline void run_fifo(const std::string& name, int priority, int cpu, std::function<void()> body) {
  const Fifo thread(name, priority, cpu, std::move(body));
}

// CPU time of the calling thread so far.
double thread_cpu_s();

// A pseudo-terminal: we have one end, the subject opens the other by its name.
class Terminal {
 public:
  Terminal();
  ~Terminal();
  Terminal(const Terminal&) = delete;
  Terminal& operator=(const Terminal&) = delete;

  int fd() const { return master_; }  // not blocking
  const std::string& name() const { return name_; }

 private:
  int master_ = -1, slave_ = -1;  // ours of the slave keeps it from hanging up
  std::string name_;
};

}  // namespace lss::bench
