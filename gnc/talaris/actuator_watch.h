#pragma once

// Which valve or fan failed, in flight: the measured acceleration of a frame against that of the
// orders. For each failure the force and moment by which it would differ is known (its signature);
// the logarithm of the likelihood ratio of "this failed" to "nothing did" is summed up from frame
// to frame and never below zero (Page's cumulative sum, generalised likelihood ratio: Basseville
// and Nikiforov, "Detection of Abrupt Changes", 1993; Willsky and Jones, 1976). A fan that does not
// turn is seen by its speed. Verdicts are latched, except that a valve found open may be found shut
// later, and the reverse. docs/gnc-talaris.md, "Failed actuators". Frame thread; time is data; no
// allocation.
//
//   z = (m f_B along x and z, I dw/T + w x I w)          measured wrench
//   e = z - B u - d                                      u: orders, d: always unexplained
//   s = B_i F (1 - open/T), -B_i F open/T, -B_i k rpm^2  open, shut, fan without thrust
//   q = e'S^-1 s / s'S^-1 s,  p = min(max(q, 0.3), 1)    p: part of the first frame; shut: 1
//   g <- max(0, g + s'S^-1 s p (q - p/2))                S: variances
//
// d (centre of mass, wind, mass) learns 10 % of e a frame; after a failure 30 %, less while much is
// ordered: then e is rather a wrong inertia.

#include "gnc/talaris/allocation.h"
#include "gnc/talaris/parameters.h"
#include "gnc/talaris/types.h"

namespace lss::gnc::talaris {

// The frame that just ended.
struct WatchFrame {
  bool measured = false;  // by the IMU, at both of its ends, off the ground
  bool fresh = false;     // just off the ground: learns what turns it, judges nothing
  bool speeds = false;    // rpm is of now
  bool unheard = false;   // the orders may not have been followed: judges nothing for a while
  Vector3 rate_B_rad_s = Vector3::Zero(), rate_before_B_rad_s = Vector3::Zero();
  Vector3 force_B_m_s2 = Vector3::Zero();  // mean specific force
  double mass_kg = 45;
  std::array<double, kValves> open_s{};  // by the pulses, lags included
  PerFan rpm{}, rpm_before{}, rpm_expected{};
};

struct ActuatorVerdict {
  std::size_t actuator = 0;  // 0..11
  Health health = Health::good;
  double measured = 0, limit = 0;  // N of a valve or a weak fan; rpm of a dead one
};

class ActuatorWatch {
 public:
  explicit ActuatorWatch(const Parameters& parameters) noexcept;

  void begin() noexcept;  // a flight
  void step(const WatchFrame& frame) noexcept;

  const Healths& health() const noexcept { return health_; }
  bool good() const noexcept { return all_good(health_); }
  // Of the frame; health good: nothing new.
  const ActuatorVerdict& verdict() const noexcept { return verdict_; }
  // Force and moment that orders and known failures do not explain.
  const WrenchB& unexplained() const noexcept { return unexplained_; }
  // Thrust that the fans give in the frame, by their speeds and what is known of them.
  PerFan usable(const PerFan& rpm) const noexcept;
  double score() const noexcept { return score_; }  // the largest, of `limit()`
  static double limit() noexcept;

 private:
  struct Suspicion {
    double open = 0, shut = 0, weak = 0;
  };

  WrenchB explained(const WatchFrame& frame) const noexcept;
  WrenchB variance(const WatchFrame& frame, const WrenchB& explained) const noexcept;
  bool watch_speeds(const WatchFrame& frame) noexcept;
  void judge(const WatchFrame& frame, const WrenchB& odd, const WrenchB& variance) noexcept;
  void condemn(std::size_t actuator, Health health, double measured, double limit) noexcept;

  Parameters parameters_;
  Effect effect_;
  Healths health_{};
  ActuatorVerdict verdict_;
  WrenchB unexplained_ = WrenchB::Zero();
  std::array<Suspicion, kActuators> suspicion_{};
  double score_ = 0;
  int blind_frames_ = 0;  // after a verdict
};

}  // namespace lss::gnc::talaris
