#include "daemon/vehicles/talaris/gate.h"

#include <algorithm>

#include "daemon/vehicles/talaris/modes.h"
#include "daemon/vehicles/talaris/script.h"

namespace lss::talaris {
namespace {

constexpr TimeNs kShortest = static_cast<TimeNs>(kMinPulse_s * 1e3) * kMillisecond;
constexpr TimeNs kRounding = kMicrosecond;  // of a pulse in seconds
constexpr TimeNs kLongestHold = static_cast<TimeNs>(kMaxManual_s) * kSecond;

bool fits(const ValvePulse& p) noexcept {
  if (p.on_ns == 0) return p.delay_ns >= 0 && p.delay_ns <= kFrame;
  if (p.delay_ns < 0 || p.on_ns < 0 || p.delay_ns > kFrame || p.on_ns > kFrame) return false;
  const TimeNs end = p.delay_ns + p.on_ns;
  return end == kFrame || (end < kFrame && p.on_ns >= kShortest);  // a pulse to the end goes on
}

GateCheck check_valve(const TalarisOrders& o, const TalarisOrders& before, std::size_t i, Mode mode,
                      std::uint8_t enabled) noexcept {
  if (!fits(o.pulse[i])) return GateCheck::pulse;
  if (!pauses(o, before, i)) return GateCheck::pause;
  if (o.hold[i].open) {
    const bool by_hand = mode == Mode::manual || mode == Mode::script;
    if (!by_hand || o.hold[i].until_ns <= o.release_ns ||
        o.hold[i].until_ns > o.release_ns + kLongestHold)
      return GateCheck::hold;
  }
  const bool fires = o.pulse[i].on_ns != 0 || o.hold[i].open;
  return fires && (enabled & 1u << i) == 0 ? GateCheck::disabled : GateCheck::passed;
}

}  // namespace

bool pauses(const TalarisOrders& orders, const TalarisOrders& before, std::size_t valve) noexcept {
  const ValvePulse &last = before.pulse[valve], &next = orders.pulse[valve];
  if (last.on_ns == 0 || next.on_ns == 0) return true;
  // Frames of a sensor are not to the nanosecond.
  const TimeNs apart_ns = orders.boundary_ns - before.boundary_ns;
  const TimeNs frames = (apart_ns + kFrame / 2) / kFrame;
  const TimeNs shut_ns = frames * kFrame + next.delay_ns - last.delay_ns - last.on_ns;
  return shut_ns <= 0 || shut_ns >= kShortest - kRounding;
}

bool active(const TalarisOrders& orders) noexcept {
  return std::ranges::any_of(orders.pulse, [](const auto& p) { return p.on_ns != 0; }) ||
         std::ranges::any_of(orders.hold, [](const auto& h) { return h.open; }) ||
         std::ranges::any_of(orders.fan_us, [](std::uint16_t us) { return us != kFanOff_us; });
}

GateCheck check(const TalarisOrders& orders, const TalarisOrders& before,
                const lc::ControllerState& state, const GateLimits& limits, TimeNs now) noexcept {
  if (orders.issued_ns != now || orders.boundary_ns != now ||
      orders.release_ns != now + limits.offset_ns)
    return GateCheck::fresh;
  const auto mode = static_cast<Mode>(state.mode);
  const bool still = mode == Mode::standby || mode == Mode::calibrate;
  if (active(orders) && (state.state != State::operational || still || orders.all_stop))
    return GateCheck::state;
  for (std::size_t i = 0; i < orders.pulse.size(); ++i) {
    const auto enabled = static_cast<std::uint8_t>(limits.enabled & orders.enabled);
    if (const GateCheck failed = check_valve(orders, before, i, mode, enabled);
        failed != GateCheck::passed)
      return failed;
  }
  for (std::size_t i = 0; i < orders.fan_us.size(); ++i) {
    const int us = orders.fan_us[i];
    if (us < kFanOff_us || us > kFanFull_us) return GateCheck::range;
    if (!limits.arming && us - before.fan_us[i] > limits.fan_step_us) return GateCheck::slew;
  }
  return GateCheck::passed;
}

void make_safe(TalarisOrders& orders) noexcept {
  const TalarisOrders safe;
  orders.pulse = safe.pulse;
  orders.hold = safe.hold;
  orders.fan_us = safe.fan_us;
}

}  // namespace lss::talaris
