#include "tests/ardito/sim/master.h"

#include <algorithm>

namespace lss::sim::ardito {
namespace {

constexpr unsigned kAll[] = {1, 2, 3, 4, 5, 6, 0x11, 0x12, 0x15, 0x16, 0x20, 0x21};

// The way to operation enabled: ICD section 9.
unsigned next_controlword(unsigned statusword) {
  if ((statusword & 0x4F) == 0x40) return 0x06;
  switch (statusword & 0x6F) {
    case 0x21:
      return 0x07;
    case 0x23:
    case 0x27:
      return 0x0F;
    default:
      return 0x00;
  }
}

}  // namespace

void Master::collect() {
  while (const auto heard_frame = hear_()) {
    heard.push_back(text(*heard_frame));
    last[heard_frame->id] = *heard_frame;
  }
}

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

std::string Master::ask(const std::string& request) {
  const CanFrame asked = frame(request);
  last.erase(asked.id - 0x80);
  tell(asked);
  collect();
  const auto answer = last.find(asked.id - 0x80);
  return answer == last.end() ? "nothing" : text(answer->second);
}

std::uint32_t Master::write(unsigned node, unsigned index, unsigned sub, unsigned bytes,
                            std::uint32_t value) {
  CanFrame request{.id = 0x600 + node, .size = 8};
  request.data = {static_cast<std::uint8_t>(0x23 | (4 - bytes) << 2),
                  static_cast<std::uint8_t>(index), static_cast<std::uint8_t>(index >> 8),
                  static_cast<std::uint8_t>(sub)};
  for (unsigned i = 0; i < bytes; ++i) {
    request.data[4 + i] = static_cast<std::uint8_t>(value >> 8 * i);
  }
  const CanFrame answer = frame(ask(text(request)));
  if (answer.data[0] == 0x60) return 0;
  return static_cast<std::uint32_t>(i32_at(answer, 4));
}

bool Master::configure_pdo(unsigned node, bool transmit, unsigned number,
                           const std::vector<std::uint32_t>& mapped, unsigned type,
                           unsigned inhibit, unsigned timer) {
  const unsigned parameters = (transmit ? 0x1800 : 0x1400) + number;
  const unsigned mapping = (transmit ? 0x1A00 : 0x1600) + number;
  const std::uint32_t no_remote = transmit ? 0x4000'0000 : 0;
  const std::uint32_t cob_id = (transmit ? 0x180 : 0x200) + 0x100 * number + node;
  std::uint32_t wrong = write(node, parameters, 1, 4, 0x8000'0000 | no_remote | cob_id);
  wrong |= write(node, mapping, 0, 1, 0);
  unsigned sub = 0;
  for (const std::uint32_t entry : mapped) wrong |= write(node, mapping, ++sub, 4, entry);
  wrong |= write(node, mapping, 0, 1, sub);
  wrong |= write(node, parameters, 2, 1, type);
  if (inhibit != 0) wrong |= write(node, parameters, 3, 2, inhibit);
  if (timer != 0) wrong |= write(node, parameters, 5, 2, timer);
  wrong |= write(node, parameters, 1, 4, no_remote | cob_id);
  return wrong == 0;
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
    good = good && configure_pdo(node, false, 0, {0x60400010, 0x60FF0020}, 255, 0, 0) &&
           configure_pdo(node, true, 0, {0x60410010, 0x606C0020, 0x60780010}, 1, 0, 0) &&
           configure_pdo(node, true, 1, {0x21000120, 0x21000220}, 1, 0, 0) &&
           configure_pdo(node, true, 2, {0x21010110, 0x21010210}, 255, 0, 1000);
  } else if (steering) {
    good = good && configure_pdo(node, false, 0, {0x60400010, 0x607A0020}, 255, 0, 0) &&
           configure_pdo(node, true, 0, {0x60410010, 0x60640020, 0x60780010}, 1, 0, 0) &&
           configure_pdo(node, true, 1, {0x21000320}, 1, 0, 0);
  } else if (node == 0x20) {
    wrong = write(node, 0x6206, 1, 1, 0x40) | write(node, 0x6207, 1, 1, 0x40);
    good = good && wrong == 0 && configure_pdo(node, false, 0, {0x62000108}, 255, 0, 0) &&
           configure_pdo(node, true, 0, {0x60000108}, 254, 20, 0) &&
           configure_pdo(node, true, 1, {0x64010110, 0x64010210, 0x64010310}, 1, 0, 0);
  } else {
    good = good &&
           configure_pdo(node, true, 0, {0x21100110, 0x21100210, 0x21100310, 0x21100410}, 1, 0, 0);
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
