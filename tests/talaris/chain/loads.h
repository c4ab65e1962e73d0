#pragma once

// Scripts of config/talaris/ on the load cell (TALARIS thesis 5.2.1, 5.2.2, 5.2.5): valves alone,
// in pairs and all four for lift; fans by throttle. Vehicles are dispersed as in flights.h.
// All measured values are of telemetry, as a recording has them.

#include <Eigen/Core>
#include <vector>

#include "tests/talaris/chain/chain.h"

namespace lss::talaris {

// Of the world (sim::talaris::GasOptions, FanOptions).
inline constexpr double kDroop = 0.03, kBend = 0.3;

using Loads = Eigen::Matrix<double, 6, 1>;  // N along x, y, z; N m about them

// An actuation, or standstill: means of its last second.
struct Plateau {
  unsigned valves = 0, fans = 0;  // bit i: valve or fan i + 1
  double throttle = 0;
  Loads load = Loads::Zero(), true_load = Loads::Zero();  // less the zero
  double rpm = 0, true_rpm = 0;                           // of a fan
  double force_N() const { return load.head<3>().norm(); }
};

struct Series {
  std::vector<Plateau> all;
  double moved_N = 0;                         // the zero since the first one, at most
  double off_N = 0, off_Nm = 0, off_rpm = 0;  // largest errors, by the world
  bool measured() const { return !all.empty() && off_N < 1 && off_Nm < 0.5 && off_rpm <= 110; }
};
// The zero is the mean of the last second at standstill before each actuation. Empty: the daemon
// did not take the script to its end.
Series play(const char* script, unsigned seed);

// Force of `count` valves together, as a share of what they give alone: mean of all such sets.
double of_alone(const Series& series, int count);
// The fans by one throttle; throws when the script has no such step.
const Plateau& at(const Series& series, unsigned fans, double throttle);

}  // namespace lss::talaris
