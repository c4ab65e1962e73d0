#pragma once

// Single runs of the campaigns of the TALARIS thesis 5.2 on the whole chain, and what the world saw
// of them. Vehicles and their set-up are dispersed by the seed (docs/simulator.md has the ranges);
// noise, biases and the phases of the clocks also depend on the seed.

#include <array>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "tests/talaris/chain/chain.h"

namespace lss::talaris {

// ---- free flights

struct FlightPlan {
  std::string config = "hop";
  Program program = Program::hop;
  Chain::HopRequest request{};
  std::vector<std::string> faults{};          // as for lss-sim
  double fault_s = 0;                         // after lift-off
  std::function<bool(Chain&)> strike{};       // ... when this becomes true, if it is set
  std::function<bool(Chain&)> strike_step{};  // the same, asked every millisecond
  std::function<void(Chain&)> each_frame{};
  bool dispersed = true;
  sim::talaris::Spread spread{};      // of the dispersion
  double late_share = 0, late_s = 0;  // of frames
  std::function<void(Parameters&)> adjust{};
  std::function<void(sim::talaris::TalarisOptions&)> world{};
};

struct Flown {
  unsigned seed = 0;
  bool accepted = false;  // prepared, planned, executed
  bool lifted_off = false;
  bool came_down = false;  // and lay still at the end
  bool succeeded = false;  // the daemon says: as planned, no fault
  // By the world.
  double down_m_s = 0, sideways_m_s = 0, contact_tilt_deg = 0;  // of the landing
  double rest_tilt_deg = 0, ground_tilt_deg = 0;  // in the end, and the most since contact
  double sinkage_m = 0;                           // of the deepest foot, in the end
  double noticed_s = std::numeric_limits<double>::quiet_NaN();  // contact by the daemon, after it
  double along_m = 0, across_m = 0;                             // from where it should stand
  double nav_along_m = 0, nav_across_m = 0;                     // navigation error at touchdown
  double nav_side_m_s = 0;                                      // and of its speed, sideways
  double sigma_m = 0, sigma_m_s = 0;  // of one axis, as navigation's covariance predicts them
  double max_height_m = 0, max_tilt_deg = 0, height_error_m = 0;  // in the air
  double told_down_m_s = 0, told_sideways_m_s = 0;                // by the daemon
  double gas_s = 0, air_s = 0;
  double run_s = 0;  // from execute to the end
  double slope_deg = 0;
  Reason why = Reason::none;  // of the command's failure
  std::vector<FaultId> faults;

  bool upright() const { return came_down && rest_tilt_deg < 10 + slope_deg; }
  double off_m() const;      // from where it should stand
  double nav_off_m() const;  // of that navigation's error
  std::string text() const;
};

// The same with a sensor beyond those as built.
FlightPlan with_camera(FlightPlan plan);
FlightPlan with_standby_imu(FlightPlan plan);
FlightPlan with_corner_altimeters(FlightPlan plan);

Flown fly(const FlightPlan& plan, unsigned seed);

// ---- stands

// On the sled: the turn, or the turn towards the wall and the traverse.
struct Slid {
  bool succeeded = false;  // as the daemon says
  double turn_deg = 0;     // true, from the target
  double along_m = 0;      // true, towards the wall, from the target
  double gas_s = 0, time_s = 0;
};
Slid turn_on_sled(double degrees, unsigned seed);
Slid turn_and_traverse(unsigned seed);
Slid traverse_on_rails(double distance_m, unsigned seed);

// On the pivot: `weight_kg` hangs at one end.
struct Held {
  bool succeeded = false;
  double begin_deg = 0;    // of tilt, when it began
  double settled_deg = 0;  // most, from 5 s after that on
  double gas_s = 0;
};
Held hold_attitude(double weight_kg, unsigned seed);

// Height and one axis of attitude on the lift.
struct Lifted {
  bool succeeded = false;
  double top_m = 0, tilt_deg = 0, down_m_s = 0, gas_s = 0;
};
Lifted lift_and_hold(unsigned seed);

// Up and down by the fans alone, with gains 1 to 3 of the configuration, one after the other.
struct Hopped {
  bool succeeded = false;
  double top_m = 0, overshoot_m = 0, rise_s = 0, down_m_s = 0;
  // Up, not much too high, and down again.
  bool reached() const { return succeeded && rise_s > 0 && overshoot_m < 0.15; }
};
std::array<Hopped, 3> hop_by_fans(double height_m, unsigned seed);

// Speed of fans, bolted down: up a ramp, steady, down. `fans`: bit i: fan i + 1.
struct Spun {
  bool armed = false;
  double ramp_rpm = 0;    // most, off the ramp that was commanded, from 1 s after its begin on
  double mean_rpm = 0;    // error of the steady speed, the worst of the fans
  double steady_rpm = 0;  // largest steady error
};
Spun spin(unsigned fans, double rpm, unsigned seed);

// A valve on the load cell.
struct Fired {
  double force_N = 0;  // mean of the load cell behind the daemon's notch, while it is open
  double true_N = 0;
  double raw_N = 0;    // swing of the load cell's own reading, peak to peak
  double clean_N = 0;  // the same behind the notch
  double on_ms = 0;    // mean open time of ten pulses, by the daemon's edges
  double gas_ms = 0;   // true: impulse through force
  double open_ms = 0;  // from the edge to full thrust, and from the edge to none
  double shut_ms = 0;
};
Fired fire(unsigned valve, double on_s, unsigned seed);

}  // namespace lss::talaris
