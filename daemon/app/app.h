#pragma once

// What main needs of a vehicle's running daemon. Implemented by Runtime<Vehicle>
// (daemon/app/runtime.h).

#include <string>
#include <tl/expected.hpp>
#include <vector>

#include "daemon/runtime/progress.h"
#include "idl/refusal.h"

namespace lss {

class App {
 public:
  virtual ~App() = default;

  // What of the configuration the vehicle cannot run with, and what to do; "": nothing. Before
  // start().
  virtual std::string wrong_configuration() const = 0;

  // DDS first, then memory, then the real-time threads.
  virtual tl::expected<void, Refusal> start() = 0;
  // Stops the vehicle, then ends all threads. Bounded: a flight lands, or ends by its own limits;
  // motors that brake have their time (daemon/cycle/ending.h).
  virtual void stop() = 0;

  // The turns of every thread, the frame's first: the watchdog is fed only while that one advances.
  virtual std::vector<Progress> progress() const = 0;
  virtual void keep_frames() = 0;           // writes the last frames to a file, as at a fault
  virtual void program_damaged() = 0;       // the vehicle stops, by the fault memory_lost
  virtual std::string summary() const = 0;  // one line for systemctl status
  // The vehicle does nothing, and a restart would use what DDS lacked at the start: network
  // interfaces; if configured, shared memory. nullptr: no reason.
  virtual const char* restart_reason() const = 0;
};

}  // namespace lss
