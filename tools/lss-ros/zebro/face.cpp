#include "tools/lss-ros/zebro/face.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "idl/zebro/commands.h"
#include "tools/lss-cli/session/vehicle.h"
#include "tools/lss-ros/frames.h"
#include "tools/lss-sim/zebro/plant.h"

namespace lss::ros::zebro {
namespace {

using namespace sim::zebro;

// Of the gaits of the configuration as shipped (docs/gait-zebro.md), zero to high.
constexpr double kSpeeds_m_s[] = {0, 0.0022, 0.0053, 0.0101};
constexpr double kTrack_m = 0.130;  // of turning: [zebro.body] track_mm

// A half circle of spheres, as in the simulator.
std::vector<Shape> leg() {
  constexpr int kSpheres = 10;
  constexpr double kRadius_m = kLegDiameter_m / 2, kInside_m = kRadius_m - kTread_m;
  std::vector<Shape> shapes;
  for (int i = 0; i < kSpheres; ++i) {
    const double around = std::numbers::pi * i / (kSpheres - 1);
    shapes.push_back(
        {Shape::Kind::sphere,
         {kTread_m, 0, 0},
         {-kInside_m * std::sin(around), 0, -kRadius_m - kInside_m * std::cos(around)}});
  }
  return shapes;
}

Model model() {
  Model model;
  model.base = {{Shape::Kind::box, {kBodyLength_m, kBodyWidth_m, 2 * kHipHeightLying_m}}};
  for (int i = 0; i < sim::zebro::kLegs; ++i)
    model.parts.push_back(
        {lss::zebro::kModuleNames[i], "", {kHipX_m[i], kHipY_m[i], 0}, {0, 1, 0}, leg()});
  return model;
}

void read(const Fields& fields, Odometer& odometer, Motion& motion) {
  odometer.add(fields("distance_m"), anticlockwise(fields("yaw_rad")));
  motion.pose = odometer.pose();
  motion.twist.linear.x = fields("speed_m_s");
}

// Both sides' speeds give the heading; the gait whose speed is nearest is taken.
tl::expected<cli::Invocation, std::string> command(const Velocity& wanted,
                                                   const cli::Vehicle& vehicle) {
  const double turn_m_s = anticlockwise(wanted.turn_rad_s) * kTrack_m / 2;
  const bool forward = wanted.ahead_m_s >= 0;
  const double speed_m_s = std::abs(wanted.ahead_m_s) + std::abs(turn_m_s);  // of the faster side
  // Backward, both sides change their signs: the same turn is the opposite heading.
  const double heading_rad = std::atan2(forward ? turn_m_s : -turn_m_s, std::abs(wanted.ahead_m_s));
  int gait = 1;
  for (int i = 2; i <= 3; ++i) {
    if (std::abs(kSpeeds_m_s[i] - speed_m_s) < std::abs(kSpeeds_m_s[gait] - speed_m_s)) gait = i;
  }
  cli::Invocation walk = cli::with_defaults(cli::find_command(vehicle, "walk"));
  constexpr double kStep_rad = 0.02;
  const double rounded_rad = std::round(heading_rad / kStep_rad) * kStep_rad;
  walk.parameter = {forward ? 1.0 : 0.0,
                    std::clamp(rounded_rad, -lss::zebro::kHalfPi, lss::zebro::kHalfPi),
                    static_cast<double>(gait)};
  return walk;
}

}  // namespace

const Face kFace = {
    .vehicle = "zebro", .has_pose = true, .model = model, .read = read, .command = command};

}  // namespace lss::ros::zebro
