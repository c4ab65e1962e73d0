#pragma once

// CAN frames for tests: by hand, and any.

#include <rapidcheck.h>

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

inline rc::Gen<CanFrame> any_frame() {
  return rc::gen::exec([] {
    CanFrame f;
    f.extended = *rc::gen::inRange(0, 10) == 0;
    f.remote = *rc::gen::inRange(0, 10) == 0;
    f.error = *rc::gen::inRange(0, 10) == 0;
    const bool wide = f.extended || f.error;
    f.id = *rc::gen::inRange<std::uint32_t>(0, (wide ? kExtendedIds : kStandardIds) + 1);
    f.size = *rc::gen::inRange<std::uint8_t>(0, 9);
    if (f.remote) return f;
    for (std::size_t i = 0; i < f.size; ++i) f.data[i] = *rc::gen::arbitrary<std::uint8_t>();
    return f;
  });
}

}  // namespace lss::testing_support
