#pragma once

// Each single failure of each valve and fan, in each phase of a hop on the whole chain.

#include <string>
#include <vector>

#include "tests/talaris/chain/flights.h"

namespace lss::talaris {

struct ActuatorFailure {
  std::string fault;      // as for lss-sim
  FaultId id;             // that the daemon has to find,
  std::uint16_t subject;  // of this actuator
  std::string kind;       // of the table's rows
  // A fan leaves 5 % of lift to spare and 10 N m to correct with, a lift valve that stays open
  // turns the vehicle all the time, and a frame of 200 ms passes before either is known: found and
  // down, however hard.
  bool often_lost;
};
// 8 valves stuck open, 8 stuck shut, 4 fans dead, 4 fans broken.
const std::vector<ActuatorFailure>& actuator_failures();

inline constexpr Phase kStruckPhases[] = {Phase::ascend, Phase::hover, Phase::traverse,
                                          Phase::descend};

// Its faults strike at a time in `phase` that the seed chooses, a vehicle with the fans' torque of
// the wide set.
FlightPlan struck_in(Phase phase, unsigned seed, FlightPlan plan);

struct Struck {
  Flown flown;
  bool found = false;        // the right verdict
  bool wrong = false;        // another one, before or instead
  double found_after_s = 0;  // from the failure
};
Struck strike(const ActuatorFailure& failure, Phase phase, unsigned seed);
inline constexpr double kSurvived_m_s = 2;
bool survived(const Flown& flown);  // upright, at most so fast down

// Nothing passes the CAN bus for so long, from a time in `phase` on that the seed chooses.
Flown fly_through_cut(double cut_s, Phase phase, unsigned seed);

// The same, the controller of the CAN bus being bus-off.
struct Outage {
  Flown flown;
  // Orders of the bus master from then on, until a frame after it came back: fans off, nodes reset.
  unsigned fans_off = 0, resets = 0;
};
Outage fly_through_bus_off(double off_s, Phase phase, unsigned seed);

// The same, both copies of the bus master's memory, or of the valves' timing, being damaged.
Outage fly_through_damage(bool of_valves, Phase phase, unsigned seed);

}  // namespace lss::talaris
