#pragma once

// CAN frames as docs/icd-ardito.md writes them, "181 [8] 37 02 ...", both ways.

#include <fmt/format.h>

#include <cstdint>
#include <sstream>
#include <string>

#include "drivers/can/frame.h"

namespace lss::sim::ardito {

inline CanFrame frame(const std::string& text) {
  std::istringstream words(text);
  CanFrame made;
  std::string word;
  words >> std::hex >> made.id >> word;
  for (unsigned byte = 0; words >> byte;) {
    made.data[made.size++] = static_cast<std::uint8_t>(byte);
  }
  return made;
}

inline std::string text(const CanFrame& frame) {
  std::string made = fmt::format("{:03X} [{}]", frame.id, frame.size);
  for (std::size_t i = 0; i < frame.size; ++i) made += fmt::format(" {:02X}", frame.data[i]);
  return made;
}

inline std::int64_t i16_at(const CanFrame& frame, std::size_t at) {
  return static_cast<std::int16_t>(frame.data[at] | frame.data[at + 1] << 8);
}

inline std::int64_t i32_at(const CanFrame& frame, std::size_t at) {
  std::uint32_t value = 0;
  for (std::size_t i = 4; i-- > 0;) value = value << 8 | frame.data[at + i];
  return static_cast<std::int32_t>(value);
}

}  // namespace lss::sim::ardito
