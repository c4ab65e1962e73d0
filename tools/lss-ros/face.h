#pragma once

// The part of the ROS face that only a vehicle knows: its picture, its motion from the fields of
// its telemetry, and its command for a velocity. The rest is from the dictionary of its daemon. A
// vehicle is NAME/face.cpp; the roster is made from LSS_VEHICLES by CMake. All in REP-103 axes.

#include <ros_messages.h>

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <unordered_map>

#include "tools/lss-cli/recording/idl_types.h"
#include "tools/lss-cli/session/commands.h"
#include "tools/lss-ros/model.h"

namespace lss::cli {
struct Vehicle;
}

namespace lss::ros {

// A sample of telemetry by the names of its IDL: "modules[3].position_rad".
class Fields {
 public:
  Fields(std::string_view idl, std::string_view type);
  void set(std::span<const std::byte> cdr);  // which must stay; throws when it is of another type
  // NaN: there is no such number.
  double operator()(const std::string& name) const;
  std::int64_t time_ns() const;

 private:
  cli::recording::Types types_;
  cli::recording::Layout layout_;
  std::unordered_map<std::string, const cli::recording::Column*> columns_;
  std::span<const std::byte> cdr_;
};

// The place of base_link in odom. Vehicles count from zero at each start, of the vehicle and of its
// daemon; the odometer goes on from where it is.
class Odometer {
 public:
  // By a way along the body and a yaw angle.
  void add(double way_m, double anticlockwise_rad);
  // By a place and a yaw angle.
  void set(double x_m, double y_m, double anticlockwise_rad);
  geometry_msgs::Pose pose() const;

 private:
  struct Place {
    double x_m = 0, y_m = 0, yaw_rad = 0;
  };
  Place place() const;

  std::optional<double> way_m_;
  Place start_, own_;  // own: since the vehicle's start, which is at `start_`
};

struct Joint {
  std::string name;
  double position_rad, velocity_rad_s;  // NaN: not measured
};

struct Motion {
  std::optional<geometry_msgs::Pose> pose;  // base_link in odom
  geometry_msgs::Twist twist;               // of base_link, in base_link
  std::optional<sensor_msgs::Imu> imu;      // without its header
  std::optional<sensor_msgs::BatteryState> battery;
  std::vector<Joint> joints;  // besides those of the dictionary
};

// Of base_link: ahead, and anticlockwise.
struct Velocity {
  double ahead_m_s = 0, turn_rad_s = 0;
};

struct Face {
  std::string_view vehicle;
  bool has_imu = false, has_battery = false, has_pose = false;
  Model (*model)();
  void (*read)(const Fields& fields, Odometer& odometer, Motion& motion);
  // Of a velocity that is not zero. nullptr: it cannot be driven by velocity. Error: a sentence.
  tl::expected<cli::Invocation, std::string> (*command)(const Velocity& wanted,
                                                        const cli::Vehicle& vehicle) = nullptr;
};

std::span<const Face* const> faces();
// nullptr: there is none.
const Face* find_face(std::string_view vehicle);

}  // namespace lss::ros
