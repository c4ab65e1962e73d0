#pragma once

// Runs one vehicle in real time until SIGTERM or SIGINT: a physics thread at 1 kHz on
// CLOCK_MONOTONIC, a thread for each serial line and CAN bus, and the caller's thread for signals
// and faults. On a machine that is too slow, simulated time falls behind the clock. This is counted
// and reported at the end; simulated time never catches up.

#include <filesystem>
#include <optional>
#include <string>
#include <tl/expected.hpp>
#include <vector>

#include "tools/lss-sim/frame/vehicle.h"

namespace lss::sim {

struct RunOptions {
  std::filesystem::path folder;
  bool pace = false;
  int baud = 115'200;
  std::string can;  // place of the CAN bus; empty: the vehicle's default
  unsigned seed = 1;
  double speed = 1;          // of physics relative to the clock; the bytes keep their rate
  double client_speed = -1;  // in lockstep while a client takes part, 0: any; -1: the same
  bool lockstep = false;  // simulated time: docs/simulator.md; `speed` is then that of time, 0: any
  double client_at_s = -1, for_s = -1;  // of simulated time; below 0: none
  std::optional<std::filesystem::path> truth;
  std::vector<TimedFault> faults;
};

// The vehicle's own, those of its lines or bus, and unplug.
std::vector<FaultKind> fault_kinds_of(const VehicleKind& kind);

// The error names the failure at start.
tl::expected<void, std::string> run(const VehicleKind& kind, const RunOptions& options);

}  // namespace lss::sim
