#pragma once

// A vehicle that is nodes on one CAN bus and a light mechanism behind them: derive, add() the
// nodes, move the mechanism. One with slow physics derives from Vehicle and NodeBus itself, and
// steps them without the mutex.

#include <string>
#include <utility>

#include "tools/lss-sim/canopen/node_bus.h"
#include "tools/lss-sim/frame/vehicle.h"

namespace lss::sim::nodes {

class NodeVehicle : public Vehicle, public NodeBus {
 public:
  // `bus`: its name, for people.
  NodeVehicle(std::string bus, unsigned seed) : NodeBus(seed), bus_(std::move(bus)) {}

  std::vector<CanLine> can_buses() final { return {{bus_, this}}; }
  void step() final {
    const std::lock_guard lock(mutex_);
    step_nodes();
    move();
    note_waiting();
  }
  nlohmann::ordered_json truth() const final {
    const std::lock_guard lock(mutex_);
    return state();
  }
  void set_fault(const Fault& fault, bool attach) final {
    const std::lock_guard lock(mutex_);
    if (!set_node_fault(fault, attach)) set_own_fault(fault, attach);
    note_waiting();
  }

 protected:
  // With the mutex held.
  virtual void move() = 0;                           // a millisecond, after that of the nodes
  virtual nlohmann::ordered_json state() const = 0;  // the truth
  virtual void set_own_fault(const Fault&, bool /*attach*/) {}

 private:
  std::string bus_;
};

}  // namespace lss::sim::nodes
