#pragma once

// The only place where our signs and clocks become those of ROS (REP-103: x forward, y left, z up,
// angles anticlockwise seen from above; stamps in UTC). Pure functions.

#include <ros_messages.h>

#include <cmath>
#include <cstdint>

namespace lss::ros {

// Our headings, yaw angles and yaw rates are clockwise.
constexpr double anticlockwise(double clockwise) { return -clockwise; }

inline geometry_msgs::Quaternion turned(const geometry_msgs::Vector3& axis, double angle_rad) {
  const double s = std::sin(angle_rad / 2);
  return {axis.x * s, axis.y * s, axis.z * s, std::cos(angle_rad / 2)};
}
inline geometry_msgs::Quaternion yawed(double anticlockwise_rad) {
  return turned({0, 0, 1}, anticlockwise_rad);
}

// Of a body with x up, z forward and y completing right-handed, thus to the right.
constexpr geometry_msgs::Vector3 from_x_up(double x, double y, double z) { return {z, -y, x}; }
// The attitude between two frames of this kind.
constexpr geometry_msgs::Quaternion attitude_from_x_up(double w, double x, double y, double z) {
  return {z, -y, x, w};
}

// A vector of the rotated frame in the frame that q comes from.
inline geometry_msgs::Vector3 rotated(const geometry_msgs::Quaternion& q,
                                      const geometry_msgs::Vector3& v) {
  const geometry_msgs::Vector3 t = {2 * (q.y * v.z - q.z * v.y), 2 * (q.z * v.x - q.x * v.z),
                                    2 * (q.x * v.y - q.y * v.x)};
  return {v.x + q.w * t.x + q.y * t.z - q.z * t.y, v.y + q.w * t.y + q.z * t.x - q.x * t.z,
          v.z + q.w * t.z + q.x * t.y - q.y * t.x};
}
constexpr geometry_msgs::Quaternion inverse(const geometry_msgs::Quaternion& q) {
  return {-q.x, -q.y, -q.z, q.w};
}

constexpr builtin_interfaces::Time stamp(std::int64_t utc_ns) {
  constexpr std::int64_t kSecond_ns = 1'000'000'000;
  std::int64_t rest_ns = utc_ns % kSecond_ns;
  if (rest_ns < 0) rest_ns += kSecond_ns;
  return {static_cast<std::int32_t>((utc_ns - rest_ns) / kSecond_ns),
          static_cast<std::uint32_t>(rest_ns)};
}

// The daemon's monotonic clock in UTC, by its status, which has both.
class UtcClock {
 public:
  void set(std::int64_t monotonic_ns, std::int64_t utc_ns) {
    ahead_ns_ = utc_ns - monotonic_ns;
    known_ = true;
  }
  bool known() const { return known_; }
  std::int64_t utc_ns(std::int64_t monotonic_ns) const { return monotonic_ns + ahead_ns_; }

 private:
  std::int64_t ahead_ns_ = 0;
  bool known_ = false;
};

}  // namespace lss::ros
