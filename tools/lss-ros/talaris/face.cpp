#include "tools/lss-ros/talaris/face.h"

#include <cmath>

#include "tools/lss-ros/frames.h"

namespace lss::ros::talaris {
namespace {

// Of the simulator's body (tools/lss-sim/talaris/plant.cpp): it stands on four feet 0.25 m below.
Model model() {
  constexpr double kLeg_m = 0.25, kFootX_m = 0.40, kFootY_m = 0.30;
  Model model;
  model.base = {{Shape::Kind::box, {2 * kFootX_m, 2 * kFootY_m, 0.3}, {0, 0, 0.1}}};
  for (const double x_m : {-kFootX_m, kFootX_m}) {
    for (const double y_m : {-kFootY_m, kFootY_m})
      model.base.push_back(
          {Shape::Kind::box, {0.03, 0.03, kLeg_m - 0.05}, {x_m, y_m, -(kLeg_m + 0.05) / 2}});
  }
  return model;
}

void read(const Fields& fields, Odometer&, Motion& motion) {
  const auto vector = [&](const std::string& name) {
    return from_x_up(fields(name + "[0]"), fields(name + "[1]"), fields(name + "[2]"));
  };
  const geometry_msgs::Quaternion attitude =
      attitude_from_x_up(fields("attitude_wxyz[0]"), fields("attitude_wxyz[1]"),
                         fields("attitude_wxyz[2]"), fields("attitude_wxyz[3]"));
  const geometry_msgs::Vector3 place_m = vector("position_m");
  if (!std::isnan(place_m.x + place_m.y + place_m.z + attitude.w)) {
    motion.pose = {{place_m.x, place_m.y, place_m.z}, attitude};
    motion.twist = {rotated(inverse(attitude), vector("velocity_m_s")), vector("rate_rad_s")};
    sensor_msgs::Imu& imu = motion.imu.emplace();
    imu.orientation = attitude;
    imu.angular_velocity = vector("rate_rad_s");
    imu.linear_acceleration_covariance[0] = -1;  // telemetry has it without gravity
    const geometry_msgs::Vector3 sigma_rad = vector("attitude_sigma_rad");
    imu.orientation_covariance = {sigma_rad.x * sigma_rad.x, 0, 0, 0,
                                  sigma_rad.y * sigma_rad.y, 0, 0, 0,
                                  sigma_rad.z * sigma_rad.z};
  }
  sensor_msgs::BatteryState& battery = motion.battery.emplace();
  battery.voltage = static_cast<float>(fields("voltage_V"));
  battery.temperature = static_cast<float>(fields("temperature_degC"));
  battery.current = battery.charge = battery.capacity = battery.design_capacity =
      battery.percentage = std::nanf("");
  battery.present = true;
}

}  // namespace

const Face kFace = {.vehicle = "talaris",
                    .has_imu = true,
                    .has_battery = true,
                    .has_pose = true,
                    .model = model,
                    .read = read};

}  // namespace lss::ros::talaris
