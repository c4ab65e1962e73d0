#pragma once

// A wheel of D.I.A.N.A. Ardito on soil: from its load and motion to how it is held, pulled and
// turned, and how deep it sinks (docs/soil.md). The forces are those of soil/wheel.h at the slip of
// the last step; the solver of contacts applies them as friction that gives way in proportion to
// them, which is implicit: a wheel that stands is held by the strength of the soil and does not
// creep. One state; one thread. One step is 1 ms.

#include "tools/lss-sim/soil/soil.h"
#include "tools/lss-sim/soil/wheel.h"

namespace lss::sim::ardito {

inline constexpr double kWheelWidth_m = 0.10;  // ours

struct WheelMotion {
  double load_N = 0;     // on the ground
  double rim_m_s = 0;    // of the tread against its hub, positive forward
  double ahead_m_s = 0;  // of the hub over the ground, in the wheel's plane
  double left_m_s = 0;   // and across it
};

struct SoilGrip {
  double friction = 0;         // most shear as a share of the load, in any direction
  double compliance_m_sN = 0;  // sliding for each newton of shear
  double resistance_N = 0;     // of the soil in front, ahead; negative on the way forward
  double rolling_Nm = 0;       // against rolling, more than shear times radius
  double turning_Nm = 0;       // against steering in place
  double sinking_m_s = 0;      // of the ground under the wheel
};

class WheelInSoil {
 public:
  // At rest under this load.
  WheelInSoil(const soil::Soil& soil, double load_N);
  SoilGrip step(const WheelMotion& motion);
  // Another one from the next step on: the wheel sinks or comes out as in its own.
  void enter(const soil::Soil& soil) { soil_ = soil; }
  double sinkage_m() const { return sinkage_m_; }

 private:
  double sink(const WheelMotion& motion, double sliding_m_s, const soil::WheelForces& forces);

  soil::Soil soil_;
  double load_N_ = 0;  // smoothed
  double sinkage_m_ = 0;
  double pushed_m_ = 0;  // by the wheel: soil in front, before it yields; positive forward
};

}  // namespace lss::sim::ardito
