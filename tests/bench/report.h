#pragma once

// Output of lss-bench: a table, JSON, or the document docs/performance.md.

#include <string>
#include <string_view>

#include "tests/bench/bench.h"

namespace lss::bench {

std::string table(const Figures& figures);
std::string json(const Figures& figures);

// The machine at the start of the run.
struct Machine {
  std::string cpu, kernel, preemption, governor, date, load;
  unsigned cpus = 0;
};
Machine this_machine();
// Of what `uname -v` says: not every kernel with PREEMPT_RT has /sys/kernel/realtime.
inline std::string preemption(std::string_view version) {
  if (version.find("PREEMPT_RT") != version.npos) return "PREEMPT_RT";
  if (version.find("PREEMPT_DYNAMIC") != version.npos) return "PREEMPT_DYNAMIC, not PREEMPT_RT";
  return "not PREEMPT_RT";
}
std::string markdown(const Figures& figures, const Machine& machine, const std::string& command);

}  // namespace lss::bench
