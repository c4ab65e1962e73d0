#include "daemon/vehicles/ardito/gate.h"

#include <algorithm>
#include <cmath>

#include "daemon/vehicles/ardito/modes.h"

namespace lss::ardito {
namespace {

bool enabled(const RoverOrders& orders) noexcept {
  const auto on = [](const auto& drive) { return drive.enabled; };
  return std::ranges::any_of(orders.wheel, on) || std::ranges::any_of(orders.steering, on);
}

GateCheck check_wheel(const WheelOrder& order, const WheelOrder& before,
                      const GateLimits& limits) noexcept {
  if (!std::isfinite(order.motor_rpm)) return GateCheck::finite;
  if (std::abs(order.motor_rpm) > limits.motor_rpm) return GateCheck::range;
  const double step = std::abs(order.motor_rpm) - std::abs(before.motor_rpm);
  const bool reverses = order.motor_rpm * before.motor_rpm < 0;
  const double change = reverses ? std::abs(order.motor_rpm) : step;
  return order.enabled && change > limits.motor_rpm_step ? GateCheck::slew : GateCheck::passed;
}

}  // namespace

GateCheck check(const RoverOrders& orders, const RoverOrders& before,
                const lc::ControllerState& state, const GateLimits& limits, TimeNs now) noexcept {
  if (orders.issued_ns != now) return GateCheck::fresh;
  const bool may = state.state == State::operational &&
                   state.mode != static_cast<std::uint8_t>(Mode::warning) && !orders.quick_stop;
  if (enabled(orders) && !may) return GateCheck::state;
  for (std::size_t i = 0; i < orders.wheel.size(); ++i) {
    if (orders.wheel[i].enabled && (state.isolated >> i & 1u) != 0) return GateCheck::state;
    if (const GateCheck failed = check_wheel(orders.wheel[i], before.wheel[i], limits);
        failed != GateCheck::passed)
      return failed;
  }
  for (const SteeringOrder& order : orders.steering) {
    if (!std::isfinite(order.position_rad)) return GateCheck::finite;
    if (std::abs(order.position_rad) > limits.steering_rad) return GateCheck::range;
  }
  return GateCheck::passed;
}

void make_safe(RoverOrders& orders, TimeNs now) noexcept {
  orders.issued_ns = now;
  ++orders.serial;
  ++orders.emergency_serial;
  orders.quick_stop = true;
  orders.wheel.fill({});
  for (SteeringOrder& order : orders.steering) order.enabled = false;
}

}  // namespace lss::ardito
