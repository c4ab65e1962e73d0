#pragma once

// CAN frames as docs/icd-talaris.md writes them, "220 [2] 55 06", both ways, and packets as its
// rows of hexadecimal bytes.

#include <fmt/format.h>

#include <cstdint>
#include <span>
#include <sstream>
#include <string>
#include <vector>

#include "drivers/can/frame.h"

namespace lss::sim::talaris {

inline std::vector<std::uint8_t> bytes(const std::string& text) {
  std::istringstream words(text);
  std::vector<std::uint8_t> made;
  for (unsigned byte = 0; words >> std::hex >> byte;) {
    made.push_back(static_cast<std::uint8_t>(byte));
  }
  return made;
}

inline CanFrame frame(const std::string& text) {
  const std::size_t bracket = text.find(']');
  CanFrame made;
  made.id = static_cast<std::uint32_t>(std::stoul(text, nullptr, 16));
  for (const std::uint8_t byte : bytes(text.substr(bracket + 1))) made.data[made.size++] = byte;
  return made;
}

inline std::string text(const CanFrame& frame) {
  std::string made = fmt::format("{:03X} [{}]", frame.id, frame.size);
  for (std::size_t i = 0; i < frame.size; ++i) made += fmt::format(" {:02X}", frame.data[i]);
  return made;
}

inline int u16_at(const CanFrame& frame, std::size_t at) {
  return frame.data[at] | frame.data[at + 1] << 8;
}
inline int i16_at(const CanFrame& frame, std::size_t at) {
  return static_cast<std::int16_t>(u16_at(frame, at));
}

}  // namespace lss::sim::talaris
