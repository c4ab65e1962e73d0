#pragma once

// Threads as configured, and the grants of the kernel. Start-up and status; the bodies run in their
// threads.

#include <sched.h>
#include <sys/types.h>

#include <atomic>
#include <cstdint>
#include <functional>
#include <string>
#include <thread>
#include <tl/expected.hpp>

#include "daemon/cycle/messages.h"

namespace lss::rt {

struct ThreadRequest {
  std::string name;  // at most 15 characters, as the kernel shows it
  int priority = 0;  // SCHED_FIFO 1..99; 0: SCHED_OTHER
  int cpu = -1;      // -1: any
};

// One running thread and its counters. The body starts when the request was granted or given up.
class Thread {
 public:
  Thread() = default;
  ~Thread();
  Thread(const Thread&) = delete;
  Thread& operator=(const Thread&) = delete;

  // Starts the body. An error names the refusal and its remedy; with `enforce` the body then does
  // not run, else it runs without.
  tl::expected<void, std::string> start(const ThreadRequest& request, bool enforce,
                                        std::function<void()> body);
  void join();

  bool running() const { return thread_.joinable(); }
  // For lss/status. Page faults are read from /proc, allocations are counted by the thread.
  ThreadStatus status() const;
  // The counters restart from zero: the daemon is READY.
  void mark_ready();

 private:
  std::uint64_t page_faults_now() const;

  std::thread thread_;
  ThreadRequest request_;
  bool granted_ = true;
  std::atomic<pid_t> tid_{0};
  std::atomic<std::uint64_t> mallocs_{0};
  std::uint64_t page_faults_base_ = 0, mallocs_base_ = 0;
};

// Locks present and future pages when they are touched; false and a sentence when it is not
// permitted.
tl::expected<void, std::string> lock_memory();

// Faults in everything that is mapped now (code, data, heap), so that a real-time thread is never
// the first to touch a page. Called once, before the real-time threads start.
void populate_memory() noexcept;

// Touches the stack of the calling thread down to `bytes`, so that no frame faults it in later.
void touch_stack(std::size_t bytes) noexcept;

// Counts an allocation of the calling thread; called by the allocator of the daemon
// (runtime/malloc_count.cpp).
void count_malloc() noexcept;

}  // namespace lss::rt
