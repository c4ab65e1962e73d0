// Ranges, and four altimeters at the corners (TALARIS thesis 2.3.6). Their differences give the
// vehicle's attitude to the ground, whose slope is another one every few metres; their mean
// replaces the altimeter in the middle when that one says nothing, and overrules it when it
// contradicts four that agree. What they measure at standstill counts as zero: mounting, and the
// slope of the ground there. So they give the tilt since then, whose error is that of now less that
// of then; and that of then is the accelerometers' bias by gravity, since these gave the vertical.

#include <algorithm>
#include <cmath>
#include <utility>

#include "gnc/math.h"
#include "gnc/talaris/navigation.h"

namespace lss::gnc::talaris {
namespace {

using Signs = std::array<double, kCorners>;
constexpr Signs kAll{1, 1, 1, 1}, kAlongY{1, 1, -1, -1}, kAlongZ{1, -1, -1, 1},
    kTwist{1, -1, 1, -1};

constexpr double kTogether_s = 0.3;   // all four within this time
constexpr double kWithout_s = 0.35;   // so long without a range of the one in the middle: silent
constexpr int kRestFits = 100;        // of which the values of standstill are the mean
constexpr double kFlightFits = 150;   // that share the error of that mean
constexpr int kContradictions = 5;    // in a row
constexpr double kTwistFits = 20;     // of which the twist has a mean
constexpr double kMounting_m = 0.01;  // by which the four may be mounted apart
constexpr double kApart_m = 0.3;      // of the beams' ground, over which a slope counts
constexpr double kUneven_m = 0.1;     // the same for the twist: ground that is no plane
constexpr double kLeastWay_m = 1e-3;  // within which the slope is that of before

double squared(double x) noexcept { return x * x; }

// The sum of the four with signs, times `scale`.
Ekf::Measurement sum(const std::array<Ekf::Measurement, kCorners>& all, const Signs& signs,
                     double scale) noexcept {
  Ekf::Measurement m;
  for (std::size_t i = 0; i < kCorners; ++i) {
    const double share = signs[i] * scale;
    m.by_position += share * all[i].by_position;
    m.by_velocity += share * all[i].by_velocity;
    m.by_attitude += share * all[i].by_attitude;
    m.residual += share * all[i].residual;
  }
  return m;
}

Beam corner_beam(const NavigationParameters& p, std::size_t corner) noexcept {
  Beam beam;
  beam.at_B_m = {p.corner_x_m, kAlongY[corner] * p.corner_y_m, kAlongZ[corner] * p.corner_z_m};
  return beam;
}

}  // namespace

// Else the filter explains hills by a tilt that it does not have.
void Navigation::blur_ground(double slope, double since_s) noexcept {
  if (!(slope > 0)) return;
  const double way_m = ekf_.nominal().velocity_N_m_s.tail<2>().norm() * since_s;
  ekf_.blur_axis(beam_.axis, squared(slope) * kGroundWave_m * way_m, 0);
}

// With the state of the time when it was measured.
ExpectedRange Navigation::compare(const RangeSample& sample, const Beam& beam,
                                  Ekf::Measurement& m) const noexcept {
  const double ago_s = in_seconds(filter_ns_ - measured_ns(sample));
  Nominal then = ekf_.nominal();
  then.position_N_m -= ago_s * then.velocity_N_m_s;
  const ExpectedRange e = expected_range(then, beam);
  m.axis = beam.axis;
  m.by_position = e.by_position;
  m.by_velocity = -ago_s * e.by_position;
  m.by_attitude = e.by_attitude;
  m.residual = sample.range_m - e.range_m;
  return e;
}

void Navigation::use_corner(const RangeSample& sample) noexcept {
  const NavigationParameters& p = parameters_;
  const std::size_t corner = sample.corner - 1u;
  const std::int64_t at_ns = measured_ns(sample);
  if (!p.corners || corner >= kCorners || in_seconds(filter_ns_ - at_ns) > kLatestRange_s ||
      !(sample.range_m >= p.range_min_m) || !(sample.range_m <= p.range_max_m))
    return;
  come_to(at_ns);
  if (!(compare(sample, corner_beam(p, corner), corner_[corner]).cosine >= least_cosine_)) return;
  corner_ns_[corner] = at_ns;
  const std::int64_t oldest_ns = *std::ranges::min_element(corner_ns_);
  if (oldest_ns == 0 || in_seconds(at_ns - oldest_ns) > kTogether_s) return;
  fit_corners(at_ns);
  corner_ns_ = {};
}

// The plane through four points that leaves one of their sums over, the twist.
void Navigation::fit_corners(std::int64_t at_ns) noexcept {
  const NavigationParameters& p = parameters_;
  const double slope = math::tan(p.ground_slope_rad);
  if (standing_) learn_corners(slope);
  if (rest_fits_ < kLeastFits) {
    fitted_ns_ = at_ns;
    return;
  }
  Plane plane = corner_;
  for (std::size_t i = 0; i < kCorners; ++i) plane[i].residual -= at_rest_m_[i];
  const double twist_m = sum(plane, kTwist, 1.0 / kCorners).residual;
  twist_m_ += (twist_m - twist_m_) / kTwistFits;
  const double uneven_m = slope * kUneven_m;
  const double lasting_m = math::hypot(p.range_sigma_m / 2 / std::sqrt(kTwistFits), uneven_m / 2);
  if (std::abs(twist_m) > p.gate_sigma * math::hypot(p.range_sigma_m / 2, uneven_m) ||
      std::abs(twist_m_) > p.gate_sigma * lasting_m) {
    ++counters_.corners_gated;
    return;
  }
  ++counters_.corners_used;
  const double since_s = in_seconds(at_ns - std::exchange(fitted_ns_, at_ns));
  const double way_m =
      std::max(ekf_.nominal().velocity_N_m_s.tail<2>().norm() * since_s, kLeastWay_m);
  Ekf::Measurement height = sum(plane, kAll, 1.0 / kCorners);
  const ExpectedRange middle = expected_range(ekf_.nominal(), beam_);
  by_corners_ = {.time_ns = at_ns, .range_m = middle.range_m + height.residual};
  const bool alone = doubted_ || in_seconds(at_ns - used_range_ns_) > kWithout_s;
  // From the altimeter in the middle, not from the filter, which may be slow to follow both.
  const bool contradict = !alone && std::abs(height.residual - off_m_) > apart_m(slope);
  contradicted_ = contradict ? contradicted_ + 1 : 0;
  const bool overrules = contradicted_ >= kContradictions;
  if (overrules) doubted_ = true;
  height.variance = squared(p.range_sigma_m) / kCorners +
                    squared(slope * middle.range_m) * (1 - squared(middle.cosine));
  if (alone) blur_ground(slope, since_s);
  if (alone || overrules) use_height(height, overrules);
  use_slopes(plane, slope, way_m);
}

// Between the altimeter in the middle and the mean of the four.
double Navigation::apart_m(double slope) const noexcept {
  return parameters_.gate_sigma *
         math::hypot(parameters_.range_sigma_m * std::sqrt(1.25), slope * kApart_m);
}

// Standing: what they measure is zero, unless the four do not stand on the ground of the one in the
// middle, or that is inclined more than the ground is said to be.
void Navigation::learn_corners(double slope) noexcept {
  const NavigationParameters& p = parameters_;
  const double most_slope_m = p.gate_sigma * slope;
  const auto off = [&](const Signs& signs) {
    return std::abs(sum(corner_, signs, 1.0 / kCorners).residual);
  };
  const bool other_ground = off(kAll) > apart_m(slope) + kMounting_m ||
                            off(kTwist) > 3 * kMounting_m ||
                            off(kAlongY) > kMounting_m + most_slope_m * p.corner_y_m ||
                            off(kAlongZ) > kMounting_m + most_slope_m * p.corner_z_m;
  other_ground_ = other_ground ? other_ground_ + 1 : 0;
  uneven_ = other_ground_ >= kContradictions;
  if (uneven_) rest_fits_ = 0;
  if (other_ground) return;
  rest_fits_ = std::min(rest_fits_ + 1, kRestFits);
  for (std::size_t i = 0; i < kCorners; ++i)
    at_rest_m_[i] += (corner_[i].residual - at_rest_m_[i]) / rest_fits_;
  rest_C_ = ekf_.nominal().q_NB.toRotationMatrix();
  rest_bias_m_s2_ += (ekf_.nominal().accelerometer_bias_m_s2 - rest_bias_m_s2_) / rest_fits_;
}

// `overrules`: the altimeter in the middle, which the filter followed.
void Navigation::use_height(const Ekf::Measurement& height, bool overrules) noexcept {
  const double variance = overrules ? 0 : ekf_.correct(height, parameters_.gate_sigma);
  if (!overrules && squared(height.residual) <= squared(parameters_.gate_sigma) * variance) {
    height_gated_ = 0;
    corners_agree_ns_ = filter_ns_;
    return;
  }
  if (!overrules && ++height_gated_ < parameters_.gate_reopens_after) return;
  height_gated_ = 0;
  const double off_m2 = squared(height.residual / height.by_position);
  ekf_.blur_axis(height.axis, off_m2, off_m2);  // in about a second
  ekf_.correct(height);
}

// The slope of the ground is one measurement for each wave of it, however often it is measured.
void Navigation::use_slopes(const Plane& plane, double slope, double way_m) noexcept {
  const NavigationParameters& p = parameters_;
  const double of_ground = squared(slope) * std::max(1.0, kGroundWave_m / way_m);
  const auto use = [&](const Signs& signs, double arm_m) {
    Ekf::Measurement m = sum(plane, signs, 1 / (kCorners * arm_m));
    m.by_force_bias =
        (m.by_attitude.y() * rest_C_.row(2) - m.by_attitude.z() * rest_C_.row(1)).transpose() /
        p.gravity_m_s2;
    m.residual -= m.by_force_bias.dot(ekf_.nominal().accelerometer_bias_m_s2 - rest_bias_m_s2_);
    m.variance =
        squared(p.range_sigma_m / (2 * arm_m)) * (1 + kFlightFits / rest_fits_) + of_ground;
    ekf_.correct(m, p.gate_sigma);
  };
  use(kAlongY, p.corner_y_m);
  use(kAlongZ, p.corner_z_m);
}

}  // namespace lss::gnc::talaris
