#include "daemon/vehicles/zebro/gate.h"

#include "daemon/vehicles/zebro/modes.h"

namespace lss::zebro {
namespace {

using Kind = ModuleOrder::Kind;

constexpr TimeNs kLongestMove = 65'535 * kMillisecond;  // maximum of the delta time
constexpr std::int32_t kTurn = 36'000;
constexpr std::int32_t kOvershoot = 500;  // the module goes back this far instead of a full turn

bool moves(Kind kind) noexcept {
  return kind == Kind::rotate_forward || kind == Kind::rotate_backward;
}

bool allowed(std::size_t module, Kind kind, const lc::ControllerState& s) noexcept {
  switch (kind) {
    case Kind::none:
    case Kind::motion_off:
    case Kind::emergency_stop: return true;
    case Kind::reset: return s.state != State::operational;
    case Kind::motion_on:
    case Kind::rotate_forward:
    case Kind::rotate_backward: break;
  }
  const bool panel = module + 1 == kModules;
  if ((s.isolated >> module & 1u) != 0) {  // moved by direct command only
    return !panel && s.state == State::operational && static_cast<Mode>(s.mode) == Mode::bridge;
  }
  if (!panel && s.state == State::solve_errors) return (s.flags & kFreeing) != 0;
  return panel ? s.state == State::idle && (s.flags & kPanelMoving) != 0
               : s.state == State::operational;
}

// Angle to go in the ordered sense, 0.01 deg.
std::int32_t way(const ModuleOrder& order, std::int32_t from_cdeg) noexcept {
  const std::int32_t forward = ((order.position_cdeg - from_cdeg) % kTurn + kTurn) % kTurn;
  const std::int32_t in_sense =
      order.kind == Kind::rotate_forward ? forward : (kTurn - forward) % kTurn;
  return in_sense > kTurn - kOvershoot ? kTurn - in_sense : in_sense;
}

GateCheck check_move(const ModuleOrder& order, std::int32_t measured_cdeg, const GateLimits& limits,
                     TimeNs now) noexcept {
  if (order.position_cdeg >= kTurn || order.arrive_ns <= now ||
      order.arrive_ns - now > kLongestMove)
    return GateCheck::range;
  if (measured_cdeg < 0) return GateCheck::passed;
  const double rate =
      way(order, measured_cdeg) * 0.01 / (static_cast<double>(order.arrive_ns - now) * 1e-9);
  return rate > limits.turn_rate_deg_s ? GateCheck::slew : GateCheck::passed;
}

}  // namespace

GateCheck check(const BusOrders& orders, const BusOrders& before,
                const std::array<std::int32_t, kBusModules>& measured_cdeg,
                const lc::ControllerState& state, const GateLimits& limits, TimeNs now) noexcept {
  if (orders.issued_ns != now) return GateCheck::fresh;
  int driven = 0, isolated = 0;
  for (std::size_t i = 0; i < orders.module.size(); ++i) {
    const Kind kind = orders.module[i].kind;
    if (!moves(kind) && kind != Kind::motion_on) continue;
    ++driven;
    isolated += (state.isolated >> i & 1u) != 0 ? 1 : 0;
  }
  if (state.state == State::solve_errors && driven > 1) return GateCheck::state;
  if (isolated > 1) return GateCheck::state;
  for (std::size_t i = 0; i < orders.module.size(); ++i) {
    const ModuleOrder& order = orders.module[i];
    if (!allowed(i, order.kind, state)) return GateCheck::state;
    if (!moves(order.kind) || order.serial == before.module[i].serial)
      continue;  // checked when it was new
    if (const GateCheck failed = check_move(order, measured_cdeg[i], limits, now);
        failed != GateCheck::passed)
      return failed;
  }
  return GateCheck::passed;
}

void make_safe(BusOrders& orders, TimeNs now) noexcept {
  orders.issued_ns = now;
  ++orders.emergency_serial;
  for (ModuleOrder& order : orders.module) {
    order = {.kind = Kind::emergency_stop,
             .position_cdeg = 0,
             .arrive_ns = 0,
             .serial = order.serial + 1};
  }
}

}  // namespace lss::zebro
