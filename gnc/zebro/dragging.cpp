#include "gnc/zebro/dragging.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "gnc/math.h"
#include "gnc/zebro/leg.h"

namespace lss::gnc::zebro {
namespace {

constexpr std::size_t kPoints = kLegs + 4;  // legs, and corners of the belly
constexpr double kOverhang = 1.25;          // of the belly beyond the hips
constexpr double kInside = -1e-9;
constexpr double kLeastArea_m2 = 1e-4, kSame_m = 1e-6;
constexpr double kUnloaded = 0.02;       // least weight of a point that carries
constexpr double kStickSlip_m_s = 1e-3;  // from sticking to sliding
constexpr int kRounds = 4;

// May carry: ahead and left of the centre of mass, depth of the ground there below the hips, lever
// of a roll, and how far the leg rolls ahead.
struct Point {
  double x_m = 0, y_m = 0, depth_m = 0, lever_m = 0, rolls_m = 0;
};
// Three of them that carry, with their shares of the weight.
struct Support {
  std::array<Point, 3> at{};
  std::array<double, 3> share{};
  double depth_m = -1;  // of the ground under the centre of mass
  double area_m2 = 0;
};

double cross(const Point& a, const Point& b) noexcept { return a.x_m * b.y_m - a.y_m * b.x_m; }

// Of all triples around the centre of mass the one that keeps it highest.
Support support_of(const std::array<Point, kPoints>& points) noexcept {
  Support best;
  for (std::size_t i = 0; i < kPoints; ++i) {
    for (std::size_t j = i + 1; j < kPoints; ++j) {
      for (std::size_t k = j + 1; k < kPoints; ++k) {
        const Point &a = points[i], &b = points[j], &c = points[k];
        const double on_a = cross(b, c), on_b = cross(c, a), on_c = cross(a, b);
        const double area = on_a + on_b + on_c;
        if (std::abs(area) < kLeastArea_m2) continue;
        if (on_a / area < kInside || on_b / area < kInside || on_c / area < kInside) continue;
        const double depth_m = (on_a * a.depth_m + on_b * b.depth_m + on_c * c.depth_m) / area;
        // Of as high ones the widest: four feet in a plane are usual.
        const bool higher = depth_m > best.depth_m + kSame_m,
                   wider = depth_m > best.depth_m - kSame_m && std::abs(area) > best.area_m2;
        if (!higher && !wider) continue;
        best = {{a, b, c}, {on_a / area, on_b / area, on_c / area}, depth_m, std::abs(area)};
      }
    }
  }
  return best;
}

// Slope ahead of the plane through the three.
double slope_ahead(const Support& s) noexcept {
  const auto& [a, b, c] = s.at;
  const double bx = b.x_m - a.x_m, by = b.y_m - a.y_m, cx = c.x_m - a.x_m, cy = c.y_m - a.y_m;
  return ((b.depth_m - a.depth_m) * cy - (c.depth_m - a.depth_m) * by) / (bx * cy - cx * by);
}

}  // namespace

Moved Dragging::step(const BodyShape& body, const PerLeg<double>& from_rad,
                     const PerLeg<double>& to_rad, double elapsed_s) noexcept {
  std::array<Point, kPoints> points{};
  double far_m = 0, wide_m = 0;
  for (std::size_t i = 0; i < kLegs; ++i) {
    const double d_m = body.leg_diameter_m;
    far_m = std::max(far_m, kOverhang * std::abs(body.hips.x_m[i]));
    wide_m = std::max(wide_m, std::abs(body.hips.y_m[i]));
    // Against the ground, which slopes in the frame of a body that pitches.
    const double theta_rad = wrap_rad(to_rad[i] + pitch_);
    const double offset_m = contact_offset_m(theta_rad, d_m);
    const double height_m = hip_height_m(theta_rad, d_m);
    points[i] = {.x_m = body.hips.x_m[i] + offset_m,
                 .y_m = body.hips.y_m[i],
                 .depth_m = height_m + offset_m * pitch_,
                 .lever_m = height_m,
                 .rolls_m = -height_m * wrap_rad(to_rad[i] - from_rad[i])};
  }
  for (std::size_t corner = 0; corner < 4; ++corner) {
    points[kLegs + corner] = {.x_m = corner < 2 ? far_m : -far_m,
                              .y_m = corner % 2 == 0 ? wide_m : -wide_m,
                              .depth_m = body.belly_height_m,
                              .lever_m = body.belly_height_m};
  }
  const Support carries = support_of(points);
  const double pitch = slope_ahead(carries);
  const double pitched = known_ ? pitch - pitch_ : 0;
  pitch_ = pitch;
  known_ = true;

  // Dry friction: least squares of slip, weighted with load over the slip of the round before.
  std::array<double, 3> weight{};
  for (std::size_t k = 0; k < 3; ++k) weight[k] = carries.share[k] + kUnloaded;
  Moved moved;
  for (int round = 0; round < kRounds; ++round) {
    double sum = 0, x_m = 0, y_m = 0, rolls_m = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      const Point& p = carries.at[k];
      sum += weight[k];
      x_m += weight[k] * p.x_m;
      y_m += weight[k] * p.y_m;
      rolls_m += weight[k] * (p.rolls_m - p.lever_m * pitched);
    }
    double moment = 0, inertia = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      const Point& p = carries.at[k];
      const double dx_m = p.x_m - x_m / sum, dy_m = p.y_m - y_m / sum;
      moment -= weight[k] * dy_m * (p.rolls_m - p.lever_m * pitched);
      inertia += weight[k] * (dx_m * dx_m + dy_m * dy_m);
    }
    const double left_turn_rad = moment / inertia;
    const double ahead_m = rolls_m / sum + left_turn_rad * y_m / sum;
    const double left_m = -left_turn_rad * x_m / sum;
    for (std::size_t k = 0; k < 3; ++k) {
      const Point& p = carries.at[k];
      const double slip_m =
          math::hypot(ahead_m - left_turn_rad * p.y_m - (p.rolls_m - p.lever_m * pitched),
                      left_m + left_turn_rad * p.x_m);
      weight[k] = (carries.share[k] + kUnloaded) / (slip_m + kStickSlip_m_s * elapsed_s);
    }
    moved = {.ahead_m = ahead_m, .yaw_rad = -left_turn_rad};
  }
  return moved;
}

}  // namespace lss::gnc::zebro
