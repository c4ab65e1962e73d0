#include "tools/lss-sim/zebro/soil_robot.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

namespace lss::sim::zebro {
namespace {

// Below this speed the resistance fades out, so that what stands creeps instead of shaking.
constexpr double kCreep_m_s = 1e-5;
constexpr double kInnerStep_s = 0.001;
constexpr int kMostRounds = 12, kMostHalvings = 6;
constexpr double kGoodEnough = 1e-4;  // of the weight

std::size_t nth(int leg) { return static_cast<std::size_t>(leg); }

}  // namespace

SoilRobot::SoilRobot(const TerrainOptions& terrain, double step_s, const RobotShape& shape)
    : terrain_(terrain), shape_(shape) {
  if (terrain.rocks)
    throw std::invalid_argument("there are no stones on soil: leave out --rocks or --ground");
  steps_ = std::max(1, static_cast<int>(std::lround(step_s / kInnerStep_s)));
  step_s_ = step_s / steps_;
  const double g = terrain.gravity_m_s2;
  const soil::Soil soil = soil::in_gravity(*terrain.soil, g);
  stiffness_leg_Pa_m_ = soil::stiffness_Pa_m(soil, shape.leg_width_m);
  stiffness_belly_Pa_m_ = soil::stiffness_Pa_m(soil, shape.width_m);
  for (const soil::Patch& patch : terrain.patches) {
    const soil::Soil soft = soil::in_gravity(patch.soil, g);
    soft_.push_back({patch, soil::stiffness_Pa_m(soft, shape.leg_width_m),
                     soil::stiffness_Pa_m(soft, shape.width_m)});
  }
  gravity_m_s2_ = {-g * std::sin(terrain.slope_rad), 0, -g * std::cos(terrain.slope_rad)};
  const Eigen::Array3d size_m(shape.length_m, shape.width_m, 2 * shape.hip_height_m);
  const Eigen::Array3d square = size_m.square() * (shape.mass_kg / 12);
  inertia_kg_m2_ = square.sum() - square;
  position_m_ = {0, 0, shape.hip_height_m};
  pieces_.reserve(kLegs * kPieces + kAlong * kAcross);
  const std::array<double, kLegs> angles = boot_angles(terrain);
  for (std::size_t i = 0; i < angles.size(); ++i) shafts_[i].angle_rad = angles[i];
}

void SoilRobot::step(const std::array<ShaftDrive, kLegs>& drives) {
  for (int i = 0; i < steps_; ++i) {
    turn(shafts_, drives, step_s_);
    immerse();
    move();
    feel();
  }
}

// All pieces below the surface.
void SoilRobot::immerse() {
  pieces_.clear();
  const Eigen::Matrix3d to_slope = attitude_.toRotationMatrix();
  const Eigen::Vector3d ahead = Eigen::Vector3d(to_slope(0, 0), to_slope(1, 0), 0).normalized();
  axes_ << ahead, Eigen::Vector3d::UnitZ().cross(ahead), Eigen::Vector3d::UnitZ();

  // Left of the way from toe to hip both are negative.
  const double radius_m = shape_.leg_diameter_m / 2 / shape_.leg_curvature;
  const double half_rad = std::asin(shape_.leg_curvature);
  const double to_hip = std::sqrt(1 - shape_.leg_curvature * shape_.leg_curvature);
  const double piece_m2 = 2 * half_rad * radius_m / kPieces * shape_.leg_width_m;
  for (int leg = 0; leg < kLegs; ++leg) {
    const ShaftState& shaft = shafts_[nth(leg)];
    const double sine = std::sin(shaft.angle_rad), cosine = std::cos(shaft.angle_rad);
    const Eigen::Vector3d hip_m(shape_.hip_x_m[nth(leg)], shape_.hip_y_m[nth(leg)], 0);
    if (position_m_.z() + (to_slope * hip_m).z() > shape_.leg_diameter_m) continue;
    const auto turned = [&](double x, double z) {  // down turns to the rear
      return Eigen::Vector3d(cosine * x + sine * z, 0, -sine * x + cosine * z);
    };
    for (int i = 0; i < kPieces; ++i) {
      const double around =  // from the toe to the hip
          std::numbers::pi / 2 - half_rad + 2 * half_rad * (i + 0.5) / kPieces;
      const Eigen::Vector3d normal = turned(-std::sin(around), -std::cos(around));
      const Eigen::Vector3d arm = radius_m * (normal + turned(to_hip, -shape_.leg_curvature));
      const Eigen::Vector3d turn_m_s = shaft.velocity_rad_s * Eigen::Vector3d(arm.z(), 0, -arm.x());
      immerse(leg, hip_m + arm, normal, turn_m_s, piece_m2);
    }
  }
  const double belly_m2 = shape_.length_m * shape_.width_m / (kAlong * kAcross);
  for (int i = 0; i < kAlong; ++i) {
    for (int k = 0; k < kAcross; ++k) {
      const Eigen::Vector3d at((i + 0.5) / kAlong - 0.5, (k + 0.5) / kAcross - 0.5, 0);
      immerse(-1, {at.x() * shape_.length_m, at.y() * shape_.width_m, -shape_.hip_height_m},
              -Eigen::Vector3d::UnitZ(), Eigen::Vector3d::Zero(), belly_m2);
    }
  }
}

double SoilRobot::stiffness_Pa_m(int leg, const Eigen::Vector3d& arm_B_m, double x_m) const {
  double found_Pa_m = leg < 0 ? stiffness_belly_Pa_m_ : stiffness_leg_Pa_m_;
  for (const Soft& soft : soft_) {
    const double share =
        leg < 0 ? share_of_belly(soft.patch, arm_B_m, x_m) : soft.patch.share(nth(leg), x_m);
    found_Pa_m = std::lerp(found_Pa_m, leg < 0 ? soft.belly_Pa_m : soft.leg_Pa_m, share);
  }
  return found_Pa_m;
}

double SoilRobot::share_of_belly(const soil::Patch& patch, const Eigen::Vector3d& arm_B_m,
                                 double x_m) const {
  std::size_t left = 0;  // the leg nearest on that side; the one on the other side is the next
  for (std::size_t i = 2; i < kLegs; i += 2) {
    const auto away_m = [&](std::size_t leg) {
      return std::abs(arm_B_m.x() - shape_.hip_x_m[leg]);
    };
    if (away_m(i) < away_m(left)) left = i;
  }
  const double on_left = patch.share(left, x_m), on_right = patch.share(left + 1, x_m);
  constexpr double kCentre_m = 1e-6;
  return arm_B_m.y() > kCentre_m    ? on_left
         : arm_B_m.y() < -kCentre_m ? on_right
                                    : std::min(on_left, on_right);
}

void SoilRobot::immerse(int leg, const Eigen::Vector3d& arm_B_m, const Eigen::Vector3d& normal_B,
                        const Eigen::Vector3d& turn_B_m_s, double area_m2) {
  const Eigen::Vector3d arm_m = attitude_ * arm_B_m;
  const double depth_m = -(position_m_.z() + arm_m.z());
  if (depth_m <= 0) return;
  const Eigen::Vector3d normal = attitude_ * normal_B;
  const double ahead = normal.dot(axes_.col(0)), up = normal.z();
  const double size = std::hypot(ahead, up);
  const double stiffness = stiffness_Pa_m(leg, arm_B_m, position_m_.x() + arm_m.x());
  pieces_.push_back({.leg = leg,
                     .arm_m = arm_m,
                     .turn_m_s = attitude_ * turn_B_m_s,
                     .depth_m = depth_m,
                     .strength_N = area_m2 * depth_m * stiffness,
                     .plate = soil::Plate(ahead / size, up / size)});
}

// Force and torque of the soil at this twist, and minus their derivative.
SoilRobot::Twist SoilRobot::pushes(const Twist& twist, Eigen::Matrix<double, 6, 6>* slope) {
  Twist sum = Twist::Zero();
  if (slope != nullptr) slope->setZero();
  for (Piece& piece : pieces_) {
    const Eigen::Vector3d velocity =
        axes_.transpose() * (twist.head<3>() + twist.tail<3>().cross(piece.arm_m) + piece.turn_m_s);
    const double ahead = velocity.x(), left = velocity.y(), up = velocity.z();
    const double in_plane = std::sqrt(ahead * ahead + up * up);
    const double all = std::sqrt(velocity.squaredNorm() + kCreep_m_s * kCreep_m_s);
    const soil::Plate& plate = piece.plate;
    const Eigen::Vector3d stress(
        plate.ahead_of_ahead * ahead + plate.ahead_of_up * up + plate.ahead_of_speed * in_plane,
        -soil::kDragged * left,
        plate.up_of_ahead * ahead + plate.up_of_up * up + plate.up_of_speed * in_plane);
    const double scale = piece.strength_N / all;
    piece.force_N = axes_ * (scale * stress);
    sum.head<3>() += piece.force_N;
    sum.tail<3>() += piece.arm_m.cross(piece.force_N);
    if (slope == nullptr) continue;
    const double way_ahead = in_plane > 0 ? ahead / in_plane : 0;
    const double way_up = in_plane > 0 ? up / in_plane : 0;
    Eigen::Matrix3d change;
    change << plate.ahead_of_ahead + plate.ahead_of_speed * way_ahead, 0,
        plate.ahead_of_up + plate.ahead_of_speed * way_up, 0, -soil::kDragged, 0,
        plate.up_of_ahead + plate.up_of_speed * way_ahead, 0,
        plate.up_of_up + plate.up_of_speed * way_up;
    change -= stress * velocity.transpose() / (all * all);
    const Eigen::Matrix3d hinders = -scale * axes_ * change * axes_.transpose();
    Eigen::Matrix3d arm;  // cross product with the arm
    arm << 0, -piece.arm_m.z(), piece.arm_m.y(), piece.arm_m.z(), 0, -piece.arm_m.x(),
        -piece.arm_m.y(), piece.arm_m.x(), 0;
    slope->topLeftCorner<3, 3>() += hinders;
    slope->topRightCorner<3, 3>() -= hinders * arm;
    slope->bottomLeftCorner<3, 3>() += arm * hinders;
    slope->bottomRightCorner<3, 3>() -= arm * hinders * arm;
  }
  return sum;
}

// The velocity at the end of the step that fits the forces at that velocity (implicit Euler), by
// Newton's method with shorter steps where a whole one does not help.
void SoilRobot::move() {
  const Eigen::Matrix3d to_slope = attitude_.toRotationMatrix();
  Eigen::Matrix<double, 6, 6> mass = Eigen::Matrix<double, 6, 6>::Zero();
  mass.topLeftCorner<3, 3>() = shape_.mass_kg * Eigen::Matrix3d::Identity();
  mass.bottomRightCorner<3, 3>() = to_slope * inertia_kg_m2_.asDiagonal() * to_slope.transpose();
  Twist weight = Twist::Zero();
  weight.head<3>() = shape_.mass_kg * gravity_m_s2_;
  const Eigen::Vector3d rate = twist_.tail<3>();
  weight.tail<3>() = -rate.cross(mass.bottomRightCorner<3, 3>() * rate);
  const Twist before = twist_;
  const auto lacks = [&](const Twist& twist, Eigen::Matrix<double, 6, 6>* slope) -> Twist {
    return weight + pushes(twist, slope) - mass * (twist - before) / step_s_;
  };
  const auto size = [&](const Twist& lack) {
    return lack.head<3>().norm() + lack.tail<3>().norm() / (shape_.length_m / 2);
  };
  const double good_N = kGoodEnough * weight.head<3>().norm();
  Eigen::Matrix<double, 6, 6> slope;
  Twist lack = lacks(twist_, &slope);
  for (int round = 0; round < kMostRounds && size(lack) > good_N; ++round) {
    Twist change = (slope + mass / step_s_).partialPivLu().solve(lack);
    const Twist from = twist_;
    const double last_N = size(lack);
    for (int halving = 0; halving <= kMostHalvings; ++halving) {
      twist_ = from + change;
      lack = lacks(twist_, &slope);
      if (size(lack) < last_N) break;
      change /= 2;
    }
  }
  position_m_ += twist_.head<3>() * step_s_;
  const Eigen::Vector3d turned_rad = twist_.tail<3>() * step_s_;
  const double angle_rad = turned_rad.norm();
  if (angle_rad > 0)
    attitude_ = (Eigen::AngleAxisd(angle_rad, turned_rad / angle_rad) * attitude_).normalized();
}

// The load of the gears, and how deep and how fast each leg goes through the soil.
void SoilRobot::feel() {
  for (ShaftState& shaft : shafts_) shaft.torque_Nm = 0;
  in_soil_.fill({});
  const Eigen::Vector3d axle = attitude_ * Eigen::Vector3d::UnitY();
  for (const Piece& piece : pieces_) {
    if (piece.leg < 0) continue;
    const std::size_t leg = nth(piece.leg);
    const Eigen::Vector3d hip_m =
        attitude_ * Eigen::Vector3d(shape_.hip_x_m[leg], shape_.hip_y_m[leg], 0);
    shafts_[leg].torque_Nm -= (piece.arm_m - hip_m).cross(piece.force_N).dot(axle);
    if (piece.depth_m <= in_soil_[leg].sinkage_m) continue;
    const Eigen::Vector3d velocity_m_s =
        twist_.head<3>() + twist_.tail<3>().cross(piece.arm_m) + piece.turn_m_s;
    in_soil_[leg] = {.sinkage_m = piece.depth_m, .slip_m_s = -velocity_m_s.dot(axes_.col(0))};
  }
}

BodyState SoilRobot::body() const {
  const Eigen::Quaterniond slope(Eigen::AngleAxisd(-terrain_.slope_rad, Eigen::Vector3d::UnitY()));
  return {.position_m = slope * position_m_,
          .attitude = slope * attitude_,
          .velocity_m_s = slope * twist_.head<3>()};
}

}  // namespace lss::sim::zebro
