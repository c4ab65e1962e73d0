#include "tests/ardito/sim/master.h"

#include <algorithm>

namespace lss::sim::ardito {
namespace {

constexpr unsigned kAll[] = {1, 2, 3, 4, 5, 6, 0x11, 0x12, 0x15, 0x16, 0x20, 0x21};

// The way to operation enabled, by CiA 402.
unsigned next_controlword(unsigned statusword) {
  if ((statusword & 0x4F) == 0x40) return 0x06;
  switch (statusword & 0x6F) {
    case 0x21: return 0x07;
    case 0x23:
    case 0x27: return 0x0F;
    default: return 0x00;
  }
}

}  // namespace

void Master::run(int ms) {
  for (int i = 0; i < ms; ++i) {
    step_();
    collect();
  }
}

void Master::cycle(int count) {
  for (int i = 0; i < count; ++i) {
    if (heartbeat) tell("77F [1] 05");
    for (const auto& [node, rpm] : wheel_rpm) order(node, next_controlword(statusword(node)), rpm);
    for (const auto& [node, counts] : steering_counts) {
      unsigned control = next_controlword(statusword(node));
      const bool enabled = (statusword(node) & 0x6F) == 0x27;
      if (enabled) control = 0x2F;
      order(node, control, counts);
      const auto taken = taken_.find(node);
      if (!enabled || (taken != taken_.end() && taken->second == counts)) continue;
      run(1);
      order(node, 0x3F, counts);
      taken_[node] = counts;
    }
    if (outputs) tell(fmt::format("220 [1] {:02X}", *outputs));
    run(90);
    tell("080 [0]");
    run(10);
  }
}

void Master::order(unsigned node, unsigned controlword, std::int32_t target) {
  const auto bits = static_cast<std::uint32_t>(target);
  CanFrame rpdo{.id = 0x200 + node, .size = 6};
  rpdo.data = {static_cast<std::uint8_t>(controlword), static_cast<std::uint8_t>(controlword >> 8)};
  for (unsigned i = 0; i < 4; ++i) rpdo.data[2 + i] = static_cast<std::uint8_t>(bits >> 8 * i);
  tell(rpdo);
}

unsigned Master::statusword(unsigned node) const {
  const auto found = last.find(0x180 + node);
  return found == last.end() ? 0u : static_cast<unsigned>(i16_at(found->second, 0)) & 0xFFFF;
}

bool Master::bring_up(unsigned node) {
  for (int ms = 0; !last.contains(0x700 + node); ++ms) {
    if (ms > 500) return false;
    run(1);
  }
  const bool wheel = node <= 6, steering = node >= 0x11 && node <= 0x16;
  std::uint32_t wrong = write(node, 0x1017, 0, 2, 100) | write(node, 0x1016, 1, 4, 0x007F012C) |
                        write(node, 0x1015, 0, 2, 100) | write(node, 0x1029, 1, 1, 0);
  if (wheel || steering) {
    const std::uint32_t ramp = wheel ? 8000 : 1'000'000;
    wrong |= write(node, 0x6007, 0, 2, 3) | write(node, 0x605A, 0, 2, 6) |
             write(node, 0x6060, 0, 1, wheel ? 3 : 1);
    if (steering) wrong |= write(node, 0x6081, 0, 4, 250'000);
    for (const unsigned index : {0x6083u, 0x6084u, 0x6085u})
      wrong |= write(node, index, 0, 4, ramp);
  }
  bool good = wrong == 0;
  if (wheel) {
    good = good && configure_pdo(node, false, 0, {0x60400010, 0x60FF0020}, 255) &&
           configure_pdo(node, true, 0, {0x60410010, 0x606C0020, 0x60780010}, 1) &&
           configure_pdo(node, true, 1, {0x21000120, 0x21000220}, 1) &&
           configure_pdo(node, true, 2, {0x21010110, 0x21010210}, 255, 0, 1000);
  } else if (steering) {
    good = good && configure_pdo(node, false, 0, {0x60400010, 0x607A0020}, 255) &&
           configure_pdo(node, true, 0, {0x60410010, 0x60640020, 0x60780010}, 1) &&
           configure_pdo(node, true, 1, {0x21000320}, 1);
  } else if (node == 0x20) {
    wrong = write(node, 0x6206, 1, 1, 0x40) | write(node, 0x6207, 1, 1, 0x40);
    good = good && wrong == 0 && configure_pdo(node, false, 0, {0x62000108}, 255) &&
           configure_pdo(node, true, 0, {0x60000108}, 254, 20) &&
           configure_pdo(node, true, 1, {0x64010110, 0x64010210, 0x64010310}, 1);
  } else {
    good =
        good && configure_pdo(node, true, 0, {0x21100110, 0x21100210, 0x21100310, 0x21100410}, 1);
  }
  tell(fmt::format("000 [2] 01 {:02X}", node));
  return good;
}

bool Master::bring_up_all() {
  return std::ranges::all_of(kAll, [&](unsigned node) { return bring_up(node); });
}

bool Master::enable_drives() {
  const auto enabled = [&](const auto& order) { return (statusword(order.first) & 0x6F) == 0x27; };
  for (int i = 0; i < 8; ++i) {
    cycle();
    if (std::ranges::all_of(wheel_rpm, enabled) && std::ranges::all_of(steering_counts, enabled)) {
      return true;
    }
  }
  return false;
}

}  // namespace lss::sim::ardito
