#pragma once

// A CANopen master as a script, written from docs/icd-talaris.md: configures the nodes, gives
// heartbeats, valves and fans, and keeps the last frame of each identifier. Virtual time, one
// thread.

#include <array>
#include <map>
#include <string>
#include <vector>

#include "tests/talaris/sim/hopper_frames.h"
#include "tools/lss-sim/talaris/vehicle.h"

namespace lss::sim::talaris {

class Master {
 public:
  explicit Master(Talaris& world) : world_(world) {}

  void tell(const std::string& frame_text) { world_.receive(frame(frame_text)); }
  // Milliseconds pass; heartbeats, fans and open valves are renewed.
  void run(int ms);
  // The answer to an SDO, as text.
  std::string ask(const std::string& request);
  // 0, or the abort code.
  std::uint32_t write(unsigned node, unsigned index, unsigned sub, unsigned size,
                      std::uint32_t value);
  // Boot-up, configuration, start; false when a node refuses.
  bool bring_up(std::vector<unsigned> nodes = {0x20, 0x21});
  void valves(unsigned bits);  // now
  // Start-up of the speed controllers.
  void arm();

  std::array<unsigned, kFans> fan_us{1000, 1000, 1000, 1000};
  bool heartbeat = true, renew_valves = true, renew_fans = true;

  std::vector<std::string> heard;
  int count(const std::string& beginning) const;  // of received frames
  std::map<std::uint32_t, CanFrame> last;

 private:
  void collect();
  bool configure(unsigned node);
  bool configure_pdo(unsigned node, bool transmit, unsigned number,
                     const std::vector<std::uint32_t>& mapped, unsigned timer);
  void say_fans();

  Talaris& world_;
  long now_ms_ = 0;
  unsigned open_ = 0, sequence_ = 0;
};

}  // namespace lss::sim::talaris
