#pragma once

// Fault campaigns: scenarios that are drawn from their number alone, on the whole chain of a
// vehicle in virtual time (tests/NAME/chain). A scenario brings the vehicle to where it works,
// attaches one to three faults of `lss-sim faults NAME` at any moments, sends unsuitable commands,
// loses the operator, clears all faults and restarts the vehicle. In every frame, after any event:
//
//   - outside Operational no order moves the vehicle;
//   - the vehicle is at standstill soon after it left Operational, and stays so;
//   - every order is a number in its range;
//   - every command is acknowledged, and ended exactly once;
//   - the daemon's parts go on: nothing throws, frames count on;
//   - after all faults are cleared, the vehicle returns to Idle and starts again.

#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "tests/campaign/flips.h"

namespace lss::campaign {

// Counts of a scenario, or of several.
struct Tally {
  double simulated_s = 0;
  std::uint64_t frames = 0, faults = 0, commands = 0, rejected = 0;
  std::uint64_t stops = 0;        // into FatalError
  double slowest_rest_s = 0;      // from leaving Operational
  double slowest_cut_rest_s = 0;  // the same with the bus cut
  double slowest_idle_s = 0;      // from clearing of all faults to Idle

  void add(const Tally& other);
};

struct Run : Tally {
  unsigned number = 0;
  std::vector<std::string> story;   // log of the run, for a person
  std::vector<std::string> broken;  // violated conditions; empty: none
  std::uint64_t cycles = 0;         // fewer than frames where a vehicle's clock jumped over some
  std::string outcome;              // how it stood in the end, of vehicles that can fall
};

struct Subject {
  const char* vehicle;
  const char* begin;    // where the faults hit
  double rest_s;        // standstill within
  double cut_rest_s;    // with the bus cut
  const char* at_rest;  // what that is
  Run (*play)(unsigned number);
  // The same, with its choices from bytes (dice.h) instead of its number.
  // `seen`, if any, gets a number for the situation in each frame: state, mode, faults.
  Run (*play_script)(std::span<const std::uint8_t> script,
                     const std::function<void(std::uint64_t situation)>& seen);
  // The same, with its flight recording in files of this folder.
  Run (*record)(unsigned number, const std::filesystem::path& folder);
  FlipCounts (*flip)(const FlipPlan& plan);  // flips.h
};

std::span<const Subject> subjects();  // of the vehicles that are built

// Of the roster; each in its own file.
Subject zebro();
Subject ardito();
Subject talaris();

}  // namespace lss::campaign
