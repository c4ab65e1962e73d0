#include "tools/lss-sim/zebro/kinematic.h"

#include <cmath>
#include <stdexcept>

namespace lss::sim::zebro {
namespace {

constexpr double kRadius_m = kLegDiameter_m / 2;
constexpr double kToe_m =
    kLegDiameter_m - kTread_m;  // from the hip to the middle of the toe's tread
constexpr double kTouch_m = 1e-9;
constexpr double kSteady = 0.02;         // weight of an unloaded point, for the yaw
constexpr double kStickSlip_m_s = 1e-3;  // from sticking to sliding
constexpr int kRounds = 4;
constexpr int kMostSupports = 64;  // tried in one step; three or four are usual

// The others are corners of the belly.
bool is_leg(int point) { return point < kLegs; }

std::size_t index(int point) { return static_cast<std::size_t>(point); }

double cross(double ax, double ay, double bx, double by) { return ax * by - ay * bx; }

}  // namespace

KinematicRobot::KinematicRobot(const TerrainOptions& terrain, double step_s)
    : terrain_(terrain), step_s_(step_s), grade_(std::tan(terrain.slope_rad)) {
  if (terrain.rocks)
    throw std::invalid_argument(
        "the kinematic plant has no stones: leave out --rocks, or use --plant dart");
  const std::array<double, kLegs> angles = boot_angles(terrain);
  for (std::size_t i = 0; i < angles.size(); ++i) shafts_[i].angle_rad = angles[i];
  for (int corner = 0; corner < 4; ++corner) {
    points_[index(kLegs + corner)] = {.x_m = (corner < 2 ? +1 : -1) * kBodyLength_m / 2,
                                      .y_m = (corner % 2 == 0 ? +1 : -1) * kBodyWidth_m / 2,
                                      .depth_m = kHipHeightLying_m,
                                      .roll_m = kHipHeightLying_m};
  }
  ground_.depth_m = kHipHeightLying_m;
  reach();
  settle();
  load();
}

void KinematicRobot::step(const std::array<ShaftDrive, kLegs>& drives) {
  turn(shafts_, drives, step_s_);
  roll();
  reach();
  settle();
  load();
}

// Each loaded point moves the body as it rolls, and not sideways. Where the points disagree, they
// slip with dry friction: the twist with the least sum of load times slip, by a few least-squares
// steps, each weighted by the slip of the one before.
void KinematicRobot::roll() {
  std::array<double, 3> weight{}, rolls_m_s{};
  for (std::size_t k = 0; k < 3; ++k) {
    const int point = support_[k];
    const double turns_rad_s = is_leg(point) ? shafts_[index(point)].velocity_rad_s : 0.0;
    rolls_m_s[k] = points_[index(point)].roll_m * (turns_rad_s - nose_up_rad_s_);
    weight[k] = share_[k] + kSteady;
  }
  double yaw_rad_s = 0;
  for (int round = 0; round < kRounds; ++round) {
    yaw_rad_s = twist(weight, rolls_m_s);
    for (std::size_t k = 0; k < 3; ++k) {
      const Point& p = points_[index(support_[k])];
      const double ahead_m_s = ahead_m_s_ - yaw_rad_s * p.y_m - rolls_m_s[k];
      const double left_m_s = left_m_s_ + yaw_rad_s * p.x_m;
      const double slip_m_s = std::sqrt(ahead_m_s * ahead_m_s + left_m_s * left_m_s);
      weight[k] = (share_[k] + kSteady) / (slip_m_s + kStickSlip_m_s);
      thrust_[k] =
          share_[k] * (grade_ - terrain_.friction * ahead_m_s / (slip_m_s + kStickSlip_m_s));
    }
  }
  const double middle_rad = yaw_rad_ + yaw_rad_s * step_s_ / 2;
  const double sine = std::sin(middle_rad), cosine = std::cos(middle_rad);
  x_m_ += (ahead_m_s_ * cosine - left_m_s_ * sine) * step_s_;
  y_m_ += (ahead_m_s_ * sine + left_m_s_ * cosine) * step_s_;
  yaw_rad_ += yaw_rad_s * step_s_;
}

// Least squares of slip: sets the body's speed ahead and to the left, returns its yaw rate.
double KinematicRobot::twist(const std::array<double, 3>& weight,
                             const std::array<double, 3>& rolls_m_s) {
  double sum = 0, x_m = 0, y_m = 0, ahead_m_s = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    const Point& p = points_[index(support_[k])];
    sum += weight[k];
    x_m += weight[k] * p.x_m;
    y_m += weight[k] * p.y_m;
    ahead_m_s += weight[k] * rolls_m_s[k];
  }
  x_m /= sum;
  y_m /= sum;
  ahead_m_s /= sum;
  double moment = 0, inertia = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    const Point& p = points_[index(support_[k])];
    const double dx_m = p.x_m - x_m, dy_m = p.y_m - y_m;
    moment -= weight[k] * dy_m * rolls_m_s[k];
    inertia += weight[k] * (dx_m * dx_m + dy_m * dy_m);
  }
  const double yaw_rad_s = moment / inertia;
  ahead_m_s_ = ahead_m_s + yaw_rad_s * y_m;
  left_m_s_ = -yaw_rad_s * x_m;
  return yaw_rad_s;
}

// The contact point of each leg on level ground: with the toe ahead on its arc, rolling; otherwise
// on the tread of its toe, or of its end at the hip. Exact at the pitch of the last step, linear
// about it.
void KinematicRobot::reach() {
  const double nose_up_rad = ground_.ahead;
  for (std::size_t i = 0; i < kLegs; ++i) {
    const double angle_rad = shafts_[i].angle_rad - nose_up_rad;
    const double sine = std::sin(angle_rad), cosine = std::cos(angle_rad);
    const double end_m = cosine >= 0 ? kToe_m : kTread_m;
    const bool arc = sine <= 0;
    const double down_m = arc ? kRadius_m * (1 + cosine) : kTread_m + end_m * cosine;
    const double ahead_m = arc ? -kRadius_m * sine : -end_m * sine;
    points_[i] = {.x_m = kHipX_m[i] + ahead_m,
                  .y_m = kHipY_m[i],
                  .depth_m = down_m + ahead_m * nose_up_rad,
                  .roll_m = down_m};
  }
}

// The plane through three points such that all others are above it and the weight acts between
// them: the lowest position of the body. Starting with the support of the last step, a point below
// the ground replaces one of the three, until there is none (the dual simplex method).
void KinematicRobot::settle() {
  const Ground before = ground_;
  const double load_x_m = -before.depth_m * grade_;
  if (!lie_on(support_, load_x_m)) {
    const int near = load_x_m >= 0 ? kLegs : kLegs + 2, far = load_x_m >= 0 ? kLegs + 2 : kLegs;
    lie_on({near, near + 1, far}, load_x_m);
  }
  for (int tries = 0; tries < kMostSupports; ++tries) {
    int lowest = 0;
    double most_m = kTouch_m;
    for (int i = 0; i < kPoints; ++i) {
      const double lacks_m = ground_.lacks_m(points_[index(i)]);
      if (lacks_m <= most_m) continue;
      most_m = lacks_m;
      lowest = i;
    }
    if (most_m <= kTouch_m) break;
    // The new point replaces the one whose share reaches zero first.
    const Point& a = points_[index(support_[0])];
    const Point& b = points_[index(support_[1])];
    const Point& c = points_[index(support_[2])];
    const Point& n = points_[index(lowest)];
    const double area = cross(b.x_m - a.x_m, b.y_m - a.y_m, c.x_m - a.x_m, c.y_m - a.y_m);
    std::array<double, 3> part{};
    part[1] = cross(n.x_m - a.x_m, n.y_m - a.y_m, c.x_m - a.x_m, c.y_m - a.y_m) / area;
    part[2] = cross(b.x_m - a.x_m, b.y_m - a.y_m, n.x_m - a.x_m, n.y_m - a.y_m) / area;
    part[0] = 1 - part[1] - part[2];
    std::size_t leaves = 0;
    double least = INFINITY;
    for (std::size_t k = 0; k < 3; ++k) {
      if (part[k] <= 1e-12 || share_[k] / part[k] >= least) continue;
      least = share_[k] / part[k];
      leaves = k;
    }
    Support next = support_;
    next[leaves] = lowest;
    if (!lie_on(next, load_x_m)) break;
  }
  up_m_s_ = (ground_.depth_m - before.depth_m) / step_s_;
  nose_up_rad_s_ = (ground_.ahead - before.ahead) / step_s_;
}

// False without a change: the points are in a line, or the weight acts outside.
bool KinematicRobot::lie_on(const Support& support, double load_x_m) {
  const Point& a = points_[index(support[0])];
  const Point& b = points_[index(support[1])];
  const Point& c = points_[index(support[2])];
  const double bx = b.x_m - a.x_m, by = b.y_m - a.y_m, cx = c.x_m - a.x_m, cy = c.y_m - a.y_m;
  const double area = cross(bx, by, cx, cy);
  if (std::abs(area) < 1e-6) return false;
  const double lx = load_x_m - a.x_m, ly = -a.y_m;
  const double on_b = cross(lx, ly, cx, cy) / area, on_c = cross(bx, by, lx, ly) / area;
  const double on_a = 1 - on_b - on_c;
  if (on_a < -1e-9 || on_b < -1e-9 || on_c < -1e-9) return false;
  support_ = support;
  share_ = {on_a, on_b, on_c};
  const double db = b.depth_m - a.depth_m, dc = c.depth_m - a.depth_m;
  ground_.ahead = (db * cy - dc * by) / area;
  ground_.left = (bx * dc - cx * db) / area;
  ground_.depth_m = a.depth_m - ground_.ahead * a.x_m - ground_.left * a.y_m;
  return true;
}

// The load of the gears: the weight on a leg with the lever from hip to contact, and the push of
// the ground ahead with the depth as lever.
void KinematicRobot::load() {
  const double weight_N = kMass_kg * terrain_.gravity_m_s2 * std::cos(terrain_.slope_rad);
  for (ShaftState& shaft : shafts_) shaft.torque_Nm = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    if (!is_leg(support_[k])) continue;
    const std::size_t leg = index(support_[k]);
    const Point& p = points_[leg];
    shafts_[leg].torque_Nm =
        weight_N * (share_[k] * (p.x_m - kHipX_m[leg]) + thrust_[k] * p.roll_m);
  }
}

BodyState KinematicRobot::body() const {
  const auto turn = [](double angle_rad, const Eigen::Vector3d& axis) {
    return Eigen::AngleAxisd(angle_rad, axis);
  };
  const Eigen::Vector3d x = Eigen::Vector3d::UnitX(), y = Eigen::Vector3d::UnitY(),
                        z = Eigen::Vector3d::UnitZ();
  const Eigen::Quaterniond slope(turn(-terrain_.slope_rad, y)), heading(turn(yaw_rad_, z));
  return {.position_m = slope * Eigen::Vector3d(x_m_, y_m_, ground_.depth_m),
          .attitude = slope * heading * turn(-std::atan(ground_.ahead), y) *
                      turn(std::atan(ground_.left), x),
          .velocity_m_s = slope * heading * Eigen::Vector3d(ahead_m_s_, left_m_s_, up_m_s_)};
}

}  // namespace lss::sim::zebro
