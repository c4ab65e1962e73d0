#pragma once

// A HopperBus and a ValveSequencer in virtual time with the nodes of docs/icd-talaris.md on their
// bus. Nothing waits for a clock.

#include <gtest/gtest.h>

#include <map>
#include <vector>

#include "drivers/talaris/hopper_bus.h"
#include "drivers/talaris/valves.h"
#include "tests/talaris/drivers/hopper_node.h"
#include "tests/talaris/drivers/lines.h"

namespace lss::talaris {

using canopen::NodeState;
using testing_support::HopperNode;

class HopperWorld {
 public:
  explicit HopperWorld(const HopperBusParameters& parameters = {});

  void run_until(TimeNs end);
  void run_for(TimeNs duration) { run_until(now + duration); }
  void release();          // new orders, of a frame that begins now
  void run_frames(int n);  // each: a release, then to the next frame
  void boot();             // until all nodes are operational
  void pump();
  std::vector<CanFrame> sent_with(std::uint32_t id) const;  // since sent was cleared
  std::vector<TalarisSample> take_all();

  NodeState state(std::size_t i) { return bus.status().link[i].node.state; }
  const HopperCounters& counters() { return bus.status().counters; }
  HopperNode& valve_node() { return node[0]; }
  HopperNode& fan_node() { return node[1]; }

  HopperBusParameters parameters;
  HopperBus bus;
  ValveSequencer valves;  // the actuate thread
  TalarisOrders orders{.enabled = 0xFF, .boot_allowed = true};
  std::vector<HopperNode> node;
  TimeNs now = kSecond;
  std::vector<CanFrame> sent;  // by both threads
  bool master_dead = false;    // sends and receives nothing
  bool actuate_dead = false;

 private:
  void put(const CanFrame& frame);
  void collect();

  std::multimap<TimeNs, CanFrame> events_;  // on their way to the master
};

}  // namespace lss::talaris
