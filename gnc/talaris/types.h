#pragma once

// Data between the parts of TALARIS' guidance, navigation and control.
//
// Body frame B (TALARIS thesis 2.3.1): x up, z along the horizontal thrusters, y completes
// right-handed; roll, pitch, yaw about x, y, z. Navigation frame N: the same axes where the vehicle
// stood when it was calibrated, gravity g_N = (-g, 0, 0). Attitude q_NB takes B to N. Times are
// CLOCK_MONOTONIC in nanoseconds, as data. Frames of 200 ms: GNC frame k begins at T_k, its command
// is released at T_k + offset.

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>

namespace lss::gnc::talaris {

inline constexpr double kFrame_s = 0.2;
inline constexpr double kGravity_m_s2 = 9.80665;
inline constexpr std::size_t kValves = 8;  // index i: valve i + 1
inline constexpr std::size_t kFans = 4;
inline constexpr double kFoot_m = 0.5;  // of a leg from the centre

using Vector3 = Eigen::Vector3d;
// (w, x, y, z) by Eigen's constructor; not aligned, so that plain structs can contain it.
using Quaternion = Eigen::Quaternion<double, Eigen::DontAlign>;

inline constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

// One packet of the IMU, with bias.
struct ImuSample {
  std::int64_t time_ns = 0;  // of its first byte
  Vector3 rate_B_rad_s = Vector3::Zero();
  Vector3 force_B_m_s2 = Vector3::Zero();  // specific force: at standstill (+g, 0, 0)
};

// One reading of the altimeter.
struct RangeSample {
  std::int64_t time_ns = 0;
  double range_m = kNaN;
  std::uint8_t corner = 0;  // 1 to 4: of an altimeter at a corner
};

// How far the ground passed the camera since the sample before, as the angle at the camera towards
// +y and +z of B. The turning of the vehicle is included.
struct FlowSample {
  std::int64_t time_ns = 0;  // end of that time
  double y_rad = kNaN, z_rad = kNaN;
};
// One that comes a period after another within this share of the period measures that whole time.
inline constexpr double kFlowPeriod = 0.3;

// Measurements in [T_k-1, T_k), each type in time order.
struct Batch {
  std::span<const ImuSample> imu;
  std::span<const RangeSample> ranges;
  std::int64_t end_ns = 0;  // T_k
  std::span<const FlowSample> flows{};
  std::span<const RangeSample> corners{};
};

// Direction of the altimeter (configuration).
enum class Pointing : std::uint8_t {
  down,      // along -x: height
  sideways,  // along +z, at a wall: distance
};

// Output of navigation, at Batch::end_ns.
struct NavState {
  std::int64_t time_ns = 0;
  bool valid = false;  // aligned, and the IMU is not silent
  Vector3 position_N_m = Vector3::Zero();
  Vector3 velocity_N_m_s = Vector3::Zero();
  Quaternion q_NB = Quaternion::Identity();
  Vector3 rate_B_rad_s = Vector3::Zero();         // without bias
  Vector3 acceleration_N_m_s2 = Vector3::Zero();  // mean of the frame, without gravity
  // Of the velocity in the frame, axis by axis, and of a foot's speed down: a touchdown is shorter.
  Vector3 velocity_least_N_m_s = Vector3::Zero(), velocity_most_N_m_s = Vector3::Zero();
  double foot_down_m_s = 0;
  Vector3 position_sigma_m = Vector3::Zero();
  Vector3 velocity_sigma_m_s = Vector3::Zero();
  Vector3 attitude_sigma_rad = Vector3::Zero();  // about the axes of B
  Vector3 gyro_bias_rad_s = Vector3::Zero();
  Vector3 accelerometer_bias_m_s2 = Vector3::Zero();
};

// One valve in one frame: opens `delay_s` after the release and stays open for `on_s`; on_s 0:
// shut.
struct Pulse {
  double on_s = 0;
  double delay_s = 0;
};

// Orders of control to the actuators in one frame.
struct Actuation {
  std::array<Pulse, kValves> valve{};
  std::array<double, kFans> fan_throttle{};  // 0..1
};

}  // namespace lss::gnc::talaris
