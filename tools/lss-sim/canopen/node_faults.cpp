#include "tools/lss-sim/canopen/node_faults.h"

#include <utility>

namespace lss::sim::nodes {
namespace {

FaultArgument node_of(std::span<const double> choices) {
  return {.name = "NODE",
          .meaning = "number on the bus",
          .min = 1,
          .max = choices.back(),
          .whole = true,
          .hexadecimal = true,
          .choices = choices};
}
FaultArgument rate_of(double fallback) {
  return {"RATE", "frames a second", 1, 10'000, false, true, fallback};
}

}  // namespace

NodeFaultKinds::NodeFaultKinds(Nodes nodes, std::span<const FaultKind> first,
                               std::span<const FaultKind> last)
    : nodes_(std::move(nodes)), kinds_(first.begin(), first.end()) {
  const FaultArgument node = node_of(nodes_.all);
  const FaultArgument code = {"CODE", "of CiA 301", 1, 0xFFFF, true, false, 0, true};
  const FaultArgument drive_code = {"CODE", "of the EMCY", 1, 0xFFFF, true, true, 0x2310, true};
  const FaultArgument bytes = {"BYTES", "too many", -8, 8, true, true, -1};
  const FaultArgument abort = {"CODE", "abort code", 1, 0xFFFFFFFF, true, true, 0x08000000, true};
  const FaultArgument type = {"TYPE", "that it claims", 1,   0xFFFFFFFF, true,
                              true,   0x000F0191,       true};
  add("node-silent", {node}, "a node neither sends nor receives, and continues by itself", 1);
  add("node-reboot", {node}, "a node restarts once", 1, true);
  add("emcy", {node, code}, "a node reports this error until it is cleared", 2);
  add("emcy-storm", {node, rate_of(500)}, "a node sends EMCY after EMCY", 1);
  if (!nodes_.drives.empty())
    add("drive-fault", {node_of(nodes_.drives), drive_code},
        "a drive goes to fault once, with this EMCY", 1, true);
  add("babble", {node, rate_of(2000)}, "a node sends frames that nobody asked for", 1);
  add("foreign-frames", {rate_of(100)}, "frames of unknown nodes and types", 0);
  add("wrong-pdo-length", {node, bytes}, "a node's PDOs are too long or too short", 1);
  add("sdo-abort", {node, abort}, "a node refuses every SDO", 1);
  add("wrong-device-type", {node, type}, "a node is another device", 1);
  if (nodes_.last_signal > 0) {
    const FaultArgument signal = {"SIGNAL", "as of stuck", 1, nodes_.last_signal, true};
    FaultArgument signals = signal;
    signals.meaning = nodes_.signals;
    const FaultArgument rate = {"UNITS", "of the bus a second", -1e6, 1e6};
    const FaultArgument units = {"UNITS", "of the bus", -1e7, 1e7};
    add("stuck", {node, signals}, "a value of a node stays as it is", 2);
    add("drift", {node, signal, rate}, "a value of a node runs away", 2);
    add("encoder-jump", {node, signal, units}, "a value of a node is wrong by this", 2);
  }
  kinds_.insert(kinds_.end(), last.begin(), last.end());
}

// A vector's elements stay where they are when the vector of vectors grows.
void NodeFaultKinds::add(const char* name, const Arguments& arguments, const char* meaning,
                         std::size_t per_unit, bool momentary) {
  arguments_.push_back(arguments);
  kinds_.push_back({name, arguments_.back(), meaning, momentary, per_unit});
}

}  // namespace lss::sim::nodes
