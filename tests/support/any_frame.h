#pragma once

// Any CAN frame, for properties.

#include <rapidcheck.h>

#include "drivers/can/frame.h"

namespace lss::testing_support {

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
