#pragma once

// A rigid wheel on soil: M. G. Bekker's pressure, distributed along the rim as J. Y. Wong and A. R.
// Reece measured it ("Prediction of rigid wheel performance based on the analysis of soil-wheel
// stresses", Journal of Terramechanics 4, 1967), with the shear of Z. Janosi and B. Hanamoto. Pure
// functions; any thread.

#include "tools/lss-sim/soil/soil.h"

namespace lss::sim::soil {

struct Wheel {
  double radius_m = 0, width_m = 0;
};

struct WheelForces {
  double load_N = 0;        // carried
  double thrust_N = 0;      // of shear along the rim, ahead
  double resistance_N = 0;  // of the soil that is pressed down in front, back
  double torque_Nm = 0;     // that the axle must give
  double pull_N() const { return thrust_N - resistance_N; }  // drawbar pull
};

// At this depth under the untouched surface and this slip: 1 - way / rolled way, -1 to 1; negative
// when the wheel brakes.
WheelForces on_soil(const Soil& soil, const Wheel& wheel, double sinkage_m, double slip);

// The depth at which the wheel carries this load, by bisection; at most its radius.
double sinkage_m(const Soil& soil, const Wheel& wheel, double load_N, double slip);

}  // namespace lss::sim::soil
