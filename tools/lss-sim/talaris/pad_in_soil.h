#pragma once

// A footpad of TALARIS on soil (docs/soil.md): a leg, spring and damper, in series with ground that
// gives way for good. Into the surface it gives way at Bekker's pressure on the pad's area, along
// it at the strength of Mohr and Coulomb, which grows with the way slid (Janosi and Hanamoto). Only
// the leg springs back. Each step finds how far the pad gives way in it, by bisection, so that leg
// and soil have the same force at its end: implicit, and not stiffer than the leg alone. One state;
// one thread. One step is kStep_s.

#include <optional>

#include "tools/lss-sim/soil/soil.h"
#include "tools/lss-sim/talaris/plant.h"

namespace lss::sim::talaris {

inline constexpr double kPadRadius_m = 0.05;  // ours

struct Leg {
  double spring_N_m = 0, damper_Ns_m = 0;  // along and across
};

// Where the pad would be if the leg had no load.
struct LegEnd {
  double into_m = 0;  // below the untouched surface
  Vector3 at_m = Vector3::Zero(), velocity_m_s = Vector3::Zero();
};

class PadInSoil {
 public:
  // A pad on untouched ground with this normal. `soil` is in the gravity of the place.
  PadInSoil(const soil::Soil& soil, const Leg& leg, const Vector3& normal);
  // Depth at which this load rests.
  double carries_at_m(double load_N) const;
  // At rest, its leg's end so far below the surface.
  void press(double depth_m, double into_m) {
    depth_m_ = depth_m;
    bent_m_ = into_m - depth_m;
  }

  // On the leg, world. Above the surface the pad comes to untouched ground again.
  Vector3 step(const LegEnd& end);
  double depth_m() const { return depth_m_; }
  double leg_J(const LegEnd& end) const;  // energy in the spring

 private:
  double carries_N(double depth_m) const;
  double holds_N(double load_N, double sheared_m) const;
  Vector3 along(const Vector3& vector) const { return vector - normal_.dot(vector) * normal_; }

  soil::Soil soil_;
  Leg leg_;
  Vector3 normal_;
  double depth_m_ = 0;            // of the hole
  double bent_m_ = 0;             // compression of the leg
  double sheared_m_ = 0;          // way slid in it
  std::optional<Vector3> pad_m_;  // where the pad stands along the surface, under load
};

}  // namespace lss::sim::talaris
