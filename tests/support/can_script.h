#pragma once

// CAN frames as the interface documents write them, "181 [8] 37 02 ...", both ways; and the part
// that scripted CANopen masters share: SDO and PDO configuration, and what the nodes said. One
// thread, no waiting.

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "drivers/can/frame.h"

namespace lss::sim {

inline std::vector<std::uint8_t> bytes(const std::string& text) {
  std::istringstream words(text);
  std::vector<std::uint8_t> made;
  for (unsigned byte = 0; words >> std::hex >> byte;)
    made.push_back(static_cast<std::uint8_t>(byte));
  return made;
}

inline CanFrame frame(const std::string& text) {
  CanFrame made;
  made.id = static_cast<std::uint32_t>(std::stoul(text, nullptr, 16));
  for (const std::uint8_t byte : bytes(text.substr(text.find(']') + 1)))
    made.data[made.size++] = byte;
  return made;
}

inline std::string text(const CanFrame& frame) {
  std::string made = fmt::format("{:03X} [{}]", frame.id, frame.size);
  for (std::size_t i = 0; i < frame.size; ++i) made += fmt::format(" {:02X}", frame.data[i]);
  return made;
}

// Little-endian, from byte `at` on.
inline std::uint32_t u32_at(const CanFrame& frame, std::size_t at) {
  std::uint32_t value = 0;
  for (std::size_t i = 4; i-- > 0;) value = value << 8 | frame.data[at + i];
  return value;
}
inline int u16_at(const CanFrame& frame, std::size_t at) {
  return frame.data[at] | frame.data[at + 1] << 8;
}
inline int i16_at(const CanFrame& frame, std::size_t at) {
  return static_cast<std::int16_t>(u16_at(frame, at));
}
inline std::int32_t i32_at(const CanFrame& frame, std::size_t at) {
  return static_cast<std::int32_t>(u32_at(frame, at));
}

class ScriptedMaster {
 public:
  // `tell` gives a frame to the nodes, `hear` takes one of theirs.
  ScriptedMaster(std::function<void(const CanFrame&)> tell,
                 std::function<std::optional<CanFrame>()> hear)
      : tell_(std::move(tell)), hear_(std::move(hear)) {}

  void tell(const CanFrame& frame) { tell_(frame); }
  void tell(const std::string& frame_text) { tell_(frame(frame_text)); }

  // The answer to an SDO, as text.
  std::string ask(const std::string& request) {
    const CanFrame asked = frame(request);
    last.erase(asked.id - 0x80);
    tell(asked);
    collect();
    const auto answer = last.find(asked.id - 0x80);
    return answer == last.end() ? "nothing" : text(answer->second);
  }
  // 0, or the abort code.
  std::uint32_t write(unsigned node, unsigned index, unsigned sub, unsigned size,
                      std::uint32_t value) {
    std::string request = fmt::format("{:03X} [8] {:02X} {:02X} {:02X} {:02X}", 0x600 + node,
                                      0x23 | (4 - size) << 2, index & 0xFF, index >> 8, sub);
    for (unsigned i = 0; i < 4; ++i) request += fmt::format(" {:02X}", value >> 8 * i & 0xFF);
    const std::string answer = ask(request);
    if (answer == "nothing") return ~0u;
    const CanFrame said = frame(answer);
    return said.data[0] == 0x60 ? 0 : u32_at(said, 4);
  }
  // False when a write is refused. Inhibit time in 0.1 ms and event timer in ms: 0 is not written.
  bool configure_pdo(unsigned node, bool transmit, unsigned number,
                     const std::vector<std::uint32_t>& mapped, unsigned type, unsigned inhibit = 0,
                     unsigned timer = 0) {
    const unsigned parameters = (transmit ? 0x1800 : 0x1400) + number;
    const unsigned mapping = (transmit ? 0x1A00 : 0x1600) + number;
    const std::uint32_t cob_id = (transmit ? 0x4000'0180u : 0x200u) + 0x100 * number + node;
    std::uint32_t wrong = write(node, parameters, 1, 4, 0x8000'0000 | cob_id);
    wrong |= write(node, mapping, 0, 1, 0);
    unsigned sub = 0;
    for (const std::uint32_t entry : mapped) wrong |= write(node, mapping, ++sub, 4, entry);
    wrong |= write(node, mapping, 0, 1, sub) | write(node, parameters, 2, 1, type);
    if (inhibit != 0) wrong |= write(node, parameters, 3, 2, inhibit);
    if (timer != 0) wrong |= write(node, parameters, 5, 2, timer);
    return (wrong | write(node, parameters, 1, 4, cob_id)) == 0;
  }

  std::vector<std::string> heard;                  // since the last time it was cleared
  std::map<std::uint32_t, CanFrame> last;          // of each identifier
  int count(const std::string& beginning) const {  // of received frames
    return static_cast<int>(std::ranges::count_if(
        heard, [&](const std::string& each) { return each.starts_with(beginning); }));
  }

 protected:
  void collect() {
    while (const auto said = hear_()) {
      heard.push_back(text(*said));
      last[said->id] = *said;
    }
  }

 private:
  std::function<void(const CanFrame&)> tell_;
  std::function<std::optional<CanFrame>()> hear_;
};

}  // namespace lss::sim
