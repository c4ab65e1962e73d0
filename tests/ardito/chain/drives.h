#pragma once

// Drives of the whole chain in physics that break nothing: what is suspected all the same, and how
// far wheels slip.

#include <string>
#include <vector>

#include "tools/lss-sim/ardito/rover.h"

namespace lss::ardito {

// Long driving, at 0.5 m/s with changing headings, a stop and a turn on the spot each minute.
struct Healthy {
  double minutes = 0;  // in Operational
  double metres = 0;   // of the rover's true way
  unsigned long frames = 0;
  unsigned long suspect_frames = 0;     // any wheel or steering system looks wrong in this frame
  unsigned long probe_frames = 0;       // any clutch under test
  unsigned long slip_frames = 0;        // wheels and IMU disagree as in 17.8.3: reported, no alarm
  unsigned long slowed_frames = 0;      // slower than commanded, by slip
  unsigned long slowed_wrong = 0;       // of them: truly its treads lose less than a quarter
  double lost_m_s = 0, treads_m_s = 0;  // true, of all treads, over about a second
  unsigned stuck = 0;  // stopped as stuck, and truly at less than half the speed of the wheels
  bool is_stuck = false;
  std::vector<std::string> alarms;  // when and what

  void add(const Healthy& other);
};
// After a false alarm it starts again on the next seed's ground.
Healthy drive_healthy(const sim::ardito::RoverOptions& rover, double minutes, unsigned seed);

struct Slip {
  double tread_rms_m_s = 0;  // of all wheels on the ground, along the wheel, while it drives
  double worst_rms_m_s = 0;  // of the worst wheel
  double way_m = 0;          // true
  double reckoned_m = 0;     // by the daemon, from its start to its end
  double yaw_rad = 0, reckoned_yaw_rad = 0;  // clockwise
  bool arrived = false;                      // without a fault
};
// Left wheels climb a step of 60 mm; `sign` as correction_sign in the configuration, 0: off.
Slip climb(int sign, unsigned seed);
// 30 s straight ahead over ground of this type; `sign` as above.
Slip cross(sim::ardito::Ground ground, double speed_m_s, int sign, unsigned seed);
// +3 deg, then -3 deg, 4 s each, at 0.5 m/s.
Slip drive_s(unsigned seed);
// On the spot to the right at 0.5 m/s of the corner wheels, 10 s.
Slip turn_on_the_spot(unsigned seed);

}  // namespace lss::ardito
