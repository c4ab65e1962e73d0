#pragma once

// What is known of a ROS type besides its members. Pure data.

#include <span>
#include <string_view>

namespace lss::ros {

struct Type {
  std::string_view name;      // sensor_msgs/msg/Imu
  std::string_view dds_name;  // sensor_msgs::msg::dds_::Imu_
  std::string_view hash;      // RIHS01, hexadecimal
  std::string_view text;      // schema of a recording (encoding ros2msg)
};

std::span<const Type> types();
// One of types().
const Type& type(std::string_view name);

}  // namespace lss::ros
