#pragma once

// Output of lss-bench: a table, JSON, or the document docs/performance.md.

#include <string>

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
std::string markdown(const Figures& figures, const Machine& machine, const std::string& command);

}  // namespace lss::bench
