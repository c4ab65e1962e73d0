#pragma once

// All parameters of TALARIS' guidance, control and flight logic. Sources: numbers such as "2.3.3"
// are sections of the TALARIS thesis; "ours" was chosen here (reasons: docs/gnc-talaris.md).
// Navigation has its own (navigation.h). Plain members, so that a configuration can fill them.

#include <array>
#include <cstddef>

#include "gnc/talaris/types.h"
#include "idl/angles.h"

namespace lss::gnc::talaris {

inline constexpr std::size_t kGainSets = 8;

struct Body {
  double mass_kg = 45;           // with full tanks (2.3.3)
  double inertia_x_kg_m2 = 4.5;  // roll, about the vertical; built up from the parts (ours)
  double inertia_y_kg_m2 = 3.0;  // pitch
  double inertia_z_kg_m2 = 1.8;  // yaw
};

// Cold gas. Valves 1, 3, 5, 7 lift at (-y,-z), (-y,+z), (+y,+z), (+y,-z); beside them 2, 4, 6, 8
// push along +z, -z, -z, +z (2.3.3, 4.2). Places: of the load line from the CM.
struct Thrusters {
  double force_N = 58;     // of one; 58 on the load cell (2.3.3), about 40 in 5.2.5
  double lift_y_m = 0.30;  // ours, from the plate of 0.76 m x 0.99 m (2.3.1)
  double lift_z_m = 0.40;
  double side_y_m = 0.30;
  double min_on_s = 0.040;         // shortest pulse and shortest pause (2.3.3)
  double max_on_s = 0.160;         // (4.2)
  double long_on_s = 0.200;        // by the phase plane only: open into the next frame (4.2)
  double attitude_room_s = 0.010;  // left by the lift to off-pulsing at its limits (ours)
  double lag_s = 0.008;            // edge to force, opening and closing (ours)
};

// Electric ducted fans at the corners: 1 (-y,-z), 2 (-y,+z), 3 (+y,+z), 4 (+y,-z), along +x.
struct Fans {
  double thrust_N_per_rpm2 = 116.0 / (33000.0 * 33000.0);  // ours: 100 N at 6.37 kW (2.3.2) is
                                                           // 116 N at the 8 kW of the motor
  double max_rpm = 33000;                                  // at full throttle, loaded (ours)
  double lag_s = 0.25;  // throttle to rpm, first order (ours, 0.2 to 0.3)
  double y_m = 0.33;    // of the corners (ours)
  double z_m = 0.44;
  double weight_share = 5.0 / 6;  // of the initial weight that they carry in a hop (2.2)
  double rpm_quantum = 200;       // of the sensor (5.2.2)
  double esc_min_us = 1000;       // no throttle (4.4.8)
  double esc_max_us = 2000;       // full throttle
  double ramp_rpm_s = 12000;      // of a commanded speed on the ground (ours)
  double settled_rpm = 400;       // this close to the target counts as there,
  double settled_s = 1;           // for so long (unequal fans tilt the vehicle)
  double spin_up_timeout_s = 12;  // then the flight is aborted on the ground
  double max_run_s = 45;          // batteries and speed controllers get hot (2.3.4)
};

struct Gas {
  double budget_s = 44;             // thruster-seconds of full tanks (2.3.3)
  double reserve_s = 3;             // left by a plan (ours)
  double attitude_N = 7;            // mean force for attitude control (ours, from runs)
  double mass_kg = 2;               // full tanks relative to empty ones (ours)
  double full_kPa = 31026;          // 4500 psi (2.3.3)
  double empty_kPa = 3000;          // tank; below it the regulator does not regulate (ours)
  double min_regulated_kPa = 1000;  // below it: no reliable thrust (ours)
};

// Profile of a flight; accelerations are peaks of a minimum-effort motion between standstills.
struct Profile {
  double climb_m_s2 = 0.75;          // 2 m in 4 s (ours)
  double descend_m_s2 = 0.70;        // 2 m in 4 s
  double hover_s = 1;                // before and after the traverse
  double lateral_duty = 0.70;        // of the lateral thrust: 30 m in 10 s (58 N), 12 s (40 N)
  double min_leg_s = 4;              // no motion is planned faster
  double touchdown_height_m = 0.15;  // guidance ends here, with the speed below
  double touchdown_speed_m_s = 0.15;
  double clearance_m = 0.30;                // from the wall, at the end of a traverse on the ground
  double settle_angle_rad = 3.0 * kDegree;  // a turn is done within this,
  double settle_rate_rad_s = 8.0 * kDegree;
  double settle_s = 1;                    // for so long
  double turn_rate_rad_s = 20 * kDegree;  // assumed by the planner
  double turn_timeout_s = 12;             // more than the planned time
  double keep_s = 10;                     // program attitude, when no time is given
  double stand_on_s = 0.080;              // lift pulses of the program attitude
};

struct Gains {
  // attitude by cold gas: alpha = -wn^2 e - 2 zeta wn w - ki integral(e)
  double attitude_wn_rad_s = 1.6;
  double attitude_zeta = 0.9;
  double attitude_ki_1_s3 = 0.6;
  double attitude_max_integral_rad_s2 = 1.5;  // for a load on one end (5.2.8)
  double attitude_observer =
      0.35;  // share by which the disturbance is corrected in a frame; 0: off
  // roll: phase plane. Dead band and half a smallest pulse on the slope stay below settle_angle_rad
  double roll_dead_band_rad = 0.8 * kDegree;
  double roll_rate_limit_rad_s = 20 * kDegree;
  double roll_brake_share = 0.35;  // of the acceleration, in the switching curve
  double roll_slope_1_s = 3;       // of the curve near the dead band, where the root is steep
  double roll_share = 0.7;         // share of a rate error that one pulse removes
  // lateral y by tilt; z by jets
  double lateral_wn_rad_s = 0.45;
  double lateral_zeta = 0.9;
  double lateral_max_tilt_rad = 0.15;  // 66 N of wind
  double lateral_carry_N_s = 8;        // sigma-delta clamp
  // fans: rpm
  double rpm_kp = 0.3;  // throttle per share of max_rpm
  double rpm_ki_1_s = 1.0;
  // fans: height, PID on top of the hover speed; acceleration per error
  double height_kp_1_s2 = 1.0;
  double height_ki_1_s3 = 0.12;
  double height_kd_1_s = 1.6;
  double height_rate_m_s = 0.20;  // of the commanded height
  // fans: attitude; the loop's four poles, rad/s
  double fan_attitude_pole_rad_s = 2.2;
  double fan_max_tilt_rad = 0.17;  // to brake sideways in parachute
};

// Limits after which a flight has left its plan (docs/gnc-talaris.md, contingencies).
struct Limits {
  double imu_hold_s = 0.25;   // without IMU: bridged; longer: lost
  double range_age_s = 1.0;   // altimeter older: lost
  double valve_age_s = 0.45;  // its pressures come at 5 Hz
  double fan_age_s = 0.25;    // its speeds come at 50 Hz
  double tilt_rad = 30 * kDegree;
  double rate_rad_s = 180 * kDegree;
  double altimeter_max_m = 30;  // (2.3.5)
  double altimeter_min_m = 0.1;
  double altimeter_share = 0.9;    // of its range, for a plan
  double escape_m_s2 = 0.8;        // peak acceleration of the way down
  double blind_m_s = 0.30;         // the end of an escape without altimeter
  double parachute_m_s = 0.50;     // how fast down by the fans
  double level_m_s = 0.80;         // the same without attitude: the IMU is gone
  double contact_height_m = 0.06;  // below it and slow: on the ground
  double contact_speed_m_s = 0.08;
  double contact_m_s2 = 0.45;  // more than commanded, on the way down: contact
  double run_down_s = 2;       // fans after touchdown
  // The corridor of a hop around its plan (ours); above: the flight ends here, in good order.
  double corridor_side_m = 8;
  double corridor_height_m = 1.8;
  double corridor_m_s = 2.5;  // sideways, off the planned speed
  double corridor_tilt_rad = 20 * kDegree;
  double corridor_late_s = 15;
  double wind_m_s2 = 1.3;  // steady push over mass: 58 N; leaning stands 66 N; half more along z
  // So far off it waits and comes back.
  double waver_m = 4;
  double waver_m_s = 2;
  // What counts as a landing as planned, by what navigation cannot exclude (3 sigma).
  double place_m = 6;
  double touchdown_m_s = 1.0;
  double touchdown_side_m_s = 0.5;
  double upright_rad = 20 * kDegree;
};

struct Parameters {
  double offset_s = 0.005;  // release of a frame's command after its T_k (50 ms in 4.3)
  Body body;
  Thrusters thrusters;
  Fans fans;
  Gas gas;
  Profile profile;
  Limits limits;
  std::array<Gains, kGainSets> gains{};  // set 1 is gains[0]
  std::size_t gain_sets = 1;             // how many there are
};

// nullptr when usable, else a sentence with the error and its remedy. Before the loop.
const char* check(const Parameters& parameters) noexcept;

// Rpm at which the fans carry `force_N` together.
double rpm_for(double force_N, const Fans& fans) noexcept;

}  // namespace lss::gnc::talaris
