#pragma once

// One cycle, once per frame, the same for every vehicle. The same inputs give bit-identical
// outputs: no clock, I/O, lock, log or allocation in here; time is data. `mark` is called at the
// end of each stage (the frame thread stamps the timing points with it).

#include <array>
#include <cstdint>

#include "daemon/cycle/supervisor.h"

namespace lss {

// Inputs of a frame: the batch stamped in [T_k-1, T_k), and the requests received.
template <class Vehicle>
struct Inputs {
  std::uint64_t frame = 0;
  TimeNs time_ns = 0;  // T_k
  std::array<typename Vehicle::Sample, Vehicle::kMaxSamples> samples{};
  std::uint32_t sample_count = 0;
  std::array<Request, kMaxRequests> requests{};
  std::uint32_t request_count = 0;
  typename Vehicle::BusReport bus{};
  std::uint64_t late_commands = 0;  // so far
  bool overrun_limit = false;       // too many in a row
  bool held = false;                // begun by the clock, see daemon/runtime/frames.h
  bool shut_down = false;           // the daemon stops: to the safe command
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

  // gate: every command passes it on its way out
  out.command = vehicle.gate(wanted, supervisor, in.time_ns);
  mark(Stage::gated);

  // write: the caller puts out.command into the slot that the actuate thread releases
  out.data_requested = vehicle.describe(in, supervisor.state(), out.telemetry);
}

}  // namespace lss
