#pragma once

// The scheduling latency of the kernel, from a timer's due time to the thread running, as a tool of
// others measures it on this machine. Main thread.

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace lss::cli::certify {

struct Scheduling {
  double us = 0;
  std::string tool;  // what was run, or where the number is from
  std::string note;  // what it is worth
};

// Where the threads of a configuration run.
struct Place {
  int priority = 0;         // SCHED_FIFO: the lowest of theirs
  std::vector<int> cpus{};  // empty: any
};

// rtla timerlat, else cyclictest. A Failure says what is missing for both.
Scheduling measure_scheduling(const Place& place, int seconds);

// Of `rtla timerlat hist --nano`, in us, over its CPUs.
struct Timerlat {
  double irq_us = 0;     // timer due to its interrupt handler
  double thread_us = 0;  // timer due to the thread running
};
std::optional<Timerlat> parse_timerlat(std::string_view output);
// The largest, over all threads, of `cyclictest --quiet --nsecs`, in us.
std::optional<double> parse_cyclictest(std::string_view output);

// Runs a program with these words, found as the shell finds it, and waits. code: as the shell's;
// 127: there is no such program. Both of its streams, one behind the other as written.
struct Ran {
  int code = 0;
  std::string output{};
};
Ran run_program(const std::vector<std::string>& words);

}  // namespace lss::cli::certify
