#pragma once

// A CANopen master as a script, written from docs/icd-talaris.md: configures the nodes, gives
// heartbeats, valves and fans, and keeps the last frame of each identifier. Virtual time, one
// thread.

#include <array>
#include <vector>

#include "tests/support/can_script.h"
#include "tools/lss-sim/talaris/vehicle.h"

namespace lss::sim::talaris {

class Master : public ScriptedMaster {
 public:
  explicit Master(Talaris& world)
      : ScriptedMaster([&world](const CanFrame& frame) { world.receive(frame); },
                       [&world] { return world.send(); }),
        world_(world) {}

  // Milliseconds pass; heartbeats, fans and open valves are renewed.
  void run(int ms);
  // Boot-up, configuration, start; false when a node refuses.
  bool bring_up(std::vector<unsigned> nodes = {0x20, 0x21});
  void valves(unsigned bits);  // now
  // Start-up of the speed controllers.
  void arm();

  std::array<unsigned, kFans> fan_us{1000, 1000, 1000, 1000};
  bool heartbeat = true, renew_valves = true, renew_fans = true;

 private:
  bool configure(unsigned node);
  void say_fans();

  Talaris& world_;
  long now_ms_ = 0;
  unsigned open_ = 0, sequence_ = 0;
};

}  // namespace lss::sim::talaris
