#pragma once

// The air around TALARIS: wind with gusts, drag, and the ram drag of the fans, which take in air at
// rest and blow it out with the vehicle's speed (TALARIS thesis 2.3.2 names both). Frames as in
// plant.h. Used by one thread (physics). One step is 1 ms.

#include <random>

#include "tools/lss-sim/talaris/plant.h"

namespace lss::sim::talaris {

struct AirOptions {
  double density_kg_m3 = 0;                // 0: no air; 1.2 at sea level
  Vector3 drag_area_m2{0.90, 0.45, 0.35};  // drag coefficient times area along x, y, z (ours)
  double fan_flow_kg_s = 4.0;              // through all four at 29,400 rpm: 368 N at 92 m/s (ours)
  double centre_m = 0.05;                  // where sideways air acts, above the origin (ours)
  double wind_m_s = 0;                     // steady
  double gust_m_s = 0;                     // most that a gust adds to it
  // The same as forces on the centre of mass; they do not depend on its motion.
  double push_N = 0;
  double gust_N = 0;
  double to_rad = 0;  // blows towards +z turned by this angle towards +y
};

class Air {
 public:
  Air(const AirOptions& options, unsigned seed);

  // A millisecond. `rpm`: sum of the fans'. Force and torque of the air on the body, in B.
  Wrench step(const BodyState& body, double rpm);
  // World: force on the centre of mass that does not depend on the vehicle.
  Vector3 push_N() const { return (options_.push_N + gust_ * options_.gust_N) * along_; }
  Vector3 wind_m_s() const { return (options_.wind_m_s + gust_ * options_.gust_m_s) * along_; }

 private:
  void blow();

  AirOptions options_;
  std::mt19937 random_;
  Vector3 steady_along_ = Vector3::UnitZ(), along_ = Vector3::UnitZ();
  double gust_ = 0;  // 0..1, of this moment
  // The gust under way, one minus cosine over its length; or the calm before the next.
  int gust_ms_ = 0, length_ms_ = 0, calm_ms_ = 0;
  double size_ = 0;
};

}  // namespace lss::sim::talaris
