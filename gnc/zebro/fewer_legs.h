#pragma once

// Walking on five or four legs by creeping: legs swing while the body stands still, and the body
// rolls ahead only while all feet are down. So the centre of mass can be well within three or four
// feet whenever a leg is in the air; where no order of the legs allows that, by rowing (rowing.h).
// Legs out of service are assumed to be clear of the ground; one that touches drags. Pure, no
// allocation; a search takes a millisecond.

#include <limits>

#include "gnc/zebro/gait.h"
#include "gnc/zebro/stability.h"

namespace lss::gnc::zebro {

struct LocomotionParameters;
enum class Speed : std::uint8_t;

// Minimum margin of a gait: legs weigh something, and the ground is not level.
inline constexpr double kLeastMargin_m = 2e-3;
inline constexpr int kMostIsolated = 2;

struct Creep {
  Partition gait;
  std::uint8_t rolls_after = 0;  // bit g: the body rolls ahead when group g has landed
  bool operator==(const Creep&) const = default;
};

// Times, sweep and middle of the sweep with these legs out of service; those of the parameters
// without any.
struct Footing {
  GaitTimes times;
  double sweep_rad = 0;
  double offset_rad = 0;
};
Footing footing(LegSet isolated, const LocomotionParameters& parameters) noexcept;

// Roll of the legs: each from offset + its half sweep to offset - its half sweep.
struct Roll {
  PerLeg<double> half_sweep_rad{};  // signed, as half_sweep_rad() gives it
  double offset_rad = 0;
  double diameter_m = 0;
  HipGeometry hips{};
};

// Angle of a leg when a group lifts off: rolled back by an equal part for each time that the body
// rolled since it landed. A leg of that group itself has rolled all its way.
double creep_rad(const Creep& creep, std::size_t leg, int group, double half_sweep_rad,
                 double offset_rad) noexcept;

// The smallest margin in a whole cycle. Stops at the first margin that is not above `enough_m` and
// returns it.
double static_margin_m(const Creep& creep, const Roll& roll,
                       double enough_m = -std::numeric_limits<double>::infinity()) noexcept;

// The best creep without one or two legs, for these sweeps: high has three groups, medium four, low
// five; when that has not enough margin another number that has. Without two legs one leg moves at
// a time, so all speeds are the same gait. When none has enough margin: the one with the best.
struct StableGait {
  Creep creep;
  double margin_m = 0;
};
StableGait stable_gait(LegSet isolated, Speed speed, const Roll& roll) noexcept;

// Is there a creep with enough margin? Where there is none the legs row (rowing.h), if possible.
bool creeps_without(LegSet isolated, const LocomotionParameters& parameters) noexcept;

}  // namespace lss::gnc::zebro
