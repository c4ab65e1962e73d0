// ROS messages: hashes, CDR, and the turn from our signs and clocks to those of ROS.

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <numbers>
#include <string>

#include "tools/lss-ros/cdr.h"
#include "tools/lss-ros/frames.h"
#include "tools/lss-ros/types.h"

namespace lss::ros {
namespace {

constexpr double kQuarter = std::numbers::pi / 2;

// As published with ROS 2 Iron and later.
TEST(RosTypes, have_the_hashes_that_ros_publishes) {
  const std::map<std::string, std::string> published = {
      {"sensor_msgs/msg/Imu", "7d9a00ff131080897a5ec7e26e315954b8eae3353c3f995c55faf71574000b5b"},
      {"sensor_msgs/msg/JointState",
       "a13ee3a330e346c9d87b5aa18d24e11690752bd33a0350f11c5882bc9179260e"},
      {"sensor_msgs/msg/BatteryState",
       "4bee5dfce981c98faa6828b868307a0a73f992ed0789f374ee96c8f840e69741"},
      {"nav_msgs/msg/Odometry", "3cc97dc7fb7502f8714462c526d369e35b603cfc34d946e3f2eda2766dfec6e0"},
      {"tf2_msgs/msg/TFMessage",
       "e369d0f05a23ae52508854b66f6aa0437f3449d652e8cbf22d5abe85d020f087"},
      {"geometry_msgs/msg/Twist",
       "9c45bf16fe0983d80e3cfe750d6835843d265a9a6c46bd2e609fcddde6fb8d2a"},
      {"geometry_msgs/msg/TwistStamped",
       "5f0fcd4f81d5d06ad9b4c4c63e3ea51b82d6ae4d0558f1d475229b1121db6f64"},
      {"diagnostic_msgs/msg/DiagnosticArray",
       "5a8a36efb05fb25070fa0fb3810290c0e6cd4862b54a8fb975a1ee8dc55a333e"},
      {"rcl_interfaces/msg/Log",
       "e28ce254ca8abc06abf92773b74602cdbf116ed34fbaf294fb9f81da9f318eac"},
      {"std_msgs/msg/String", "df668c740482bbd48fb39d76a70dfd4bd59db1288021743503259e948f6b1a18"},
      {"std_srvs/srv/Trigger_Request",
       "d010825374ce8918e72bfd826c82603e60f45419e932ea976f807b74a863a199"},
      {"std_srvs/srv/Trigger_Response",
       "2d946c21e2fc3f1e9ca6986a8191d85fcc70097a8bb7771a053564bc47009cdf"},
      {"rmw_dds_common/msg/ParticipantEntitiesInfo",
       "91a0593bacdcc50ea9bdcf849a938b128412cc1ea821245c663bcd26f83c295e"}};
  for (const auto& [name, hash] : published) EXPECT_EQ(type(name).hash, hash) << name;
  EXPECT_EQ(type("sensor_msgs/msg/Imu").dds_name, "sensor_msgs::msg::dds_::Imu_");
}

TEST(Cdr, has_the_bytes_of_the_standard) {
  const std_msgs::Header header{{1, 2}, "ab"};
  const std::vector<std::byte> bytes = to_cdr(header);
  const unsigned char expected[] = {0, 1, 0, 0, 1, 0, 0, 0, 2, 0, 0, 0, 3, 0, 0, 0, 'a', 'b', 0};
  ASSERT_EQ(bytes.size(), sizeof expected);
  EXPECT_EQ(std::memcmp(bytes.data(), expected, sizeof expected), 0);
}

TEST(Cdr, comes_back_as_it_was_and_what_is_cut_is_refused) {
  sensor_msgs::JointState state{{{5, 6}, "base"}, {"LF", "RF"}, {0.25, -1}, {3}, {}};
  const std::vector<std::byte> bytes = to_cdr(state);
  const auto back = from_cdr<sensor_msgs::JointState>(bytes);
  ASSERT_TRUE(back);
  EXPECT_EQ(back->header.frame_id, "base");
  EXPECT_EQ(back->name, state.name);
  EXPECT_EQ(back->position, state.position);
  EXPECT_EQ(back->velocity, state.velocity);
  for (std::size_t size = 0; size < bytes.size(); ++size)
    EXPECT_FALSE(from_cdr<sensor_msgs::JointState>(std::span(bytes).first(size))) << size;
  std::vector<std::byte> long_string = bytes;
  for (std::size_t i = 12; i < 16; ++i) long_string[i] = std::byte{255};
  EXPECT_FALSE(from_cdr<sensor_msgs::JointState>(long_string));
}

TEST(Frames, a_heading_to_the_right_is_a_negative_yaw) {
  const geometry_msgs::Vector3 ahead = rotated(yawed(anticlockwise(kQuarter)), {1, 0, 0});
  EXPECT_NEAR(ahead.x, 0, 1e-12);
  EXPECT_NEAR(ahead.y, -1, 1e-12);  // right
  EXPECT_NEAR(ahead.z, 0, 1e-12);
}

TEST(Frames, a_body_with_x_up_has_each_axis_where_ros_has_it) {
  const auto expect = [](geometry_msgs::Vector3 v, double x, double y, double z) {
    EXPECT_NEAR(v.x, x, 1e-12);
    EXPECT_NEAR(v.y, y, 1e-12);
    EXPECT_NEAR(v.z, z, 1e-12);
  };
  expect(from_x_up(1, 0, 0), 0, 0, 1);   // up
  expect(from_x_up(0, 1, 0), 0, -1, 0);  // right
  expect(from_x_up(0, 0, 1), 1, 0, 0);   // ahead
  // Turned by a quarter about each of our axes: q = (cos 45, sin 45 on the axis).
  const double c = std::cos(kQuarter / 2), s = std::sin(kQuarter / 2);
  expect(rotated(attitude_from_x_up(c, s, 0, 0), {1, 0, 0}), 0, 1, 0);  // about up: to the left
  expect(rotated(attitude_from_x_up(c, 0, s, 0), {1, 0, 0}), 0, 0, 1);  // about right: nose up
  expect(rotated(attitude_from_x_up(c, 0, 0, s), {0, 1, 0}), 0, 0, 1);  // about ahead: left up
}

TEST(Frames, a_rotation_and_its_inverse_cancel) {
  const geometry_msgs::Quaternion q = turned({0.6, 0, 0.8}, 0.7);
  const geometry_msgs::Vector3 v = rotated(inverse(q), rotated(q, {1, 2, 3}));
  EXPECT_NEAR(v.x, 1, 1e-12);
  EXPECT_NEAR(v.y, 2, 1e-12);
  EXPECT_NEAR(v.z, 3, 1e-12);
}

TEST(Frames, stamps_are_utc) {
  UtcClock clock;
  EXPECT_FALSE(clock.known());
  clock.set(1'000, 1'700'000'000'000'000'000);
  const builtin_interfaces::Time time = stamp(clock.utc_ns(2'500'001'000));
  EXPECT_EQ(time.sec, 1'700'000'002);
  EXPECT_EQ(time.nanosec, 500'000'000u);
  EXPECT_EQ(stamp(-1).sec, -1);
  EXPECT_EQ(stamp(-1).nanosec, 999'999'999u);
}

}  // namespace
}  // namespace lss::ros
