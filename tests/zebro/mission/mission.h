#pragma once

// A mission of Lunar Zebro: the whole chain of tests/zebro/chain on the kinematic plant, frames of
// 20 ms, with an autopilot as its On-Board Computer, a battery, a panel, a lunar day of 14 days and
// faults at random times. The same options give the same mission, to the bit. Thrown:
// std::runtime_error when the configuration cannot be read.

#include <array>
#include <functional>
#include <string>
#include <vector>

#include "tests/zebro/mission/autopilot.h"
#include "tests/zebro/mission/faults.h"

namespace lss::zebro::mission {

struct Options {
  unsigned seed = 1;
  double fault_mean_h = 2;   // hours of operation between two faults
  bool lying_faults = true;  // also those by which a leg lies
  double day_h = 14 * 24;
  // One leg in the air at a time, 0.94 mm/s: 200 m are some 60 h of walking.
  double flight_s = 7.5;
  Autopilot::Parameters autopilot{};
  // Receives a line for each event; empty: none.
  std::function<void(const std::string&)> tell{};
};

struct Power {
  double capacity_Wh = 20;
  double panel_W = 6;    // deployed, in the Sun
  double awake_W = 1.5;  // OBC and the electronics of the modules; the motors come on top
  double asleep_W = 0.2;
  double motor_V = 12;
};

struct FaultCount {
  int begun = 0;
  int fatal = 0;  // ended in FatalError within ten seconds, of those during Operational
  int operational = 0;
};

struct Result {
  unsigned seed = 1;
  bool arrived = false;
  double course_m = 0;  // by dead reckoning of the autopilot
  double true_m = 0, aside_m = 0;
  double elapsed_h = 0, walked_h = 0, rested_h = 0;
  double least_charge = 1;
  Autopilot::Count count;
  std::array<FaultCount, kFaultShapes.size()> faults{};
  int emergencies = 0;  // times in FatalError
  int isolations = 0;
  std::vector<std::string> violations;  // of the conditions of every frame
  double wall_s = 0;

  int fault_total() const;
};

Result run(const Options& options);

}  // namespace lss::zebro::mission
