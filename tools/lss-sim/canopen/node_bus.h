#pragma once

// The nodes of a vehicle as the devices of one CAN bus: passes them the master's frames, lets them
// speak in turn, and carries out the faults of NodeFaultKinds. The base of a vehicle on a bus.
// Threads: receive() and send() from the bus's, wants_to_send() from any; all that is protected
// only with the mutex held, which also guards what a vehicle shares with its nodes.

#include <atomic>
#include <deque>
#include <mutex>
#include <random>
#include <vector>

#include "tools/lss-sim/canopen/node.h"
#include "tools/lss-sim/frame/can_bus.h"

namespace lss::sim::nodes {

class NodeBus : public CanDevice {
 public:
  explicit NodeBus(unsigned seed) : random_(seed) {}

  void receive(const CanFrame& frame) override;
  std::optional<CanFrame> send() override;
  bool wants_to_send() const override { return waiting_; }

  // For tests, which have one thread, and with the mutex held. Null: there is none.
  Node* node(std::uint8_t id);

 protected:
  void add(Node& node) { nodes_.push_back(&node); }  // before the first step
  void step_nodes();                                 // a millisecond of each
  void note_waiting();                               // after anything that lets a node speak
  // False: it is none of NodeFaultKinds.
  bool set_node_fault(const Fault& fault, bool attach);

  mutable std::mutex mutex_;

 private:
  void speak_foreign();
  bool set_signal_fault(Node& node, const Fault& fault, bool attach);

  std::vector<Node*> nodes_;
  std::size_t speaker_ = 0;  // node whose turn it is
  double foreign_1_s_ = 0, foreign_owed_ = 0;
  std::deque<CanFrame> foreign_;
  std::mt19937 random_;
  std::atomic<bool> waiting_ = false;
};

}  // namespace lss::sim::nodes
