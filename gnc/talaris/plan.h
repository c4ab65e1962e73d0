#pragma once

// Checks a request against gas, thrust, fans and altimeter, and computes the duration of each part.
// Pure function, called when a plan is commanded; nothing allocates. TALARIS thesis 2.2, 2.3.3.

#include <cstdint>

#include "gnc/talaris/parameters.h"

namespace lss::gnc::talaris {

// Numbers as in the command table.
enum class Program : std::uint8_t {
  hop,            // up, (turn,) sideways, down: fans carry 5/6, cold gas 1/6
  traverse,       // sideways on rails
  turn,           // about the vertical, on the sled
  turn_traverse,  // turn, then along the new +z, on the sled
  attitude,       // hold the attitude; the stand fixes height and place
  altitude,       // up and down like the hop, on the stand
  fan_altitude,   // up and down by the fans alone, attitude fixed by the stand
  parachute,      // up and down by the fans alone, with attitude control
};
inline constexpr std::uint8_t kPrograms = 8;

struct PlanRequest {
  Program program = Program::hop;
  double height_m = 2;     // above where it stands
  double distance_m = 30;  // along +z after the turn
  double turn_rad = 0;
  double time_s = 0;      // of the traverse, or to keep; 0: computed
  double range_m = kNaN;  // present reading of the altimeter, if any: the wall of a traverse
};

// The guard that failed. measured and limit are in the given unit.
enum class Guard : std::uint8_t {
  none,
  request,        // not a number, or an unknown program
  height,         // m, of the request: too little to fly
  gas,            // thruster-seconds needed; left without the reserve
  hover_on_time,  // s, pulse that holds the vehicle; what valves can do (4.2)
  climb,          // m/s2, peak; available from the thrust
  lateral,        // m/s2, peak; available from the lateral thrusters
  altimeter,      // m; range of the altimeter
  wall,           // m to go; to the wall without clearance
  fan_thrust,     // N needed of all fans; what they have
  run_time,       // s, fans run; their limit (2.3.4)
};
inline constexpr const char* kGuardNames[] = {"none",          "request",    "height",  "gas",
                                              "hover-on-time", "climb",      "lateral", "altimeter",
                                              "wall",          "fan-thrust", "run-time"};

struct Plan {
  PlanRequest request;
  // s; 0: not part of the program
  double climb_s = 0, hover_s = 0, turn_s = 0, traverse_s = 0, descend_s = 0, keep_s = 0;
  double total_s = 0;  // from lift-off to contact
  double gas_s = 0;    // thruster-seconds needed, without reserve
  double fan_rpm = 0;  // speed of the fans; 0: off
  bool uses_fans = false, uses_gas = false, needs_altimeter = false, flies = false;
};

struct PlanResult {
  Guard guard = Guard::none;  // none: feasible
  double measured = 0, limit = 0;
  Plan plan;  // also of an infeasible request, as far as computed

  bool feasible() const noexcept { return guard == Guard::none; }
};

// Parameters must have passed check(). `gas_left_s`: thruster-seconds in the tanks.
PlanResult make_plan(const PlanRequest& request, const Parameters& parameters,
                     double gas_left_s) noexcept;

// Mean number of thrusters that hold the vehicle up beside the fans, attitude included.
double hover_thrusters(const Parameters& parameters) noexcept;

}  // namespace lss::gnc::talaris
