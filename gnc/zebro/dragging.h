#pragma once

// How the body moves on six legs of which some are dead: in the air, or on the ground, where they
// prop it up and drag. Static, without inertia: the body lies on the three legs, or edges of its
// belly, that carry its weight, and moves with the least friction as these roll on the ground. Used
// by dead reckoning only; angles of roll and pitch are small. Pure, no allocation; a call takes
// some microseconds.

#include "gnc/zebro/gait.h"
#include "gnc/zebro/stability.h"

namespace lss::gnc::zebro {

struct BodyShape {
  HipGeometry hips;
  double leg_diameter_m = 0;
  double belly_height_m = 0;  // hip above the underside
};

// Movement of the centre of mass in a frame, along the body; yaw clockwise positive.
struct Moved {
  double ahead_m = 0;
  double yaw_rad = 0;
};

class Dragging {
 public:
  // The legs turned from one set of angles to the other in this time. Angles as theta.
  Moved step(const BodyShape& body, const PerLeg<double>& from_rad, const PerLeg<double>& to_rad,
             double elapsed_s) noexcept;
  void reset() noexcept { known_ = false; }

 private:
  double pitch_ = 0;  // slope of the ground ahead, in the body's frame
  bool known_ = false;
};

}  // namespace lss::gnc::zebro
