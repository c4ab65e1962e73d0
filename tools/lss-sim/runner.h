#pragma once

// Runs one vehicle in real time until SIGTERM or SIGINT: a physics thread at 1 kHz on
// CLOCK_MONOTONIC, a thread for each serial line and CAN bus, and the caller's thread for signals
// and faults.
// When the machine is too slow, simulated time slips against the clock, which is counted and said
// at the end; it never races after it.

#include <filesystem>
#include <optional>
#include <string>
#include <tl/expected.hpp>
#include <vector>

#include "tools/lss-sim/vehicle.h"

namespace lss::sim {

struct RunOptions {
  std::filesystem::path folder;
  bool pace = false;
  int baud = 115'200;
  std::string can;  // where the CAN bus is found; empty: where the vehicle has it by default
  unsigned seed = 1;
  double speed = 1;          // of physics against the clock; the bytes keep their rate
  double client_speed = -1;  // in lockstep while a client takes part, 0: any; -1: the same
  bool lockstep = false;  // simulated time: docs/simulator.md; speed is that of time then, 0: any
  double client_at_s = -1, for_s = -1;  // of simulated time; below 0: no such time
  std::optional<std::filesystem::path> truth;
  std::vector<TimedFault> faults;
};

// The vehicle's own, those of its lines or bus, and unplug.
std::vector<FaultKind> fault_kinds_of(const VehicleKind& kind);

// The error says what failed at start.
tl::expected<void, std::string> run(const VehicleKind& kind, const RunOptions& options);

}  // namespace lss::sim
