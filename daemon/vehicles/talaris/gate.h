#pragma once

// The gate of TALARIS: all orders to valves and fans pass it on their way out. Faulty orders are
// not sent: on the ground the safe command replaces them, everything shut and off; in the air
// valves shut and fans as before, since a vehicle whose fans stop falls. Pure functions; frame
// thread and tests.

#include <cstdint>

#include "daemon/cycle/controller.h"
#include "drivers/talaris/orders.h"

namespace lss::talaris {

enum class GateCheck : std::uint8_t {
  passed,
  fresh,     // not computed in this frame, or released at another time
  state,     // something open or running in a state that forbids it
  pulse,     // shorter than a valve's minimum, longer than the frame, or negative
  hold,      // open by hand for longer than allowed, or in a mode without valves by hand
  disabled,  // a disabled valve
  range,     // of a fan's pulse width
  slew,      // a fan speeds up faster than its batteries and bearings allow
  pause,     // a valve would open again too soon after its pulse of the frame before
};

struct GateLimits {
  TimeNs offset_ns = 0;      // of the release
  std::uint8_t enabled = 0;  // valves
  int fan_step_us = 0;       // largest increase in a frame; slowing down is not limited
  bool arming = false;       // start-up of the speed controllers: full at once
};

GateCheck check(const TalarisOrders& orders, const TalarisOrders& before,
                const lc::ControllerState& state, const GateLimits& limits, TimeNs now) noexcept;

// Whether the pause behind this valve's pulse of the frame before is one that it can make: none (it
// stays open), or its shortest.
bool pauses(const TalarisOrders& orders, const TalarisOrders& before, std::size_t valve) noexcept;

// Everything shut and off; times and serial numbers continue from `orders`.
void make_safe(TalarisOrders& orders) noexcept;

bool active(const TalarisOrders& orders) noexcept;  // a valve opens or a fan runs

}  // namespace lss::talaris
