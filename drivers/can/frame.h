#pragma once

// One classical CAN frame, as used by all CAN drivers of this project.

#include <array>
#include <cstdint>

#include "drivers/time.h"

namespace lss {

struct CanFrame {
  TimeNs time_ns = 0;    // received: when the kernel had it; to be sent: when it was made
  std::uint32_t id = 0;  // 11 bits, or 29 when extended; error frame: bits of the error
  bool extended = false;
  bool remote = false;    // asks for data and has none; `size` is how much it asks for
  bool error = false;     // made by the kernel, never on the wire
  std::uint8_t size = 0;  // of data, 0 to 8
  std::array<std::uint8_t, 8> data{};

  bool operator==(const CanFrame&) const = default;
};

inline constexpr std::uint32_t kStandardIds = 0x7FF;
inline constexpr std::uint32_t kExtendedIds = 0x1FFF'FFFF;

// Standard data frames with (identifier & mask) == id pass.
struct CanFilter {
  std::uint32_t id = 0;
  std::uint32_t mask = 0;
};

}  // namespace lss
