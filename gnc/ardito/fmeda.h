#pragma once

// FMEDA of wheels and steering systems: counting, latching, opening clutches, stopping motors
// (Ardito thesis 18.1, with E19, E20). Latched failures stay until retried; an isolated wheel stays
// isolated. Called by the controller once a frame, wheel by wheel.

#include "gnc/ardito/estimate.h"

namespace lss::gnc::ardito {

// Findings of this frame about a wheel, before counting.
struct WheelLook {
  WheelVerdict verdict;
  std::uint32_t fresh_parts = 0;  // of the verdict, not lost before
};
WheelLook look_at_wheel(const WheelInputs& inputs, const WheelHealth& health,
                        const Parameters& parameters) noexcept;

struct WheelEvidence {
  bool counts = true;            // drives have power and received the last command
  bool incoherent = false;       // against the rover
  bool imu_contradicts = false;  // the reduction encoder's speed, when the clutch is in question
  bool rover_drives = false;     // running or parking: a probe is allowed
  bool others_loaded = false;    // the other motors work
  bool other_probe = false;      // one at a time
};
// Counts, latches, decides the service of the wheel. Returns the suspected failure of this frame.
WheelFailure update_wheel(WheelHealth& health, const WheelLook& look, const WheelInputs& inputs,
                          const WheelEvidence& evidence, const Parameters& parameters) noexcept;

SteeringFailure update_steering(SteeringHealth& health, const SteeringInputs& inputs, bool counts,
                                const Parameters& parameters) noexcept;
SteeringFailure failure_of(const SteeringHealth& health) noexcept;

// Clutch test (part VII).
// Parts found to have failed in this frame.
std::uint32_t test_clutch(WheelHealth& health, const WheelInputs& inputs,
                          const WheelEvidence& evidence, const Parameters& parameters) noexcept;
// Speed of a wheel while its clutch is tested.
double probe_speed_rad_s(double ordered_rad_s, const Parameters& parameters) noexcept;

}  // namespace lss::gnc::ardito
