#include "drivers/serial/line_byte.h"

namespace lss {

std::size_t ParityMarks::decode(std::span<const std::uint8_t> raw,
                                std::span<LineByte> out) noexcept {
  std::size_t count = 0;
  for (const std::uint8_t byte : raw) {
    switch (state_) {
      case State::plain:
        if (byte == 0xFF)
          state_ = State::escaped;
        else
          out[count++] = {byte, false};
        break;
      case State::escaped:
        if (byte == 0x00) {
          state_ = State::marked;
        } else {  // FF FF; a terminal writes no other sequence
          state_ = State::plain;
          out[count++] = {byte, byte != 0xFF};
        }
        break;
      case State::marked:
        state_ = State::plain;
        out[count++] = {byte, true};
        break;
    }
  }
  return count;
}

}  // namespace lss
