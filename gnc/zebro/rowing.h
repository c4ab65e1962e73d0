#pragma once

// Walking by rowing, for sets of legs without a creep: all legs together push the body up and ahead
// over their feet and let it down on its belly, which carries while they swing. So no foot is ever
// missed, and all that is asked is that all feet together have a margin. One group of the max-plus
// gaits, in which everything waits for everything: Locomotion walks it as its stages lift, push and
// sink, each of which ends when all legs have arrived. Pure, no allocation.

#include "gnc/zebro/gait.h"
#include "gnc/zebro/stability.h"

namespace lss::gnc::zebro {

struct LocomotionParameters;

// Angles at which a stroke begins and ends, the toe ahead (positive) or behind (negative).
struct StrokeEnds {
  double ahead_rad = 0;   // off the ground, where legs rest
  double behind_rad = 0;  // off the ground
  // On the ground. The legs let the body down on their toes as far as they have a margin, the swing
  // lets it down the rest.
  double toe_rad = 0;
};
StrokeEnds stroke_ends(const LocomotionParameters& parameters) noexcept;

// What a side does in one stroke. A foot on the ground rolls until the belly carries again, ahead
// of where it began or back there: so it is a whole stroke or none, in which the legs push the body
// up and let it down again.
enum class Stroke : std::int8_t { back = -1, none = 0, ahead = 1 };
inline double begin_rad(Stroke stroke, const StrokeEnds& ends) noexcept {
  return stroke == Stroke::back ? ends.behind_rad : ends.ahead_rad;
}
inline double end_rad(Stroke stroke, const StrokeEnds& ends) noexcept {
  return stroke == Stroke::ahead ? ends.toe_rad : ends.ahead_rad;
}

// The stroke that comes nearest to what a side was asked for so far and has not gone, in strokes;
// it is taken from it.
Stroke next_stroke(double& owed) noexcept;

// The smallest margin of the feet of all other legs, of all strokes of the two sides, while the
// legs carry: at both ends and straight down, between which the feet are in between.
double rowing_margin_m(LegSet isolated, const LocomotionParameters& parameters,
                       const HipGeometry& hips = {}) noexcept;

}  // namespace lss::gnc::zebro
