#pragma once

// Walking on five or four legs by creeping: legs swing while the body rests, and the body rolls
// ahead only while all feet are down. So the centre of mass can be well within three or four feet
// whenever a leg is in the air; where no order of the legs leaves it there, by rowing (rowing.h).
// The legs out of service are believed to hang clear of the ground; one that touches drags. Pure,
// no allocation; a search takes a millisecond.

#include <limits>

#include "gnc/zebro/gait.h"
#include "gnc/zebro/stability.h"

namespace lss::gnc::zebro {

struct LocomotionParameters;
enum class Speed : std::uint8_t;

// No gait with less is walked: legs weigh something, and the ground is not level.
inline constexpr double kLeastMargin_m = 2e-3;
inline constexpr int kMostIsolated = 2;

struct Creep {
  Partition gait;
  std::uint8_t rolls_after = 0;  // bit g: the body rolls ahead when group g has landed
  bool operator==(const Creep&) const = default;
};

// Times, sweep and middle of the sweep with these legs out of service; those of the parameters
// when there are none.
struct Footing {
  GaitTimes times;
  double sweep_rad = 0;
  double offset_rad = 0;
};
Footing footing(LegSet isolated, const LocomotionParameters& parameters) noexcept;

// How far legs roll: each from offset + its half sweep to offset - its half sweep.
struct Roll {
  PerLeg<double> half_sweep_rad{};  // signed, as half_sweep_rad() gives it
  double offset_rad = 0;
  double diameter_m = 0;
};

// Where a leg is when a group lifts off: rolled back by an equal part for each time that the body
// rolled since it landed. A leg of that group itself has rolled all its way.
double creep_rad(const Creep& creep, std::size_t leg, int group, double half_sweep_rad,
                 double offset_rad) noexcept;

// The smallest margin in a whole cycle. Gives up, with a margin that is not above `enough_m`, when
// it finds such a one.
double static_margin_m(const Creep& creep, const Roll& roll, const HipGeometry& hips = {},
                       double enough_m = -std::numeric_limits<double>::infinity()) noexcept;

// The best creep without one or two legs, for these sweeps: high has three groups, medium four,
// low five; when that has not enough margin another number that has. Two legs less leave one leg at
// a time, so all speeds are the same gait. When none has enough margin: the one with the best.
struct StableGait {
  Creep creep;
  double margin_m = 0;
};
StableGait stable_gait(LegSet isolated, Speed speed, const Roll& roll) noexcept;

// Is there a creep with margin enough? Where there is none the legs row (rowing.h), if they can.
bool creeps_without(LegSet isolated, const LocomotionParameters& parameters) noexcept;

}  // namespace lss::gnc::zebro
