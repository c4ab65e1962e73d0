#pragma once

// Walking by rowing, for sets of legs without a creep: all legs together push the body up and ahead
// over their feet and lower it on its belly, which carries while they swing. So the missing foot
// does not matter, and only all feet together need a margin. One group of the max-plus gaits, in
// which everything waits for everything: Locomotion walks it as its stages lift, push and sink,
// each of which ends when all legs have arrived. Pure, no allocation.

#include "gnc/zebro/gait.h"
#include "gnc/zebro/stability.h"

namespace lss::gnc::zebro {

struct LocomotionParameters;

// Angles at which a stroke begins and ends, the toe ahead (positive) or behind (negative).
struct StrokeEnds {
  double ahead_rad = 0;   // off the ground, where legs wait
  double behind_rad = 0;  // off the ground
  // On the ground. The legs lower the body on their toes as far as they have a margin; the swing
  // lowers it completely.
  double toe_rad = 0;
};
StrokeEnds stroke_ends(const LocomotionParameters& parameters) noexcept;

// Stroke of a side. A foot on the ground rolls until the belly carries again, ahead of its start or
// back there: so it is a whole stroke or none, in which the legs push the body up and lower it
// again.
enum class Stroke : std::int8_t { back = -1, none = 0, ahead = 1 };
inline double begin_rad(Stroke stroke, const StrokeEnds& ends) noexcept {
  return stroke == Stroke::back ? ends.behind_rad : ends.ahead_rad;
}
inline double end_rad(Stroke stroke, const StrokeEnds& ends) noexcept {
  return stroke == Stroke::ahead ? ends.toe_rad : ends.ahead_rad;
}

// The stroke nearest to the requested and not yet rowed way of a side, in strokes; it is subtracted
// from it.
Stroke next_stroke(double& owed) noexcept;

// The smallest margin of the feet of all other legs, over all strokes of the two sides, while the
// legs carry: at both ends and straight down; other positions are in between.
double rowing_margin_m(LegSet isolated, const LocomotionParameters& parameters) noexcept;

}  // namespace lss::gnc::zebro
