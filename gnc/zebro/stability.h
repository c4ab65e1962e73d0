#pragma once

// Static stability on level ground: distance of the robot's centre of mass from the edge of its
// feet. Pure, no allocation.

#include "gnc/zebro/gait.h"

namespace lss::gnc::zebro {

// Hips from the centre of mass; defaults as Lunar Zebro's 200 x 130 mm body, middle legs further
// out.
struct HipGeometry {
  PerLeg<double> x_m = {0.080, 0.080, 0.0, 0.0, -0.080, -0.080};
  PerLeg<double> y_m = {0.065, -0.065, 0.080, -0.080, 0.065, -0.065};
};

// Distance from the centre of mass to the nearest edge of the polygon of contact points; negative
// outside it, at most 0 with two legs, -infinity with fewer.
double static_margin_m(const PerLeg<bool>& in_stance, const PerLeg<double>& theta_rad,
                       double diameter_m, const HipGeometry& hips = {}) noexcept;

}  // namespace lss::gnc::zebro
