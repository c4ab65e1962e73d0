#pragma once

// A CANopen master as a script, written from docs/icd-ardito.md: configures nodes, walks drives to
// operation enabled, gives SYNC, heartbeat and orders every 100 ms, and keeps the last frame of
// each identifier. Talks to a node or to the whole vehicle as a CanDevice, without threads or
// waiting.

#include <array>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "tests/ardito/sim/frames.h"
#include "tools/lss-sim/frame/can_bus.h"

namespace lss::sim::ardito {

class Master {
 public:
  // `step` lets a millisecond pass.
  Master(std::function<void(const CanFrame&)> tell, std::function<std::optional<CanFrame>()> hear,
         std::function<void()> step)
      : tell_(std::move(tell)), hear_(std::move(hear)), step_(std::move(step)) {}

  void tell(const CanFrame& frame) { tell_(frame); }
  void tell(const std::string& frame_text) { tell_(frame(frame_text)); }

  // Milliseconds pass; messages of nodes are kept.
  void run(int ms);
  // Cycles of 100 ms: heartbeat, SYNC at 90 ms, the orders of now before it.
  void cycle(int count = 1);

  // The answer to an SDO, as text.
  std::string ask(const std::string& request);
  // 0, or the abort code.
  std::uint32_t write(unsigned node, unsigned index, unsigned sub, unsigned bytes,
                      std::uint32_t value);
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

  std::vector<std::string> heard;          // since the last time it was cleared
  std::map<std::uint32_t, CanFrame> last;  // of each identifier
  unsigned statusword(unsigned node) const;

 private:
  bool configure_pdo(unsigned node, bool transmit, unsigned number,
                     const std::vector<std::uint32_t>& mapped, unsigned type, unsigned inhibit,
                     unsigned timer);
  void order(unsigned node, unsigned controlword, std::int32_t target);
  void collect();

  std::function<void(const CanFrame&)> tell_;
  std::function<std::optional<CanFrame>()> hear_;
  std::function<void()> step_;
  std::map<unsigned, std::int32_t> taken_;  // set-points that steering drives have
};

}  // namespace lss::sim::ardito
