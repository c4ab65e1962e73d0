#include "tests/talaris/sim/hopper_master.h"

#include <algorithm>

namespace lss::sim::talaris {

void Master::collect() {
  while (const auto said = world_.send()) {
    heard.push_back(text(*said));
    last[said->id] = *said;
  }
}

int Master::count(const std::string& beginning) const {
  return static_cast<int>(std::ranges::count_if(
      heard, [&](const std::string& each) { return each.starts_with(beginning); }));
}

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

std::string Master::ask(const std::string& request) {
  const CanFrame asked = frame(request);
  last.erase(asked.id - 0x80);
  world_.receive(asked);
  collect();
  const auto answer = last.find(asked.id - 0x80);
  return answer == last.end() ? "nothing" : text(answer->second);
}

std::uint32_t Master::write(unsigned node, unsigned index, unsigned sub, unsigned size,
                            std::uint32_t value) {
  std::string request = fmt::format("{:03X} [8] {:02X} {:02X} {:02X} {:02X}", 0x600 + node,
                                    0x23 | (4 - size) << 2, index & 0xFF, index >> 8, sub);
  for (unsigned i = 0; i < 4; ++i) request += fmt::format(" {:02X}", value >> 8 * i & 0xFF);
  const std::string answer = ask(request);
  if (answer == "nothing") return ~0u;
  const CanFrame said = frame(answer);
  if (said.data[0] == 0x60) return 0;
  return static_cast<std::uint32_t>(u16_at(said, 4)) | static_cast<std::uint32_t>(u16_at(said, 6))
                                                           << 16;
}

bool Master::configure_pdo(unsigned node, bool transmit, unsigned number,
                           const std::vector<std::uint32_t>& mapped, unsigned timer) {
  const unsigned parameters = (transmit ? 0x1800 : 0x1400) + number;
  const unsigned mapping = (transmit ? 0x1A00 : 0x1600) + number;
  const std::uint32_t cob_id = (transmit ? 0x4000'0180u : 0x200u) + 0x100 * number + node;
  std::uint32_t wrong = write(node, parameters, 1, 4, 0x8000'0000 | cob_id);
  wrong |= write(node, mapping, 0, 1, 0);
  unsigned sub = 0;
  for (const std::uint32_t entry : mapped) wrong |= write(node, mapping, ++sub, 4, entry);
  wrong |= write(node, mapping, 0, 1, sub) | write(node, parameters, 2, 1, 255);
  if (transmit) wrong |= write(node, parameters, 5, 2, timer);
  return (wrong | write(node, parameters, 1, 4, cob_id)) == 0;
}

bool Master::configure(unsigned node) {
  std::uint32_t wrong = write(node, 0x1017, 0, 2, 50) | write(node, 0x1016, 1, 4, 0x007F'0064) |
                        write(node, 0x1015, 0, 2, 100) | write(node, 0x1029, 1, 1, 0);
  const std::vector<std::uint32_t> four = {0x64010110, 0x64010210, 0x64010310, 0x64010410};
  if (node == 0x20) {
    wrong |= write(node, 0x6206, 1, 1, 0xFF) | write(node, 0x6207, 1, 1, 0) |
             write(node, 0x2201, 0, 2, 250);
    return wrong == 0 && configure_pdo(node, false, 0, {0x62000108, 0x22000008}, 0) &&
           configure_pdo(node, true, 1, four, 200);
  }
  if (node == 0x21) {
    for (unsigned sub = 1; sub <= 4; ++sub) {
      wrong |= write(node, 0x6443, sub, 1, 1) | write(node, 0x6444, sub, 4, 1000);
    }
    wrong |= write(node, 0x2201, 0, 2, 250);
    return wrong == 0 &&
           configure_pdo(node, false, 0, {0x64110110, 0x64110210, 0x64110310, 0x64110410}, 0) &&
           configure_pdo(node, true, 0, four, 20);
  }
  return wrong == 0 && configure_pdo(node, true, 0, {0x64010110, 0x64010210, 0x64010310}, 2) &&
         configure_pdo(node, true, 1, {0x64010410, 0x64010510, 0x64010610}, 2);
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
