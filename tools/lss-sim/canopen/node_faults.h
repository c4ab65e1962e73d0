#pragma once

// The faults that every CANopen node can have, as the types of faults of a vehicle: a vehicle names
// its nodes and adds its own types. NodeBus carries them out. Built once, at start; it exists as
// long as the program, because faults point into it.

#include <span>
#include <vector>

#include "tools/lss-sim/frame/faults.h"

namespace lss::sim::nodes {

class NodeFaultKinds {
 public:
  struct Nodes {
    std::vector<double> all;     // numbers on the bus, the highest last
    std::vector<double> drives;  // those of CiA 402; empty: no drive-fault
    const char* signals = "";    // which numbers its values have, for people
    double last_signal = 0;      // 0: no faults of values
  };

  // In the order of the list: the vehicle's own, the nodes', the vehicle's own.
  NodeFaultKinds(Nodes nodes, std::span<const FaultKind> first,
                 std::span<const FaultKind> last = {});
  NodeFaultKinds(const NodeFaultKinds&) = delete;
  NodeFaultKinds& operator=(const NodeFaultKinds&) = delete;

  std::span<const FaultKind> all() const { return kinds_; }

 private:
  using Arguments = std::vector<FaultArgument>;
  void add(const char* name, const Arguments& arguments, const char* meaning, std::size_t per_unit,
           bool momentary = false);

  Nodes nodes_;
  std::vector<Arguments> arguments_;
  std::vector<FaultKind> kinds_;
};

}  // namespace lss::sim::nodes
