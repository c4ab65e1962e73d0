#include "tests/talaris/sim/hopper_master.h"

#include <algorithm>

namespace lss::sim::talaris {

void Master::run(int ms) {
  for (int i = 0; i < ms; ++i, ++now_ms_) {
    if (heartbeat && now_ms_ % 25 == 0) tell("77F [1] 05");
    if (renew_fans && now_ms_ % 20 == 0) say_fans();
    if (renew_valves && open_ != 0 && now_ms_ % 50 == 0) valves(open_);
    world_.step();
    collect();
  }
}

void Master::valves(unsigned bits) {
  open_ = bits;
  sequence_ = sequence_ % 255 + 1;
  tell(fmt::format("220 [2] {:02X} {:02X}", bits, sequence_));
}

void Master::say_fans() {
  std::string said = "221 [8]";
  for (const unsigned us : fan_us) said += fmt::format(" {:02X} {:02X}", us & 0xFF, us >> 8);
  tell(said);
}

void Master::arm() {
  fan_us.fill(2000);
  run(380);
  fan_us.fill(1000);
  run(40);
}

bool Master::configure(unsigned node) {
  std::uint32_t wrong = write(node, 0x1017, 0, 2, 50) | write(node, 0x1016, 1, 4, 0x007F'0064) |
                        write(node, 0x1015, 0, 2, 100) | write(node, 0x1029, 1, 1, 0);
  const std::vector<std::uint32_t> four = {0x64010110, 0x64010210, 0x64010310, 0x64010410};
  if (node == 0x20) {
    wrong |= write(node, 0x6206, 1, 1, 0xFF) | write(node, 0x6207, 1, 1, 0) |
             write(node, 0x2201, 0, 2, 250);
    return wrong == 0 && configure_pdo(node, false, 0, {0x62000108, 0x22000008}, 255) &&
           configure_pdo(node, true, 1, four, 255, 0, 200);
  }
  if (node == 0x21) {
    for (unsigned sub = 1; sub <= 4; ++sub) {
      wrong |= write(node, 0x6443, sub, 1, 1) | write(node, 0x6444, sub, 4, 1000);
    }
    wrong |= write(node, 0x2201, 0, 2, 250);
    return wrong == 0 &&
           configure_pdo(node, false, 0, {0x64110110, 0x64110210, 0x64110310, 0x64110410}, 255) &&
           configure_pdo(node, true, 0, four, 255, 0, 20);
  }
  return wrong == 0 &&
         configure_pdo(node, true, 0, {0x64010110, 0x64010210, 0x64010310}, 255, 0, 2) &&
         configure_pdo(node, true, 1, {0x64010410, 0x64010510, 0x64010610}, 255, 0, 2);
}

bool Master::bring_up(std::vector<unsigned> nodes) {
  run(200);
  for (const unsigned node : nodes) {
    if (!last.contains(0x700 + node) || !configure(node)) return false;
    tell(fmt::format("000 [2] 01 {:02X}", node));
  }
  run(60);
  return std::ranges::all_of(nodes,
                             [&](unsigned node) { return last[0x700 + node].data[0] == 0x05; });
}

}  // namespace lss::sim::talaris
