#pragma once

// A HopperBus and a ValveSequencer in virtual time with the nodes of docs/icd-talaris.md on their
// bus. Nothing waits for a clock.

#include <vector>

#include "drivers/talaris/hopper_bus.h"
#include "drivers/talaris/valves.h"
#include "tests/support/can_world.h"
#include "tests/talaris/drivers/hopper_node.h"
#include "tests/talaris/drivers/lines.h"

namespace lss::talaris {

using canopen::NodeState;
using testing_support::HopperNode;

class HopperWorld final
    : public testing_support::CanWorld<HopperWorld, HopperBus, HopperNode, TalarisSample> {
 public:
  explicit HopperWorld(const HopperBusParameters& parameters = {});

  void release();          // new orders, of a frame that begins now
  void run_frames(int n);  // each: a release, then to the next frame
  void boot();             // until all nodes are operational
  void pump();
  TimeNs next_wake() const;

  NodeState state(std::size_t i) { return bus.status().link[i].node.state; }
  const HopperCounters& counters() { return bus.status().counters; }
  HopperNode& valve_node() { return node[0]; }
  HopperNode& fan_node() { return node[1]; }

  HopperBusParameters parameters;
  ValveSequencer valves;  // the actuate thread
  TalarisOrders orders{.enabled = 0xFF, .boot_allowed = true};
  bool actuate_dead = false;
};

}  // namespace lss::talaris
