#pragma once

// The wiring of a vehicle with one port and one bus thread, as daemon/app/runtime.h asks for it.
// Bus: daemon/runtime/can_bus.h or serial_bus.h. Start-up code, but where it says otherwise.

#include <functional>
#include <string>
#include <tl/expected.hpp>
#include <utility>
#include <vector>

#include "daemon/config/config.h"
#include "daemon/runtime/progress.h"

namespace lss::kit {

// The port of this name; of a configuration without it the first.
inline const config::Port& port_of(const config::Config& config, std::string_view name) {
  for (const config::Port& port : config.ports) {
    if (port.name == name) return port;
  }
  return config.ports.front();
}

template <class Vehicle, class Bus>
class OnePort {
 public:
  template <class... Arguments>
  explicit OnePort(const config::Port& port, Arguments&&... arguments)
      : name_("bus/" + port.name), bus_(std::forward<Arguments>(arguments)...) {}

  // Start-up: a port of the wrong kind is an error; an absent one is waited for.
  tl::expected<void, std::string> probe() { return bus_.probe(); }
  std::vector<std::pair<std::string, std::function<void()>>> bodies() {
    return {{name_, [this] { bus_.run(); }}};
  }
  std::vector<Progress> progress() const { return {{name_, bus_.turns()}}; }
  void stop() noexcept { bus_.stop(); }

  // Frame thread.
  template <class Inputs>
  void collect(Inputs& in) noexcept {
    in.sample_count = 0;
    while (in.sample_count < in.samples.size() && bus_.pop(in.samples[in.sample_count], in.time_ns))
      ++in.sample_count;
    in.bus = bus_.report();
  }
  // Actuate thread.
  template <class Command>
  void release(const Command& orders) noexcept {
    bus_.release(orders);
  }
  void all_stop() noexcept { bus_.all_stop(); }  // any thread

 protected:
  std::string name_;
  Bus bus_;
};

}  // namespace lss::kit
