#pragma once

// CAN frames for tests.

#include <algorithm>
#include <cstdint>
#include <vector>

#include "drivers/can/frame.h"

namespace lss::testing_support {

using Bytes = std::vector<std::uint8_t>;

inline CanFrame frame(std::uint32_t id, const Bytes& data, TimeNs time_ns = 0) {
  CanFrame f;
  f.time_ns = time_ns;
  f.id = id;
  f.size = static_cast<std::uint8_t>(data.size());
  std::copy(data.begin(), data.end(), f.data.begin());
  return f;
}

inline Bytes data_of(const CanFrame& f) { return {f.data.begin(), f.data.begin() + f.size}; }

}  // namespace lss::testing_support
