// What lss-ros makes of each vehicle's telemetry, and commands of velocities.

#include "tools/lss-ros/converter.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "idl/ardito/commands.h"
#include "idl/zebro/commands.h"
#include "tools/lss-cli/session/vehicle.h"
#include "tools/lss-cli/session/wire.h"

namespace lss::ros {
namespace {

constexpr double kQuarterTurn_rad = std::numbers::pi / 2;

struct Heard {
  explicit Heard(const char* vehicle)
      : converter(*cli::find_vehicle(vehicle), std::string(vehicle) + "-1",
                  [this](std::size_t channel, const Message& message) {
                    last.insert_or_assign(converter.channels()[channel].topic, message);
                  }) {}
  void begin(lss_State state = lss_STATE_OPERATIONAL) {
    lss_Status status{};
    status.state = state;
    status.utc_ns = 1'700'000'000'000'000'000;
    converter.status(status, nullptr);
  }
  template <class M>
  const M& get(const std::string& topic) {
    return std::get<M>(last.at(topic));
  }
  std::map<std::string, Message> last;
  Converter converter;
};

// Telemetry by the names of its IDL; all else is zero.
class Sample {
 public:
  explicit Sample(const char* vehicle)
      : types_(cli::find_vehicle(vehicle)->idl),
        layout_(*types_.find(cli::find_vehicle(vehicle)->telemetry->m_typename)),
        cdr_(kCdrHeader + layout_.size()) {
    cdr_[1] = std::byte{1};
  }
  void set(const std::string& name, double value) {
    const cli::recording::Column& column = *layout_.find(name);
    std::byte* at = cdr_.data() + kCdrHeader + column.offset;
    const auto whole = static_cast<std::int64_t>(value);
    if (column.type->kind == cli::recording::Kind::float64)
      std::memcpy(at, &value, sizeof value);
    else
      std::memcpy(at, &whole, column.type->kind == cli::recording::Kind::int64 ? sizeof whole : 1);
  }
  void set(std::initializer_list<std::pair<const char*, double>> values) {
    for (const auto& [name, value] : values) set(name, value);
  }
  std::span<const std::byte> cdr() const { return cdr_; }

 private:
  cli::recording::Types types_;
  cli::recording::Layout layout_;
  std::vector<std::byte> cdr_;
};

const Face& face(const char* vehicle) { return *find_face(vehicle); }

TEST(Converter, names_are_those_of_ros) {
  EXPECT_EQ(ros_name("zebro-1"), "zebro_1");
  EXPECT_EQ(ros_name("7 b"), "v7_b");
}

TEST(Converter, zebro_walks_an_arc_to_the_right) {
  Heard heard("zebro");
  Sample sample("zebro");
  sample.set("time_ns", 1'000'000'000);
  heard.converter.telemetry(sample.cdr());
  EXPECT_TRUE(heard.last.empty()) << "the clock is not known";
  heard.begin();
  sample.set("modules[3].position_rad", 1.25);
  sample.set("modules[3].velocity_rad_s", -0.5);
  heard.converter.telemetry(sample.cdr());
  sample.set("distance_m", 2);
  sample.set("yaw_rad", kQuarterTurn_rad);  // clockwise: on average 45 deg to the right
  sample.set("speed_m_s", 0.01);
  heard.converter.telemetry(sample.cdr());
  const auto& odom = heard.get<nav_msgs::Odometry>("/zebro_1/odom");
  EXPECT_EQ(odom.header.frame_id, "zebro_1/odom");
  EXPECT_EQ(odom.child_frame_id, "zebro_1/base_link");
  EXPECT_EQ(odom.header.stamp.sec, 1'700'000'001);
  EXPECT_NEAR(odom.pose.pose.position.x, std::sqrt(2.0), 1e-12);
  EXPECT_NEAR(odom.pose.pose.position.y, -std::sqrt(2.0), 1e-12);
  EXPECT_NEAR(odom.pose.pose.orientation.z, -std::sqrt(0.5), 1e-12);
  EXPECT_NEAR(odom.twist.twist.linear.x, 0.01, 1e-12);
  const auto& joints = heard.get<sensor_msgs::JointState>("/zebro_1/joint_states");
  const std::vector<std::string> names = {"LF", "RF", "LM", "RM", "LH", "RH", "panel"};
  EXPECT_EQ(joints.name, names);
  EXPECT_EQ(joints.position[3], 1.25);
  EXPECT_EQ(joints.velocity[3], -0.5);
  const auto& tf = heard.get<tf2_msgs::TFMessage>("/tf");
  ASSERT_EQ(tf.transforms.size(), 7u) << "the body and six legs";
  EXPECT_EQ(tf.transforms[0].child_frame_id, "zebro_1/base_link");
  EXPECT_EQ(tf.transforms[4].child_frame_id, "zebro_1/RM_link");
  EXPECT_NEAR(tf.transforms[4].transform.rotation.y, std::sin(1.25 / 2), 1e-12);
  EXPECT_EQ(heard.get<tf2_msgs::TFMessage>("/tf_static").transforms.at(0).header.frame_id,
            "zebro_1/map");
}

// Both count from zero again at each start, and after a restart of the daemon.
TEST(Converter, odometry_goes_on_over_a_start_of_the_vehicle) {
  struct Case {
    const char *vehicle, *way, *topic;
  };
  for (const Case& c :
       {Case{"zebro", "distance_m", "/zebro_1/odom"}, Case{"ardito", "x_m", "/ardito_1/odom"}}) {
    SCOPED_TRACE(c.vehicle);
    Heard heard(c.vehicle);
    heard.begin();
    Sample sample(c.vehicle);
    const auto at = [&](double way_m, double clockwise_rad) {
      sample.set({{c.way, way_m}, {"yaw_rad", clockwise_rad}});
      heard.converter.telemetry(sample.cdr());
      return heard.get<nav_msgs::Odometry>(c.topic).pose.pose;
    };
    at(0, 0);
    at(2, 0);
    at(2, kQuarterTurn_rad);  // it turns to the right where it stands
    for (int start = 0; start < 2; ++start) {
      const geometry_msgs::Pose pose = at(0, 0);
      EXPECT_NEAR(pose.position.x, 2, 1e-12);
      EXPECT_NEAR(pose.position.y, 0, 1e-12);
      EXPECT_NEAR(pose.orientation.z, -std::sqrt(0.5), 1e-12);
    }
    const geometry_msgs::Pose pose = at(1, 0);
    EXPECT_NEAR(pose.position.x, 2, 1e-12);
    EXPECT_NEAR(pose.position.y, -1, 1e-12) << "ahead is to the right now";
    const auto& frame = heard.get<tf2_msgs::TFMessage>("/tf").transforms.at(0);
    EXPECT_NEAR(frame.transform.translation.y, -1, 1e-12);
  }
}

TEST(Converter, ardito_drives_to_its_right) {
  Heard heard("ardito");
  heard.begin();
  Sample sample("ardito");
  sample.set({{"time_ns", 1'000'000'000},
              {"wheels[1].motor_rad_s", 2},
              {"wheels[1].target_rad_s", 9},
              {"steering[0].motor_rad", 0.3},
              {"x_m", 1},
              {"y_m", 0.5},
              {"yaw_rad", 0.2},
              {"ground_m_s", 0.4},
              {"measured_rad", 0.05},
              {"imu_valid", 1},
              {"imu_yaw_rate_rad_s", 0.1},
              {"beta_rad", 0.02},
              {"rho_rad[0]", 0.03},
              {"rho_rad[1]", std::nan("")}});
  heard.converter.telemetry(sample.cdr());
  sample.set("time_ns", 1'500'000'000);
  heard.converter.telemetry(sample.cdr());
  const auto& odom = heard.get<nav_msgs::Odometry>("/ardito_1/odom");
  EXPECT_EQ(odom.pose.pose.position.x, 1);
  EXPECT_EQ(odom.pose.pose.position.y, 0.5);
  EXPECT_NEAR(odom.pose.pose.orientation.z, -std::sin(0.1), 1e-12);
  EXPECT_NEAR(odom.twist.twist.linear.y, -0.4 * std::sin(0.05), 1e-12);
  EXPECT_NEAR(odom.twist.twist.angular.z, -0.1, 1e-12);
  const auto& imu = heard.get<sensor_msgs::Imu>("/ardito_1/imu/data");
  EXPECT_NEAR(imu.angular_velocity.z, -0.1, 1e-12);
  EXPECT_EQ(imu.linear_acceleration_covariance[0], -1);
  const auto& joints = heard.get<sensor_msgs::JointState>("/ardito_1/joint_states");
  const auto position = [&](const std::string& name) {
    const auto at = std::ranges::find(joints.name, name);
    return at == joints.name.end() ? std::nan("")
                                   : joints.position[std::size_t(at - joints.name.begin())];
  };
  EXPECT_NEAR(position("RF"), 1, 1e-12) << "what its encoder measured, in half a second";
  EXPECT_EQ(position("steer-LF"), 0.3);
  EXPECT_EQ(position("right_rocker"), -0.02);
  EXPECT_TRUE(std::isnan(position("right_bogie"))) << "not measured";
}

TEST(Converter, talaris_flies_ahead_and_climbs) {
  Heard heard("talaris");
  heard.begin();
  Sample sample("talaris");
  sample.set("attitude_wxyz[0]", 1);
  sample.set("position_m[0]", 2);
  sample.set("position_m[1]", 3);
  sample.set("position_m[2]", 30);
  sample.set("velocity_m_s[2]", 1.5);
  sample.set("rate_rad_s[0]", 0.1);  // about up: to the left
  sample.set("voltage_V", 24);
  heard.converter.telemetry(sample.cdr());
  const auto& odom = heard.get<nav_msgs::Odometry>("/talaris_1/odom");
  EXPECT_EQ(odom.pose.pose.position.x, 30);
  EXPECT_EQ(odom.pose.pose.position.y, -3);
  EXPECT_EQ(odom.pose.pose.position.z, 2);
  EXPECT_NEAR(odom.twist.twist.linear.x, 1.5, 1e-12);
  EXPECT_NEAR(odom.twist.twist.angular.z, 0.1, 1e-12);
  EXPECT_EQ(heard.get<sensor_msgs::BatteryState>("/talaris_1/battery_state").voltage, 24);
  EXPECT_EQ(face("talaris").command, nullptr);
}

TEST(Converter, a_silent_vehicle_and_a_refusal_are_in_the_diagnostics) {
  Heard heard("zebro");
  heard.converter.report("cmd_vel is refused: why", 5);
  heard.begin(lss_STATE_IDLE);
  auto array = heard.get<diagnostic_msgs::DiagnosticArray>("/diagnostics");
  EXPECT_EQ(array.status.front().message, "Idle");
  EXPECT_EQ(array.status.back().message, "cmd_vel is refused: why");
  EXPECT_EQ(heard.get<rcl_interfaces::Log>("/rosout").level, 30);
  heard.converter.lost(7);
  array = heard.get<diagnostic_msgs::DiagnosticArray>("/diagnostics");
  EXPECT_EQ(array.status.front().level, 3);
}

TEST(Picture, every_link_hangs_on_one_before_it) {
  for (const Face* one : faces()) {
    std::vector<std::string> known = {""};
    for (const Part& part : one->model().parts) {
      EXPECT_EQ(std::ranges::count(known, part.parent), 1) << part.joint;
      EXPECT_EQ(std::ranges::count(known, part.joint), 0) << part.joint;
      known.push_back(part.joint);
    }
    const std::string text = urdf(one->model(), "x", "x/");
    EXPECT_NE(text.find("<link name=\"x/base_link\">"), std::string::npos);
  }
}

cli::Invocation command(const char* vehicle, double ahead_m_s, double turn_rad_s) {
  return face(vehicle).command({ahead_m_s, turn_rad_s}, *cli::find_vehicle(vehicle)).value();
}

TEST(Velocity, zebro_takes_the_nearest_gait_and_turns_the_right_way) {
  const cli::Invocation high = command("zebro", 0.2, 0);
  EXPECT_STREQ(high.info->name, "walk");
  EXPECT_EQ(high.parameter[0], 1);
  EXPECT_EQ(high.parameter[1], 0);
  EXPECT_EQ(high.parameter[2], 3);
  EXPECT_EQ(command("zebro", 0.002, 0).parameter[2], 1);
  EXPECT_EQ(command("zebro", -0.005, 0).parameter[0], 0);
  EXPECT_NEAR(command("zebro", 0, -1).parameter[1], kQuarterTurn_rad, 0.02)
      << "clockwise on the spot";
  EXPECT_LT(command("zebro", 0.01, 0.1).parameter[1], 0) << "anticlockwise";
  EXPECT_GT(command("zebro", -0.01, 0.1).parameter[1], 0) << "backward, both sides turn around";
}

TEST(Velocity, ardito_drives_arcs_and_turns_on_the_spot) {
  const cli::Invocation straight = command("ardito", 0.3, 0);
  EXPECT_STREQ(straight.info->name, "drive");
  EXPECT_NEAR(straight.parameter[0], 0.3, 1e-9);
  EXPECT_EQ(straight.parameter[1], 0);
  // A radius of 2 m to the left: sin(heading) = f / r.
  EXPECT_NEAR(command("ardito", 0.4, 0.2).parameter[1], -std::asin(0.07 / 2), 0.002);
  EXPECT_GT(command("ardito", -0.4, 0.2).parameter[1], 0) << "backward, the same turn";
  EXPECT_NEAR(command("ardito", 0.1, 5).parameter[1], -ardito::kMaxHeading_rad, 1e-9);
  const cli::Invocation park = command("ardito", 0, -0.1);
  EXPECT_STREQ(park.info->name, "park");
  EXPECT_NEAR(park.parameter[0], 0.34, 1e-9) << "to the right, 0.1 rad/s";
  EXPECT_NEAR(command("ardito", 9, 0).parameter[0], 1, 1e-9) << "its range";
}

}  // namespace
}  // namespace lss::ros
