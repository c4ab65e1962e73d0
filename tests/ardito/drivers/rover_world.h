#pragma once

// A RoverBus in virtual time with the twelve nodes of docs/icd-ardito.md on its bus. Nothing waits
// for a clock.

#include <vector>

#include "drivers/ardito/rover_bus.h"
#include "tests/ardito/drivers/can_node.h"
#include "tests/support/can_world.h"

namespace lss::ardito {

using testing_support::CanNode;

class RoverWorld final
    : public testing_support::CanWorld<RoverWorld, RoverBus, CanNode, RoverSample> {
 public:
  explicit RoverWorld(const RoverBusParameters& parameters = {});

  // New orders; with a new serial by default. They are released at the frame's begin.
  void release(bool again = true);
  void run_frames(int n);        // each: to the next frame boundary, then a release
  void boot();                   // until all nodes are operational
  void drive(double motor_rpm);  // all enabled, until all do it
  void pump() { pump_master(); }
  TimeNs next_wake() const { return master_dead ? INT64_MAX : bus.next_wake(); }

  CanNode& wheel(std::size_t i) { return node[i]; }
  CanNode& steering(std::size_t i) { return node[kFirstSteering + i]; }
  CanNode& io() { return node[kIo]; }
  CanNode& imu() { return node[kImu]; }
  const RoverLink& link(std::size_t i) { return bus.status().link[i]; }
  canopen::NodeState state(std::size_t i) { return link(i).node.state; }
  const RoverCounters& counters() { return bus.status().counters; }

  template <class T>
  std::vector<std::pair<TimeNs, T>> take_of() {
    std::vector<std::pair<TimeNs, T>> found;
    for (const RoverSample& s : take_all()) {
      if (const T* reading = std::get_if<T>(&s.reading)) found.emplace_back(s.time_ns, *reading);
    }
    return found;
  }

  RoverBusParameters parameters;
  RoverOrders orders{};
};

// Controlword of an RPDO1 to a drive, and its target.
inline int word_of(const CanFrame& f) { return f.data[0] | f.data[1] << 8; }
inline std::int32_t target_of(const CanFrame& f) {
  return static_cast<std::int32_t>(f.data[2] | std::uint32_t{f.data[3]} << 8 |
                                   std::uint32_t{f.data[4]} << 16 | std::uint32_t{f.data[5]} << 24);
}

}  // namespace lss::ardito
