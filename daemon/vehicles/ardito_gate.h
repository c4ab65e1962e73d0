#pragma once

// The gate of D.I.A.N.A. Ardito: the one place where orders to the drives pass on their way out. An
// order that is no number, out of range, too fast, stale or not allowed in the state turns all
// orders into the safe command, the quick stop of every drive. Pure functions; frame thread and
// tests.

#include <cstdint>

#include "daemon/lc/controller.h"
#include "drivers/ardito/rover_bus.h"

namespace lss::ardito {

enum class GateCheck : std::uint8_t {
  passed,
  finite,
  range,  // a speed or an angle that the vehicle never needs
  slew,   // a wheel shall change its speed faster than it may
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

// Quick stop of all drives; `orders` gives the serial numbers to go on from, clutches and beacon
// stay as they are: a rover on a slope is held through engaged clutches.
void make_safe(RoverOrders& orders, TimeNs now) noexcept;

}  // namespace lss::ardito
