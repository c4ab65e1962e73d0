#pragma once

// The cycle runs once per frame and is the same for every vehicle. It uses no clock, I/O, lock, log
// or allocation, and gets the time as data, so the same inputs give bit-identical outputs. It calls
// `mark` at the end of each stage (the frame thread stamps the timing points there).

#include <array>
#include <cstdint>

#include "daemon/cycle/supervisor.h"

namespace lss {

// Inputs of a frame: the samples stamped in [T_k-1, T_k), and the requests received.
template <class Vehicle>
struct Inputs {
  std::uint64_t frame = 0;
  TimeNs time_ns = 0;  // T_k
  std::array<typename Vehicle::Sample, Vehicle::kMaxSamples> samples{};
  std::uint32_t sample_count = 0;
  std::array<Request, kMaxRequests> requests{};
  std::uint32_t request_count = 0;
  typename Vehicle::BusReport bus{};
  std::uint64_t late_commands = 0;  // since the daemon's start
  bool overrun_limit = false;       // too many late commands in a row
  bool held = false;                // the clock began the frame: daemon/runtime/frames.h
  bool shut_down = false;           // the daemon ends: the vehicle must stop
  MemoryCheck memory = MemoryCheck::good;
};

template <class Vehicle>
struct Outputs {
  typename Vehicle::Command command{};
  typename Vehicle::Telemetry telemetry{};
  bool data_requested = false;
};

enum class Stage : std::uint8_t { read, supervised, navigated, guided, controlled, gated };

template <class Vehicle, class Mark>
void cycle(Vehicle& vehicle, Supervisor& supervisor, const Inputs<Vehicle>& in,
           Outputs<Vehicle>& out, Mark&& mark) noexcept {
  // read: the samples of the last frame
  vehicle.read(in);
  mark(Stage::read);

  // supervise: requests and the vehicle's reports, through the locomotion controller
  supervisor.begin(in.time_ns, vehicle);
  supervisor.check_memory(in.memory);
  for (std::uint32_t i = 0; i < in.request_count; ++i) supervisor.request(in.requests[i]);
  supervisor.count_late(in.late_commands);
  if (in.shut_down) supervisor.shut_down();
  vehicle.watch(in, supervisor);
  supervisor.check_links();
  mark(Stage::supervised);

  // navigate: position; guide: target; control: orders to the actuators
  vehicle.navigate(in.time_ns);
  mark(Stage::navigated);
  vehicle.guide(in.time_ns);
  mark(Stage::guided);
  const typename Vehicle::Command wanted = vehicle.control(in.time_ns);
  mark(Stage::controlled);

  // gate: checks every command, or replaces it by the safe command
  out.command = vehicle.gate(wanted, supervisor, in.time_ns);
  mark(Stage::gated);

  // write: the caller stores out.command for the actuate thread, which releases it
  out.data_requested = vehicle.describe(in, supervisor.state(), out.telemetry);
}

}  // namespace lss
