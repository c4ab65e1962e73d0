#pragma once

// Pulses of the four lift valves (TALARIS thesis 4.2, figures 18 and 19): their mean length gives
// the lift, "off-pulsing" pitch and yaw: one pair is longer by as much as the other is shorter, so
// that the sum of the on-times, and with it the lift, stays exactly the same.

#include <array>

#include "gnc/talaris/parameters.h"

namespace lss::gnc::talaris {

struct LiftPulses {
  std::array<double, 4> on_s{};  // valves 1, 3, 5, 7
  double mean_s = 0;             // after limiting: lift that is really commanded
  double share = 1;              // realised share of the moments
};

// `lift_N`: of all four, mean over the frame. `moment_y/z_N_m`: mean over the frame. The mean is
// limited to possible pulses; the room above and below it is for the moments. `full`: pulses up to
// the whole frame, for an emergency.
LiftPulses allocate_lift(double lift_N, double moment_y_N_m, double moment_z_N_m,
                         const Thrusters& thrusters, bool full = false) noexcept;

// In the middle of the frame: delay + on + delay = frame.
Pulse centred(double on_s) noexcept;

// The same, but the pause behind the pulse of the frame before is none or at least `pause_s`.
Pulse spaced(double on_s, const Pulse& before, double pause_s) noexcept;

// Remaining part of a pulse of the frame before at T_k, release offset and lag included.
double remaining_s(const Pulse& pulse, double offset_s, double lag_s) noexcept;

// Places of the lift valves (0..3 for 1, 3, 5, 7): sign of y and z.
inline constexpr std::array<int, 4> kLiftY = {-1, -1, 1, 1};
inline constexpr std::array<int, 4> kLiftZ = {-1, 1, 1, -1};
// Side valves (0..3 for 2, 4, 6, 8): sign of y, and of the push along z. Roll moment: y * push.
inline constexpr std::array<int, 4> kSideY = {-1, -1, 1, 1};
inline constexpr std::array<int, 4> kSidePush = {1, -1, -1, 1};

}  // namespace lss::gnc::talaris
