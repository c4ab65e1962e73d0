#pragma once

// The four electric ducted fans of TALARIS with their speed controllers (TALARIS thesis 2.3.2,
// 4.4.8, 5.2.2). After power-on a controller waits for its start-up procedure, full throttle for
// 380 ms and then none; before it the motor does not turn, after it throttle has its normal effect.
// One thread at a time; a step is 1 ms.

#include <array>
#include <cstdint>

#include "tools/lss-sim/talaris/plant.h"

namespace lss::sim::talaris {

struct FanOptions {
  double thrust_N = 116;  // at 33,000 rpm: 100 N at 6.37 kW (2.3.2), 8 kW is what the motor may
  double max_rpm = 33'000;
  double bend = 0;      // speed at throttle t: max_rpm (t + bend t (1 - t)); not linear (4.2)
  double lag_s = 0.25;  // throttle to speed, first order
  std::array<double, kFans> thrust_scale{1, 1, 1, 1};
  // Torque about x that the stators leave, of each N of thrust; neighbours turn against each other
  // (ours). Share by which each differs.
  double torque_m = 0;
  std::array<double, kFans> torque_scale{1, 1, 1, 1};
  double rotor_kg_m2 = 0;  // of each: speeding up turns the vehicle, tilting it precesses (ours)
  bool started = false;    // the controllers are already armed
};

// 1 (-y,-z), 2 (-y,+z), 3 (+y,+z), 4 (+y,-z); along +x.
const std::array<Vector3, kFans>& fan_places_m();

class Fans {
 public:
  explicit Fans(const FanOptions& options);

  // Pulse widths in microseconds; 0: no pulse.
  void step(const std::array<std::uint16_t, kFans>& pulse_us);
  // `rate_B_rad_s` of the vehicle.
  Wrench wrench(const Vector3& rate_B_rad_s = Vector3::Zero()) const;

  double rpm(std::size_t fan) const { return fans_[fan].rpm; }
  double thrust_N(std::size_t fan) const;
  bool armed(std::size_t fan) const { return fans_[fan].phase == Phase::armed; }
  // The controller was switched off and on: it needs its start-up procedure.
  void unarm(std::size_t fan) { fans_[fan].phase = Phase::waiting; }

  std::array<bool, kFans> dead{};    // motors without torque
  std::array<bool, kFans> broken{};  // they turn without thrust

 private:
  enum class Phase : std::uint8_t {
    waiting,   // for full throttle
    learning,  // full throttle; after 350 ms of it, no throttle leads to armed
    armed,     // follows its pulses
  };
  struct Fan {
    Phase phase = Phase::waiting;
    int full_ms = 0;    // duration of full throttle
    int silent_ms = 0;  // without a pulse
    double rpm = 0, last_rpm = 0;
  };

  FanOptions options_;
  std::array<Fan, kFans> fans_{};
};

}  // namespace lss::sim::talaris
