#pragma once

// The gate of Lunar Zebro: all orders to the modules pass it on their way out. An order that is out
// of range, too fast, stale or not allowed in the state replaces all orders by the safe command,
// the emergency stop of every module. Pure functions; frame thread and tests.

#include <array>
#include <cstdint>

#include "daemon/cycle/controller.h"
#include "drivers/zebro/leg_bus.h"

namespace lss::zebro {

enum class GateCheck : std::uint8_t {
  passed,
  range,  // position or arrival time that no module can take
  slew,   // faster than the leg may turn
  fresh,  // not computed in this frame
  state,  // motion outside Operational (the panel: outside its own movement)
};

struct GateLimits {
  double turn_rate_deg_s = 0;  // the fastest allowed turn of a leg
};

// `measured_cdeg`: reported by the modules; negative when unknown.
GateCheck check(const BusOrders& orders, const BusOrders& before,
                const std::array<std::int32_t, kBusModules>& measured_cdeg,
                const lc::ControllerState& state, const GateLimits& limits, TimeNs now) noexcept;

// Emergency stop to all; serial numbers continue from `orders`.
void make_safe(BusOrders& orders, TimeNs now) noexcept;

}  // namespace lss::zebro
