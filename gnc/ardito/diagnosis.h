#pragma once

// From disagreeing sensors to a failure: the decision table of one wheel and of one steering system
// (Ardito thesis 17.2, 17.4; made consistent: E14 to E18, E21, E24, table in docs/gnc-ardito.md).
// Pure functions of one frame, callable from every thread.

#include <algorithm>

#include "gnc/ardito/parameters.h"

namespace lss::gnc::ardito {

// Orders of the last frames: drives follow with a delay, so any value between is accepted.
struct Ordered {
  double low = 0;
  double high = 0;
};
// Distance from this range to the value, 0 inside.
inline double distance(const Ordered& ordered, double value) noexcept {
  return std::max(std::max(ordered.low - value, value - ordered.high), 0.0);
}

// A value that is not usable disagrees with all others.
struct Sensor {
  double value = 0;
  bool usable = false;
};

struct WheelSensors {
  Sensor motor;
  Sensor hall;
  Sensor reduction;
};

// Bits of Command::sensors_lost, and other parts that a wheel can lose.
enum Part : std::uint32_t {
  kMotorEncoder = 1U << 0,
  kHall = 1U << 1,
  kReductionEncoder = 1U << 2,
  kMotor = 1U << 3,
  kReduction = 1U << 4,
  kClutch = 1U << 5,
  kSensors = kMotorEncoder | kHall | kReductionEncoder,
};

// Speeds agree within 2 rpm or 20 % of the larger one, whichever is more (E21, E24).
bool agree(double a_rad_s, double b_rad_s, const Parameters& parameters) noexcept;

// Six flags as the thesis writes them, 0b110001 = 110001: C-M, C-H, H-M, M-R, R-H, C-R disagree.
inline constexpr unsigned kAllAgree = 0b000000;
inline constexpr unsigned kAllDiffer = 0b111111;
unsigned wheel_flags(const Ordered& ordered, const WheelSensors& sensors,
                     const Parameters& parameters) noexcept;

enum class Outcome : std::uint32_t {
  failure,       // or none: named by `failure` and `parts`
  hold,          // normal for a wheel with an open clutch; keep the diagnosis
  inconclusive,  // agreement is not transitive here; keep the diagnosis, and count
};
struct WheelVerdict {
  Outcome outcome = Outcome::failure;
  WheelFailure failure = WheelFailure::none;
  std::uint32_t parts = 0;  // Part bits
};

// rho: |reduction encoder|, rad/s, 0 when it is not usable. nearest: smallest distance of a sensor
// to the orders, used when all differ. One outcome for each of the 64 patterns.
WheelVerdict diagnose_wheel(unsigned flags, bool clutch_engaged, double rho_rad_s,
                            double nearest_rad_s, const Parameters& parameters) noexcept;

// The number of these lost parts, the worst first (E19: sensors that were lost permanently and a
// motor or gear that fails are state 8 only when no sensor is left).
WheelFailure failure_of_any(std::uint32_t parts) noexcept;
inline WheelFailure failure_of(std::uint32_t parts) noexcept {
  return parts == 0 ? WheelFailure::none : failure_of_any(parts);
}

// 0b110: C-M, M-R, C-R disagree.
unsigned steering_flags(const Ordered& ordered, const Sensor& motor, const Sensor& reduction,
                        const Parameters& parameters) noexcept;
struct SteeringVerdict {
  Outcome outcome = Outcome::failure;
  SteeringFailure failure = SteeringFailure::none;
};
SteeringVerdict diagnose_steering(unsigned flags) noexcept;
// Faster than by angles: how far both encoders moved in this frame, while the gear was ordered to
// turn by `ordered_rad`. The one that stands while the other turns is lost.
SteeringFailure standing_encoder(double motor_rad, double reduction_rad, double ordered_rad,
                                 const Parameters& parameters) noexcept;

}  // namespace lss::gnc::ardito
