#pragma once

// Numbers of navigation, with TALARIS' values. [D]: ours, to be tuned on hardware.

#include "gnc/talaris/types.h"
#include "idl/angles.h"

namespace lss::gnc::talaris {

inline constexpr double kLatestRange_s = 0.5;  // an older range is not used
// Along the way the ground rises and falls like a random walk: its slope lasts for so long.
inline constexpr double kGroundWave_m = 5;
inline constexpr std::size_t kCorners = 4;

constexpr double in_seconds(std::int64_t ns) noexcept { return static_cast<double>(ns) * 1e-9; }

// Free rotation of the vehicle on its stand, about an axis of N.
enum class FreeRotation : std::uint8_t { all, none, x, y, z };

// Constraints of a test stand (TALARIS thesis 5.2), passed to the filter once a frame. Rail of the
// altitude stand: y, z, none. Sled: x, FreeRotation::x. Pivot: x, y, z, FreeRotation::y or z.
struct Stand {
  bool fixed_x = false;  // along the axes of N
  bool fixed_y = false;
  bool fixed_z = false;
  FreeRotation rotation = FreeRotation::all;
  double position_sigma_m = 0.02;             // play of the stand [D]
  double velocity_sigma_m_s = 0.02;           // [D]
  double attitude_sigma_rad = 0.3 * kDegree;  // [D]
};

struct NavigationParameters {
  // altimeter: Acuity AR1000 (TALARIS thesis 2.3.5)
  Pointing pointing = Pointing::down;
  bool altimeter = true;                       // false: there is none, dead reckoning only
  Vector3 altimeter_at_B_m = Vector3::Zero();  // from the centre of mass, mounting [D]
  double range_sigma_m = 0.01;                 // 3 mm by data sheet, and the ground's roughness
  double ground_slope_rad = 4 * kDegree;       // of ground flown over, 1 sigma [D]
  double range_min_m = 0.1;
  double range_max_m = 30;
  double range_latency_s = 0;          // from the measurement to the first byte [D]
  double gate_sigma = 5;               // larger innovations are not used
  int gate_reopens_after = 10;         // gated readings in a row that agree: about 1 s [D]
  double max_tilt_rad = 60 * kDegree;  // readings of a more inclined beam are not used [D]

  // four more altimeters at the corners, along -x (2.3.6 plans them): at +y +z, +y -z, -y -z, -y +z
  bool corners = false;
  double corner_x_m = 0, corner_y_m = 0.38, corner_z_m = 0.495;  // of the structure (2.3.1)

  // camera beside the altimeter, along -x (2.3.6 plans one)
  bool camera = false;
  double flow_period_s = 0.05;               // of its samples
  double flow_sigma_rad_s = 0.025;           // of a sample [D]
  double flow_scale_sigma = 0.01;            // of what it measures [D]
  double flow_min_m = 0.1, flow_max_m = 10;  // distance at which it is sharp [D]

  // IMU: Gladiator LandMark 30 (2.3.6); noise is white, density as 1/sqrt(Hz) at 1 s: standard
  // deviation of a packet times the root of its time, quantisation included. 0.05 deg/s and 0.01
  // m/s2 in a packet of 5 ms, as lss-sim's; to be measured again on hardware
  double imu_period_s = 0.005;           // Crossbow polled at 100 Hz: 0.010
  double force_noise = 7.5e-4;           // m/s2/sqrt(Hz) [D]
  double rate_noise = 0.0036 * kDegree;  // rad/s/sqrt(Hz) [D]
  double force_bias_walk = 2e-4;         // m/s2/sqrt(s) [D]
  double rate_bias_walk = 3.5e-5;        // rad/s/sqrt(s) [D]
  double max_rate_rad_s = 35;            // a larger sample is invalid [D]
  double max_force_m_s2 = 200;           // as above [D]

  // silence of the IMU
  double hold_s = 0.25;                    // longer: `valid` goes false
  double gap_rotation_rad_s2 = 4;          // change of the rate meanwhile, 1 sigma [D]
  double gap_acceleration_m_s2 = 3;        // error of the acceleration meanwhile [D]
  double lost_attitude_rad = 5 * kDegree;  // attitude sigma up to which `valid` returns [D]

  // calibration (4.5.1: "usually 30 s")
  double calibration_s = 30;
  int calibration_restarts = 3;              // movement restarts it so often, then it fails [D]
  double still_rate_rad_s = 0.3 * kDegree;   // mean of a frame against the mean so far [D]
  double still_force_m_s2 = 0.3;             // as above, about 7 sigma of the noise [D]
  double rate_spread_rad_s = 0.5 * kDegree;  // standard deviation within a frame [D]
  double force_spread_m_s2 = 0.8;            // as above [D]
  double max_rate_bias_rad_s = 1 * kDegree;  // a larger mean is a rotation or a broken gyro [D]
  double max_force_error_m_s2 = 0.5;         // of |mean force| against g [D]
  double max_calibration_tilt_rad = 15 * kDegree;  // [D]
  double min_samples = 0.9;                        // share of the expected ones, IMU [D]
  int min_ranges = 20;                             // when there is an altimeter [D]
  double range_spread_m = 0.05;                    // between the quartiles [D]
  double roll_rad = 0;  // heading about the vertical in N while calibrating
  double height_m = 0;  // of the centre of mass, without a range

  // not observable by calibration, 1 sigma
  double force_bias_sigma_m_s2 = 0.03;    // across the vertical: not visible to levelling [D]
  double start_position_sigma_m = 0.001;  // horizontal: its place is the origin
  double start_velocity_sigma_m_s = 0.001;
  double start_heading_sigma_rad = 1e-4;          // it defines the axes of N
  double standing_sigma_m_s = 0.01;               // velocity of a standing vehicle: it trembles [D]
  double standing_sigma_rad_s = 0.004 * kDegree;  // mean rate of it in a frame [D]
  double standing_sigma_m_s2 = 0.005;             // its mean acceleration in a frame [D]
  double standing_sigma_rad = 0.02 * kDegree;  // what it turns while fans lift it from its legs [D]

  Stand stand;
  double gravity_m_s2 = kGravity_m_s2;  // where the vehicle flies
};

// A sentence on what to change, or nullptr when the numbers are usable.
const char* check(const NavigationParameters& parameters) noexcept;

}  // namespace lss::gnc::talaris
