#pragma once

// The time of a driver for properties: it is woken when it asks for it.

#include <rapidcheck.h>

#include "drivers/time.h"

namespace lss::testing_support {

// Moves `now` to `end`; pump() is what its thread does each time it is woken.
template <class Bus, class Pump>
void advance(const Bus& bus, TimeNs& now, TimeNs end, Pump&& pump) {
  while (true) {
    const TimeNs wake = bus.next_wake();
    RC_ASSERT(wake > now);
    if (wake > end) break;
    now = wake;
    pump();
  }
  now = end;
  pump();
}

}  // namespace lss::testing_support
