#pragma once

// The gate of TALARIS: the one place where orders to valves and fans pass on their way out. Orders
// that cannot be right are not sent: on the ground the safe command goes out in their place,
// everything shut and off; in the air valves shut and fans as they were, for a vehicle whose fans
// stop falls. Pure functions; frame thread and tests.

#include <cstdint>

#include "daemon/lc/controller.h"
#include "drivers/talaris/orders.h"

namespace lss::talaris {

enum class GateCheck : std::uint8_t {
  passed,
  fresh,     // not computed in this frame, or released at another time
  state,     // something open or running where nothing may be
  pulse,     // shorter than valves can do, longer than the frame, or negative
  hold,      // open by hand for longer than that may be, or where valves are not opened by hand
  disabled,  // a valve that may not fire
  range,     // of a fan's pulse width
  slew,      // a fan shall go faster than its batteries and bearings should take
};

struct GateLimits {
  TimeNs offset_ns = 0;      // of the release
  std::uint8_t enabled = 0;  // valves
  int fan_step_us = 0;       // largest increase in a frame; slowing down is not limited
  bool arming = false;       // start-up of the speed controllers: full at once
};

GateCheck check(const TalarisOrders& orders, const TalarisOrders& before,
                const lc::ControllerState& state, const GateLimits& limits, TimeNs now) noexcept;

// Everything shut and off; `orders` gives the rest, times and serial numbers.
void make_safe(TalarisOrders& orders) noexcept;

bool active(const TalarisOrders& orders) noexcept;  // a valve opens or a fan runs

}  // namespace lss::talaris
