#pragma once

// The campaigns of the TALARIS thesis 5.2, each flown with its file in config/talaris/: their
// tables for docs/talaris-results.md, compared with the thesis. A campaign's short form is in
// campaigns_test.cpp.

#include <array>
#include <ostream>
#include <string>
#include <vector>

#include "tests/talaris/chain/flights.h"
#include "tests/talaris/chain/loads.h"

namespace lss::talaris {

// The failure of a hop, and the acceptable ends in spite of it.
struct Failure {
  const char* name;
  std::vector<std::string> faults;           // as for lss-sim
  const char* right;                         // the expected end of the flight
  FlightPlan (*with)(FlightPlan) = nullptr;  // more sensors than as built
  bool often_lost = false;                   // nothing is left to bring it down gently
};
const std::vector<Failure>& failures();
// The failure strikes between lift-off and descent, when is the seed's.
Flown fail(const Failure& failure, unsigned seed, unsigned seeds);
// Of IMU and altimeter; in `phase`, when is the seed's.
const std::vector<Failure>& sensor_failures();
Flown fail_in(Phase phase, const Failure& failure, unsigned seed);

// How a hop has to end to be counted: as planned by the daemon, upright by the world.
bool good(const Flown& flown);

bool reached_place(const Slid& slid);    // within 15 cm
bool reached_heading(const Slid& slid);  // within 5 deg

FlightPlan parachute_flight();

// The rows of the hop's table.
struct HopFigure {
  const char* name;
  int digits;
  double (*get)(const Flown&);
};
extern const std::vector<HopFigure> kHopFigures;

// Tables. Every line of the campaign is printed as it is flown.
std::string hop_section(unsigned seeds);
std::string stands_section(unsigned seeds, unsigned sled_seeds);
// One table of all failures; those of IMU and altimeter, valves and fans (failed_actuators.h) in
// each phase.
std::string failures_section(unsigned seeds, unsigned phase_seeds);
std::string sensors_section(unsigned seeds);  // their part alone
std::string actuators_section(unsigned seeds);

// The wide set (sim::talaris::kWide), and where it no longer stands: each cause alone, swept.
// `picture`: an SVG file of the sweeps.
bool safe(const Flown& flown);   // upright, at most 1 m/s down and 0.5 m/s sideways
bool wrong(const Flown& flown);  // says "as planned" and was not, by the world: safe, within 6 m
FlightPlan wide_flight();
std::string wide_section(unsigned seeds);
std::string camera_section(unsigned seeds);   // the wide set with a camera
std::string corners_section(unsigned seeds);  // and with altimeters at the corners
// A single cause on the narrow dispersion, in a direction that goes with the seed.
struct Alone {
  const char *name, *what, *value;
  void (*set)(sim::talaris::TalarisOptions& world, double to_rad);
  friend std::ostream& operator<<(std::ostream& out, const Alone& cause) {
    return out << cause.name;
  }
};
extern const std::array<Alone, 3> kAlone;
std::vector<Flown> fly_alone(const Alone& cause, unsigned seeds);
std::string alone_section(unsigned seeds);
std::string edge_section(unsigned seeds, const std::string& picture);

}  // namespace lss::talaris
