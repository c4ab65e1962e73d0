#pragma once

// Marks what threads of the daemon execute in a chain in virtual time, apart from the test and the
// simulated world around it: there lss-campaign flips bits of registers and of the stack
// (tests/campaign/traps.h). Nobody else looks.

#include <cstdint>

namespace lss::testing_support {

enum class DaemonThread : std::uint8_t { frame, bus };  // bus: with actuate

// Called at both ends of such work, when they are set. Its part of the stack is below `stack_end`.
inline void (*work_begins)(DaemonThread thread, void* stack_end) = nullptr;
inline void (*work_ends)() = nullptr;

struct WorkMark {
  WorkMark(DaemonThread thread, void* stack_end) {
    if (work_begins != nullptr) work_begins(thread, stack_end);
  }
  ~WorkMark() {
    if (work_ends != nullptr) work_ends();
  }
  WorkMark(const WorkMark&) = delete;
  WorkMark& operator=(const WorkMark&) = delete;
};

// Not inline: so the work has a frame of its own on the stack.
template <class Work>
[[gnu::noinline]] auto on_thread(DaemonThread thread, const Work& work) {
  const WorkMark mark(thread, __builtin_frame_address(0));
  return work();
}
template <class Work>
auto frame_work(const Work& work) {
  return on_thread(DaemonThread::frame, work);
}
template <class Work>
auto bus_work(const Work& work) {
  return on_thread(DaemonThread::bus, work);
}

}  // namespace lss::testing_support
