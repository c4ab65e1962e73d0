#pragma once

// Dimensions, limits and thresholds of the mobility controller, with the Ardito thesis' values.

#include <tuple>

#include "gnc/ardito/types.h"
#include "idl/angles.h"

namespace lss::gnc::ardito {

// Ardito thesis 13.4 and 14. The two describe slightly different rovers (E22): a..f are for the
// plane, l1..l6 for the suspension, and neither is derived from the other.
struct Geometry {
  double a_m = 0.782;  // between the front wheels
  double b_m = 0.782;  // between the middle wheels
  double c_m = 0.782;  // between the rear wheels
  double d_m = 0.612;  // front axle ahead of the middle axle
  double e_m = 0.587;  // rear axle behind the middle axle
  double f_m = 0.070;  // CM ahead of the middle axle; the rocker's pivot is this far behind the CM
  double wheel_radius_m = 0.150;
  double gear_ratio = 50;  // motor to wheel, traction and steering
  double l1_m = 0.554;
  double l2_m = 0.280;
  double l3_m = 0.141;
  double l4_m = 0.343;
  double l5_m = 0.285;
  double l6_m = 0.234;
  double k1_rad = 15 * kDegree;
  double k3_rad = 43 * kDegree;

  template <class Self>
  static constexpr auto members(Self& self) noexcept {
    return std::tie(self.a_m, self.b_m, self.c_m, self.d_m, self.e_m, self.f_m, self.wheel_radius_m,
                    self.gear_ratio, self.l1_m, self.l2_m, self.l3_m, self.l4_m, self.l5_m,
                    self.l6_m, self.k1_rad, self.k3_rad);
  }
};

inline constexpr std::size_t kNoLoadPoints = 5;

struct Parameters {
  Geometry geometry;

  // cruise control (11)
  double top_speed_m_s = 1.0;  // upper limit of Request::speed_limit_m_s
  double max_sigma_rad = 5 * kDegree;
  double min_speed = 0.01;           // normalised; less is a stop
  double steady_sigma_rad = 1e-6;    // per frame: sigma counts as unchanged
  double standing_rad_s = 0.1;       // wheel speed below which the rover stands
  double steered_rad = 0.035;        // angle error below which it is steered
  double parking_length_m = 3.4290;  // yaw rate on the spot = Vtan / this (E10)
  double deceleration_m_s2 = 0.5;    // of every stop that is not an emergency

  // correction and ratio blocks (12)
  double correction_sign = 1;   // E7; -1 is the thesis' print, 0: no correction
  double max_correction = 0.5;  // share of a wheel's speed in the plane
  double proportional = 0.5;
  double integral_1_s = 4;
  double wheel_saturation_rad_s = 3.5 * kRadPerSecondPerRpm;
  double steering_saturation_rad = 0.08;

  // age limits: a value older than this is a fault
  double drive_age_s = 0.25;
  double temperature_age_s = 3;
  double rocker_age_s = 0.25;
  double imu_age_s = 0.25;

  // flags of a wheel (17.2)
  double agree_rad_s = 2 * kRadPerSecondPerRpm;
  double agree_share = 0.2;
  double still_rad_s = 2 * kRadPerSecondPerRpm;  // rho below this: the wheel does not turn
  double slow_rad_s = 5 * kRadPerSecondPerRpm;   // rho below this: it hardly turns
  // flags of a steering system (17.4), 2 rad on the motor's side
  double steering_agree_rad = 0.04;
  double steering_step_rad = 0.02;  // in a frame: both encoders of a gear make it, or one is lost
  // correction, coherence, slip (17.8)
  double imu_agree_m_s = 0.020;  // E12
  double coherent_m_s = 0.135;
  double coherent_share = 0.5;  // of the rover's speed, where that is less
  double coherent_sigma_rad = 0.01;
  double slip_m_s = 0.150;
  double slip_sigma_rad = 0.08;
  // wheels that slip, against an IMU that is wrong
  double slip_share = 0.7;         // of the wheels' speed that is lost: more than that is stuck
  double slip_speed_m_s = 0.07;    // slower wheels are not judged by their share
  double slip_load = 0.18;         // mean load of motors that push against the ground
  double turning_rad_s = 0.05;     // yaw rate that an IMU cannot miss
  double slide_lost_share = 0.06;  // of the speed: wheels that push and lose it may slide sideways
  // slip that reduces the speed
  double slow_share = 0.4;       // of the wheels' speed that is lost: slower above it
  double slow_hysteresis = 0.1;  // and as before below slow_share less this
  double slow_factor = 0.5;      // of the requested speed then
  double slow_least_m_s = 0.12;  // never slower than that: slip could not be measured
  double slow_rate_1_s = 0.5;    // how fast the factor changes
  double slow_filter_s = 1;      // of the measured slip
  // one wheel that digs itself in
  double sink_m = 0.06;            // lower than the plane of the others
  double sink_strain = 1.8;        // and its motor's load, times that of the others:
  double sink_strain_deep = 1.25;  // falling to this one of a wheel sink_deep times as low
  double sink_deep = 1.8;
  double sink_slip = 0.04;     // and lost of the wheels' speed: more than on hard ground
  double sink_filter_s = 0.5;  // of depth and load
  // yaw rate of the IMU against the inverse model (7.2.1)
  double yaw_agree_rad_s = 0.05;
  double yaw_filter_s = 5;

  // counters (18.1), frames
  std::uint32_t sensor_frames = 3;
  std::uint32_t motor_frames = 5;
  std::uint32_t reduction_frames = 5;
  std::uint32_t clutch_frames = 10;
  std::uint32_t two_sensors_frames = 5;
  std::uint32_t all_sensors_frames = 3;
  std::uint32_t all_sensors_error_frames = 8;
  std::uint32_t steering_encoder_frames = 3;
  std::uint32_t steering_frames = 5;
  std::uint32_t motor_test_frames = 1;  // motor runs on with the clutch open: is it the motor?
  std::uint32_t inconclusive_frames = 20;
  std::uint32_t max_lost_wheels = 2;  // isolated without an error
  std::uint32_t imu_frames = 20;      // contradiction with coherent wheels before it is a fault
  std::uint32_t stuck_frames = 12;    // of slip before the rover counts as stuck
  std::uint32_t rocker_frames = 50;   // without a jump before angles are trusted again

  std::uint32_t imu_frozen_frames = 2;  // with the same counter: silent
  std::uint32_t overcurrent_frames = 10;
  std::uint32_t quiet_frames = 6;        // clutch: at no load before a probe
  std::uint32_t probe_frames = 6;        // how long, twice that without a reduction encoder
  std::uint32_t probe_pause_frames = 4;  // after a probe without findings
  double rocker_step_rad = 0.5;          // in a frame: no rocker or bogie turns further
  double rocker_way_m = 20;              // one way, over which they must be 0 on average
  double rocker_mean_rad = 0.04;         // by less than this: beta (0.01 rad are 13 mm at a wheel)
  double bogie_mean_rad = 0.08;          // rho1, rho2 (5 mm)
  // motor supervision (FMEA 7.1.1, 7.2.2)
  double warm_temperature_C = 90;  // reported
  double max_temperature_C = 105;  // taken out
  double max_current = 2.0;        // share of rated, for overcurrent_frames
  double max_steering_current = 2.0;

  // clutch test (part VII): current of the motor with the clutch open, at these wheel speeds
  std::array<double, kNoLoadPoints> no_load_rad_s = {0, 1, 2, 4, 8};
  std::array<double, kNoLoadPoints> no_load_current = {0.05, 0.06, 0.07, 0.09, 0.13};
  double no_load_tolerance = 0.025;                   // a motor this close to it is at no load
  double clutch_min_rad_s = 4 * kRadPerSecondPerRpm;  // slower wheels are not tested
  double clutch_drift_rad = 0.06;  // motor ahead of wheel by this: nothing couples them
  double loaded_current = 0.08;    // of the other wheels' mean, above no load: else no conclusion
  double probe_share = 0.2;        // slower by this share, and by probe_rad_s at least
  double probe_rad_s = 3 * kRadPerSecondPerRpm;

  template <class Self>
  static constexpr auto members(Self& self) noexcept {
    return std::tie(
        self.geometry, self.top_speed_m_s, self.max_sigma_rad, self.min_speed,
        self.steady_sigma_rad, self.standing_rad_s, self.steered_rad, self.parking_length_m,
        self.deceleration_m_s2, self.correction_sign, self.max_correction, self.proportional,
        self.integral_1_s, self.wheel_saturation_rad_s, self.steering_saturation_rad,
        self.drive_age_s, self.temperature_age_s, self.rocker_age_s, self.imu_age_s,
        self.agree_rad_s, self.agree_share, self.still_rad_s, self.slow_rad_s,
        self.steering_agree_rad, self.steering_step_rad, self.imu_agree_m_s, self.coherent_m_s,
        self.coherent_share, self.coherent_sigma_rad, self.slip_m_s, self.slip_sigma_rad,
        self.slip_share, self.slip_speed_m_s, self.slip_load, self.turning_rad_s,
        self.slide_lost_share, self.slow_share, self.slow_hysteresis, self.slow_factor,
        self.slow_least_m_s, self.slow_rate_1_s, self.slow_filter_s, self.sink_m, self.sink_strain,
        self.sink_strain_deep, self.sink_deep, self.sink_slip, self.sink_filter_s,
        self.yaw_agree_rad_s, self.yaw_filter_s, self.sensor_frames, self.motor_frames,
        self.reduction_frames, self.clutch_frames, self.two_sensors_frames, self.all_sensors_frames,
        self.all_sensors_error_frames, self.steering_encoder_frames, self.steering_frames,
        self.motor_test_frames, self.inconclusive_frames, self.max_lost_wheels, self.imu_frames,
        self.stuck_frames, self.rocker_frames, self.imu_frozen_frames, self.overcurrent_frames,
        self.quiet_frames, self.probe_frames, self.probe_pause_frames, self.rocker_step_rad,
        self.rocker_way_m, self.rocker_mean_rad, self.bogie_mean_rad, self.warm_temperature_C,
        self.max_temperature_C, self.max_current, self.max_steering_current, self.no_load_rad_s,
        self.no_load_current, self.no_load_tolerance, self.clutch_min_rad_s, self.clutch_drift_rad,
        self.loaded_current, self.probe_share, self.probe_rad_s);
  }
};

// nullptr when usable, else a sentence about the error. Before the loop starts.
const char* check(const Parameters& parameters) noexcept;

}  // namespace lss::gnc::ardito
