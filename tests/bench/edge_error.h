#pragma once

// Row xi: errors of edges at absolute times.

#include "drivers/time.h"
#include "tests/bench/bench.h"

namespace lss::bench {

struct Errors {
  Samples issued_us, written_us;
};

// Of the valve sequencer of TALARIS; in builds with that vehicle.
Errors valve_edges(int count, TimeNs spin_ns);

}  // namespace lss::bench
