#pragma once

// The cold gas system of TALARIS: eight solenoid valves with their lags, the thrust that each
// gives, and the tank that they empty (TALARIS thesis 2.3.3, 4.2, 5.2.5). Body frame B as in
// plant.h. One thread at a time; a step is 1 ms.

#include <array>
#include <cstdint>

#include "tools/lss-sim/talaris/plant.h"

namespace lss::sim::talaris {

struct GasOptions {
  double thrust_N = 58;  // of a valve with regulated pressure; 58 on the load cell, 40 in 5.2.5
  std::array<double, kValves> thrust_scale{1, 1, 1, 1, 1, 1, 1, 1};
  int open_lag_ms = 8;  // from the node's output to the armature
  int close_lag_ms = 8;
  int travel_ms = 4;     // of the armature, thrust in proportion
  double budget_s = 44;  // thruster-seconds in the full tanks
  double gas_kg = 2;     // in the full tanks
  double fade = 0;       // share of the thrust lost when the tanks are nearly empty
  double fill = 1;       // share of the budget that is in the tanks at the start
  double droop = 0;      // share of the regulated pressure lost by each further open valve (2.3.3)
};

inline constexpr double kFullTank_kPa = 31'026;  // 4500 psi
inline constexpr double kRegulated_kPa = 4'137;  // 600 psi, ours

// Position and direction of valve i + 1, B: 1, 3, 5, 7 lift; 2, 8 push to +z, 4, 6 to -z.
struct Nozzle {
  Vector3 at_m, along;
};
const std::array<Nozzle, kValves>& nozzles();

class ColdGas {
 public:
  explicit ColdGas(const GasOptions& options)
      : options_(options), left_s_(options.budget_s * options.fill) {}

  void step(std::uint8_t commanded);  // bit i: valve i + 1
  Wrench wrench() const;

  double thrust_N(std::size_t valve) const;
  std::uint8_t open() const;  // armatures off their seats
  // thruster-seconds, leaks too
  double used_s() const { return options_.budget_s * options_.fill - left_s_; }
  double left_s() const { return left_s_; }
  double used_kg() const { return used_s() / options_.budget_s * options_.gas_kg; }
  double tank_kPa() const;
  double regulated_kPa() const;

  // Faults.
  std::array<bool, kValves> stuck_open{}, stuck_shut{};
  double leak_s_per_s = 0;  // thruster-seconds lost each second
  double regulator = 1;     // share of the pressure that the regulator still supplies
  void set_left_s(double left_s) { left_s_ = left_s; }

 private:
  struct Valve {
    bool open = false;  // target of the armature
    int lagging_ms = 0;
    double lift = 0;  // 0 shut, 1 open
  };
  double pressure_share() const;

  GasOptions options_;
  std::array<Valve, kValves> valves_{};
  double left_s_;
};

}  // namespace lss::sim::talaris
