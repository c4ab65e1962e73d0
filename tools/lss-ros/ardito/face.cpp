#include "tools/lss-ros/ardito/face.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "gnc/ardito/parameters.h"
#include "idl/ardito/commands.h"
#include "tools/lss-cli/session/vehicle.h"
#include "tools/lss-ros/frames.h"

namespace lss::ros::ardito {
namespace {

// The wheels' axles below the rockers' axis, as in the simulator (Ardito thesis 13.4).
constexpr double kAxleDown_m = 0.375;
constexpr double kLeastAhead_m_s = 0.005;  // slower, with a turn: on the spot
constexpr double kWheelWidth_m = 0.1;

Model model() {
  const gnc::ardito::Geometry g;
  Model model;
  model.base = {{Shape::Kind::box, {0.7, 0.5, 0.12}, {-0.05, 0, 0}}};
  const std::vector<Shape> wheel = {{Shape::Kind::cylinder, {g.wheel_radius_m, kWheelWidth_m, 0}}};
  for (int side = 0; side < 2; ++side) {
    const double y_m = side == 0 ? g.a_m / 2 : -g.a_m / 2;
    const std::string rocker = side == 0 ? "left_rocker" : "right_rocker";
    const std::string bogie = side == 0 ? "left_bogie" : "right_bogie";
    const Vector3 lifting = {0, -1, 0};
    model.parts.push_back({rocker, "", {-g.f_m, y_m, 0}, lifting});
    model.parts.push_back({bogie, rocker, {-g.l2_m, 0, -g.l3_m}, lifting});
    const double down_m = -kAxleDown_m + g.l3_m;
    const Vector3 places_m[3] = {
        {g.d_m, 0, -kAxleDown_m}, {g.l2_m, 0, down_m}, {g.l2_m - g.e_m, 0, down_m}};
    for (std::size_t axle = 0; axle < 3; ++axle) {
      const std::string name = lss::ardito::kNodeNames[2 * axle + static_cast<std::size_t>(side)];
      const std::string& carrier = axle == 0 ? rocker : bogie;
      const bool steered = axle != 1;
      if (steered) model.parts.push_back({"steer-" + name, carrier, places_m[axle], {0, 0, 1}});
      model.parts.push_back({name,
                             steered ? "steer-" + name : carrier,
                             steered ? Vector3{} : places_m[axle],
                             {0, 1, 0},
                             wheel});
    }
  }
  return model;
}

void read(const Fields& fields, Odometer& odometer, Motion& motion) {
  const double course_rad = anticlockwise(fields("measured_rad"));
  const double yaw_rad = anticlockwise(fields("yaw_rad"));
  const double rate_rad_s = anticlockwise(fields("imu_yaw_rate_rad_s"));
  odometer.set(fields("x_m"), fields("y_m"), yaw_rad);
  motion.pose = odometer.pose();
  motion.twist.linear = {fields("ground_m_s") * std::cos(course_rad),
                         fields("ground_m_s") * std::sin(course_rad), 0};
  motion.twist.angular.z = std::isnan(rate_rad_s) ? 0 : rate_rad_s;
  if (fields("imu_valid") == 1) {
    sensor_msgs::Imu& imu = motion.imu.emplace();
    imu.orientation = yawed(yaw_rad);
    imu.angular_velocity.z = rate_rad_s;
    imu.linear_acceleration_covariance[0] = -1;  // not measured
  }
  // Of the left rocker; the right one moves the opposite way (frames of the simulator).
  const double beta_rad = fields("beta_rad");
  motion.joints = {{"left_rocker", beta_rad, std::nan("")},
                   {"right_rocker", -beta_rad, std::nan("")},
                   {"left_bogie", fields("rho_rad[0]"), std::nan("")},
                   {"right_bogie", fields("rho_rad[1]"), std::nan("")}};
}

// The yaw rate of a drive is v sin(heading) / f (Ardito thesis 11.2.5), of a turn on the spot the
// speed over parking_length_m (E10).
tl::expected<cli::Invocation, std::string> command(const Velocity& wanted,
                                                   const cli::Vehicle& vehicle) {
  const gnc::ardito::Parameters nominal;
  const auto limited = [](double value, const ParameterInfo& range, double step) {
    return std::clamp(std::round(value / step) * step, range.min, range.max);
  };
  constexpr double kStep_m_s = 0.01, kStep_rad = 0.1 * kDegree;
  const double turn_rad_s = anticlockwise(wanted.turn_rad_s);
  if (std::abs(wanted.ahead_m_s) < kLeastAhead_m_s) {
    cli::Invocation park{&cli::find_command(vehicle, "park"), {}};
    park.parameter[0] =
        limited(turn_rad_s * nominal.parking_length_m, park.info->parameters[0], kStep_m_s);
    return park;
  }
  cli::Invocation drive{&cli::find_command(vehicle, "drive"), {}};
  for (std::size_t i = 2; i < drive.info->parameters.size(); ++i)
    drive.parameter[i] = drive.info->parameters[i].fallback;
  const double sine = turn_rad_s / wanted.ahead_m_s * nominal.geometry.f_m;
  const double heading_rad = std::asin(std::clamp(sine, -1.0, 1.0));
  drive.parameter[0] = limited(wanted.ahead_m_s, drive.info->parameters[0], kStep_m_s);
  drive.parameter[1] = limited(heading_rad, drive.info->parameters[1], kStep_rad);
  return drive;
}

}  // namespace

const Face kFace = {.vehicle = "ardito",
                    .has_imu = true,
                    .has_pose = true,
                    .model = model,
                    .read = read,
                    .command = command};

}  // namespace lss::ros::ardito
