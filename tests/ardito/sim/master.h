#pragma once

// A CANopen master as a script, written from docs/icd-ardito.md: configures nodes, walks drives to
// operation enabled, gives SYNC, heartbeat and orders every 100 ms, and keeps the last frame of
// each identifier. Talks to a node or to the whole vehicle as a CanDevice, without threads or
// waiting.

#include <map>
#include <optional>

#include "tests/support/can_script.h"
#include "tools/lss-sim/frame/can_bus.h"

namespace lss::sim::ardito {

class Master : public ScriptedMaster {
 public:
  // `step` lets a millisecond pass.
  Master(std::function<void(const CanFrame&)> tell, std::function<std::optional<CanFrame>()> hear,
         std::function<void()> step)
      : ScriptedMaster(std::move(tell), std::move(hear)), step_(std::move(step)) {}

  // Milliseconds pass; messages of nodes are kept.
  void run(int ms);
  // Cycles of 100 ms: heartbeat, SYNC at 90 ms, the orders of now before it.
  void cycle(int count = 1);

  // Waits for boot-up, writes the ICD's configuration, starts it. False when anything is refused.
  bool bring_up(unsigned node);
  bool bring_up_all();
  // One step each cycle until all drives of the map of orders are enabled.
  bool enable_drives();

  // Orders, sent in each cycle; a drive without one gets none.
  std::map<unsigned, std::int32_t> wheel_rpm;        // nodes 1..6
  std::map<unsigned, std::int32_t> steering_counts;  // nodes 0x11...
  std::optional<std::uint8_t> outputs;               // of node 0x20
  bool heartbeat = true;

  unsigned statusword(unsigned node) const;

 private:
  void order(unsigned node, unsigned controlword, std::int32_t target);

  std::function<void()> step_;
  std::map<unsigned, std::int32_t> taken_;  // set-points that steering drives have
};

}  // namespace lss::sim::ardito
