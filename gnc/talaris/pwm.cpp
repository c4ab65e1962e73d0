#include "gnc/talaris/pwm.h"

#include <algorithm>
#include <cmath>

namespace lss::gnc::talaris {
namespace {
constexpr double kSameTime_s = 1e-6;
}

LiftPulses allocate_lift(double lift_N, double moment_y_N_m, double moment_z_N_m,
                         const Thrusters& t, bool full) noexcept {
  const double max_s = full ? t.long_on_s : t.max_on_s;
  LiftPulses out;
  double y = kFrame_s * moment_y_N_m / (4 * t.force_N * t.lift_z_m);
  double z = kFrame_s * moment_z_N_m / (4 * t.force_N * t.lift_y_m);
  double wanted = std::abs(y) + std::abs(z);
  if (!std::isfinite(wanted)) {
    y = z = wanted = 0;
    out.share = 0;
  }
  // at the limits of the valves the lift leaves the moments a little room
  const double kept = std::min(wanted, t.attitude_room_s);
  const double asked = kFrame_s * lift_N / (4 * t.force_N);
  out.mean_s = std::clamp(std::isfinite(asked) ? asked : 0, t.min_on_s + kept, max_s - kept);
  if (const double room = std::min(out.mean_s - t.min_on_s, max_s - out.mean_s); wanted > room) {
    out.share = room / wanted;
    y *= out.share;
    z *= out.share;
  }
  // the pairs cancel; clamped against rounding of the last bit only
  for (std::size_t i = 0; i < 4; ++i) {
    out.on_s[i] = std::clamp(out.mean_s + kLiftZ[i] * y - kLiftY[i] * z, t.min_on_s, max_s);
  }
  return out;
}

Pulse centred(double on_s) noexcept {
  return on_s > 0 ? Pulse{on_s, (kFrame_s - on_s) / 2} : Pulse{};
}

Pulse spaced(double on_s, const Pulse& before, double pause_s) noexcept {
  Pulse pulse = centred(on_s);
  if (!(on_s > 0) || !(before.on_s > 0)) return pulse;
  const double shut_s = std::max(kFrame_s - before.delay_s - before.on_s, 0.0);  // already
  const bool open = shut_s < kSameTime_s;
  if (open ? pulse.delay_s < kSameTime_s : shut_s + pulse.delay_s >= pause_s) return pulse;
  const double earliest_s = open ? pause_s : pause_s - shut_s;
  if (open && on_s + earliest_s > kFrame_s) return {on_s, 0};  // goes on
  pulse.delay_s = earliest_s;
  pulse.on_s = std::min(on_s, kFrame_s - earliest_s);
  return pulse;
}

double remaining_s(const Pulse& pulse, double offset_s, double lag_s) noexcept {
  const double end = offset_s + lag_s + pulse.delay_s + pulse.on_s - kFrame_s;
  return std::clamp(end, 0.0, pulse.on_s);
}

}  // namespace lss::gnc::talaris
