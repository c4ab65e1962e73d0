#pragma once

// The gate of D.I.A.N.A. Ardito: all orders to the drives pass it on their way out. An order that
// is no number, out of range, too fast, stale or not allowed in the state replaces all orders by
// the safe command, the quick stop of every drive. Pure functions; frame thread and tests.

#include <cstdint>

#include "daemon/cycle/controller.h"
#include "drivers/ardito/rover_bus.h"

namespace lss::ardito {

enum class GateCheck : std::uint8_t {
  passed,
  finite,
  range,  // a speed or an angle that the vehicle never needs
  slew,   // a wheel changes its speed faster than allowed
  fresh,  // not computed in this frame
  state,  // a drive enabled where none may be
};

struct GateLimits {
  double motor_rpm = 0;       // fastest
  double motor_rpm_step = 0;  // largest change in a frame; slowing down is not limited
  double steering_rad = 0;    // largest angle
};

GateCheck check(const RoverOrders& orders, const RoverOrders& before,
                const lc::ControllerState& state, const GateLimits& limits, TimeNs now) noexcept;

// Quick stop of all drives; serial numbers continue from `orders`, clutches and beacon stay:
// engaged clutches keep a rover on a slope from rolling.
void make_safe(RoverOrders& orders, TimeNs now) noexcept;

}  // namespace lss::ardito
