#pragma once

// Bytes of a serial line with their receive errors. A terminal with INPCK and PARMRK writes a byte
// with a parity or framing error as FF 00 X, and a good FF as FF FF; a break is FF 00 00. Pure.

#include <cstddef>
#include <cstdint>
#include <span>

namespace lss {

struct LineByte {
  std::uint8_t value = 0;
  bool bad = false;  // parity, framing or break

  bool operator==(const LineByte&) const = default;
};

// Decodes the marks, which may be split between two reads.
class ParityMarks {
 public:
  // Decodes `raw` into `out`, which is at least as long. Returns the number of bytes.
  std::size_t decode(std::span<const std::uint8_t> raw, std::span<LineByte> out) noexcept;
  void clear() noexcept { state_ = State::plain; }

 private:
  enum class State : std::uint8_t { plain, escaped, marked };
  State state_ = State::plain;
};

}  // namespace lss
