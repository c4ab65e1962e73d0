#include "gnc/talaris/navigation.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "gnc/math.h"

namespace lss::gnc::talaris {
namespace {

constexpr std::int64_t kNever = std::numeric_limits<std::int64_t>::max();
constexpr double kAgree_s = 0.3;     // the altimeters at the corners
constexpr double kLongest_s = 0.02;  // step of dead reckoning
constexpr int kMostSteps = 200;      // bounds the time of one gap
// variance of a median relative to that of one reading, for many of them
constexpr double kMedian = 1.5707963267948966;

double square(double x) noexcept { return x * x; }

std::int64_t to_ns(double s) noexcept { return static_cast<std::int64_t>(std::llround(s * 1e9)); }

Beam beam_of(const NavigationParameters& p) noexcept {
  Beam beam;
  beam.at_B_m = p.altimeter_at_B_m;
  if (p.pointing == Pointing::sideways) {
    beam.axis = 2;
    beam.sign = -1;
    beam.direction_B = Vector3::UnitZ();
  }
  return beam;
}

}  // namespace

NavState predict(const NavState& state, double ahead_s) noexcept {
  NavState s = state;
  s.time_ns += to_ns(ahead_s);
  s.position_N_m += ahead_s * (state.velocity_N_m_s + (ahead_s / 2) * state.acceleration_N_m_s2);
  s.velocity_N_m_s += ahead_s * state.acceleration_N_m_s2;
  s.q_NB = state.q_NB * exponential(ahead_s * state.rate_B_rad_s);
  return s;
}

Navigation::Navigation(const NavigationParameters& parameters) noexcept
    : parameters_(parameters),
      beam_(beam_of(parameters)),
      least_cosine_(math::cos(parameters.max_tilt_rad)) {}

void Navigation::begin_calibration() noexcept {
  *this = Navigation(parameters_);
  calibration_.begin();
}

const CalibrationStatus& Navigation::calibrate(const Batch& batch) noexcept {
  const bool before = aligned();
  calibration_.step(batch, parameters_);
  if (aligned() && !before) {
    align();
    publish(batch.end_ns);
  }
  return calibration_.status();
}

// The filter starts from the calibration, and from what calibration cannot observe: the bias of the
// accelerometers across the vertical and the apparent tilt of it, which are correlated.
void Navigation::align() noexcept {
  const NavigationParameters& p = parameters_;
  const Alignment& a = calibration_.result();
  Nominal x;
  x.q_NB = a.q_NB;
  x.gyro_bias_rad_s = a.gyro_bias_rad_s;
  x.accelerometer_bias_m_s2 = a.accelerometer_bias_m_s2;

  Matrix15 c = Matrix15::Zero();
  c.diagonal().segment<3>(0).setConstant(square(p.start_position_sigma_m));
  c.diagonal().segment<3>(3).setConstant(square(p.start_velocity_sigma_m_s));
  c(0, 0) += p.altimeter ? 0 : square(p.range_sigma_m);
  x.position_N_m.x() = p.height_m;
  if (p.altimeter) {
    // with the position still 0, the missing part of the range along the axis
    const ExpectedRange e = expected_range(x, beam_);
    const double along = (a.range_m - e.range_m) * e.cosine;
    if (p.pointing == Pointing::down) {
      x.position_N_m.x() += along;
    } else {
      beam_.plane_m = along;
    }
    c(beam_.axis, beam_.axis) += kMedian * square(p.range_sigma_m) / a.ranges;
  }
  // of a mean over the calibration, for a bias that drifted during it
  const double noise =
      square(p.force_noise) / a.seconds + square(p.force_bias_walk) * a.seconds / 3;
  const double bias = square(p.force_bias_sigma_m_s2);
  const Matrix3 along_up = a.up_B * a.up_B.transpose();
  const Matrix3 across = Matrix3::Identity() - along_up;
  Matrix3 tilt_by_bias;  // [up x] / g
  tilt_by_bias << 0, -a.up_B.z(), a.up_B.y(), a.up_B.z(), 0, -a.up_B.x(), -a.up_B.y(), a.up_B.x(),
      0;
  tilt_by_bias /= p.gravity_m_s2;
  c.block<3, 3>(6, 6) = (bias + noise) / square(p.gravity_m_s2) * across +
                        square(p.start_heading_sigma_rad) * along_up;
  c.block<3, 3>(6, 9) = bias * tilt_by_bias;
  c.block<3, 3>(9, 6) = c.block<3, 3>(6, 9).transpose();
  c.block<3, 3>(9, 9) = bias * across + noise * along_up;
  c.diagonal().segment<3>(12).setConstant(square(p.rate_noise) / a.seconds +
                                          square(p.rate_bias_walk) * a.seconds / 3);

  ekf_ = Ekf({p.force_noise, p.rate_noise, p.force_bias_walk, p.rate_bias_walk}, p.gravity_m_s2);
  ekf_.start(x, c);
  start_ = ekf_.nominal();
  filter_ns_ = last_imu_ns_ = last_range_ns_ = a.time_ns;
  rate_m_ = a.gyro_bias_rad_s;
  force_m_ = rest_force_m_s2_ = a.up_B * p.gravity_m_s2 + a.accelerometer_bias_m_s2;
}

const NavState& Navigation::step(const Batch& batch, bool standing, bool slides) noexcept {
  if (!aligned()) return state_;
  way_ = {};
  way_.least_m_s = way_.most_m_s = ekf_.nominal().velocity_N_m_s;
  if (standing && !standing_) rest_fits_ = std::min(rest_fits_, kLeastFits);  // on other ground
  standing_ = standing;
  std::size_t next = 0, next_flow = 0, next_corner = 0;
  const auto measured = [&](std::span<const RangeSample> ranges, std::size_t i) {
    return i < ranges.size() ? measured_ns(ranges[i]) : kNever;
  };
  const auto others_until = [&](std::int64_t until_ns) {
    for (;;) {
      const std::int64_t range = measured(batch.ranges, next);
      const std::int64_t corner = measured(batch.corners, next_corner);
      const std::int64_t flow =
          next_flow < batch.flows.size() ? batch.flows[next_flow].time_ns : kNever;
      const std::int64_t first = std::min({range, corner, flow});
      if (first > until_ns) return;
      if (first == flow) {
        use_flow(batch.flows[next_flow++]);
      } else if (first == range) {
        use_range(batch.ranges[next++]);
      } else {
        use_corner(batch.corners[next_corner++]);
      }
    }
  };
  bool heard = false;
  const std::int64_t period_ns = to_ns(parameters_.imu_period_s);
  for (const ImuSample& sample : batch.imu) {
    // one from the future would make all later ones late
    if (!usable(sample, parameters_) || sample.time_ns > batch.end_ns + period_ns) {
      ++counters_.imu_bad;
      continue;
    }
    if (sample.time_ns <= last_imu_ns_ || sample.time_ns <= filter_ns_) {
      ++counters_.imu_late;
      continue;
    }
    const std::int64_t since_ns = sample.time_ns - last_imu_ns_;
    if (2 * since_ns > 3 * period_ns) {
      // the sample covers one period; the time before it is extrapolated
      ++counters_.gaps;
      counters_.longest_gap_s = std::max(counters_.longest_gap_s, in_seconds(since_ns));
      if (in_seconds(since_ns) > parameters_.hold_s) lost_ = true;
      const std::int64_t begin_ns = sample.time_ns - period_ns;
      others_until(begin_ns);
      reckon(begin_ns);
    }
    rate_m_ = sample.rate_B_rad_s;
    force_m_ = sample.force_B_m_s2;
    last_imu_ns_ = sample.time_ns;
    others_until(sample.time_ns);
    advance(sample.time_ns);
    ++counters_.imu_used;
    heard = true;
  }
  others_until(batch.end_ns);
  if (!heard) ++counters_.frames_held;
  // later ranges are after the frame: not measured yet
  counters_.ranges_bad += static_cast<std::uint32_t>(batch.ranges.size() - next);
  counters_.flows_bad += static_cast<std::uint32_t>(batch.flows.size() - next_flow);
  if (standing) stand_still(slides);
  hold_to_stand();
  publish(batch.end_ns);
  return state_;
}

std::int64_t Navigation::measured_ns(const RangeSample& sample) const noexcept {
  return sample.time_ns - to_ns(parameters_.range_latency_s);
}

// With the rate and force of the present sample.
void Navigation::advance(std::int64_t until_ns) noexcept {
  if (until_ns <= filter_ns_) return;
  const double dt = in_seconds(until_ns - filter_ns_);
  const Vector3 velocity_m_s = ekf_.nominal().velocity_N_m_s;
  ekf_.propagate(dt, rate_m_, force_m_);
  filter_ns_ = until_ns;
  way_.time_s += dt;
  way_.velocity_m_s += dt * ekf_.acceleration_N_m_s2();
  way_.turned_rad += dt * rate_m_;
  way_.force_m_s2 += dt * force_m_;
  way_.least_m_s = way_.least_m_s.cwiseMin(ekf_.nominal().velocity_N_m_s);
  way_.most_m_s = way_.most_m_s.cwiseMax(ekf_.nominal().velocity_N_m_s);
  const Vector3 rate = rate_m_ - ekf_.nominal().gyro_bias_rad_s;
  way_.foot_down_m_s = std::max(
      way_.foot_down_m_s, kFoot_m * rate.tail<2>().norm() - ekf_.nominal().velocity_N_m_s.x());
  if (!parameters_.camera) return;
  passed_.time_s += dt;
  passed_.moved_m += dt / 2 * (velocity_m_s + ekf_.nominal().velocity_N_m_s);
  passed_.turned_rad += dt * rate_m_;
}

// The same without a sample for this time: in small steps, with growing uncertainty.
void Navigation::reckon(std::int64_t until_ns) noexcept {
  if (until_ns <= filter_ns_) return;
  const double grace_s = 1.5 * parameters_.imu_period_s;
  const auto silent_s = [&](std::int64_t at_ns) {
    return std::max(0.0, in_seconds(at_ns - last_imu_ns_) - grace_s);
  };
  const double a = silent_s(filter_ns_), b = silent_s(until_ns);
  const double whole_s = in_seconds(until_ns - filter_ns_);
  const int steps =
      std::clamp(static_cast<int>(std::min(whole_s / kLongest_s, 1e6)) + 1, 1, kMostSteps);
  const std::int64_t begin_ns = filter_ns_;
  for (int i = 1; i <= steps; ++i) advance(begin_ns + (until_ns - begin_ns) * i / steps);
  if (b <= 0) return;
  const double rotation = square(parameters_.gap_rotation_rad_s2);
  const double acceleration = square(parameters_.gap_acceleration_m_s2);
  const double fourth = (square(square(b)) - square(square(a))) / 4;
  ekf_.blur(acceleration * fourth, acceleration * (square(b) - square(a)), rotation * fourth);
}

// Within the present sample, or without one.
void Navigation::come_to(std::int64_t at_ns) noexcept {
  if (at_ns <= last_imu_ns_) {
    advance(at_ns);
  } else {
    reckon(at_ns);
  }
}

void Navigation::use_range(const RangeSample& sample) noexcept {
  const NavigationParameters& p = parameters_;
  const std::int64_t at_ns = measured_ns(sample);
  const bool late =
      sample.time_ns <= last_range_ns_ || in_seconds(filter_ns_ - at_ns) > kLatestRange_s;
  if (!p.altimeter || late || !usable(sample, p)) {
    ++counters_.ranges_bad;
    return;
  }
  const double since_s = in_seconds(sample.time_ns - last_range_ns_);
  last_range_ns_ = sample.time_ns;
  come_to(at_ns);
  const double slope = p.pointing == Pointing::down ? math::tan(p.ground_slope_rad) : 0;
  blur_ground(slope, since_s);
  Ekf::Measurement m;
  const ExpectedRange e = compare(sample, beam_, m);
  if (!(e.cosine >= least_cosine_)) {
    ++counters_.ranges_bad;
    return;
  }
  if (doubted_) {
    ++counters_.ranges_gated;
    return;
  }
  m.variance = square(p.range_sigma_m) + square(slope * e.range_m) * (1 - square(e.cosine));
  const double variance = ekf_.correct(m, p.gate_sigma);
  counters_.innovation_m = m.residual;
  counters_.innovation_sigma_m = std::sqrt(variance);
  if (square(m.residual) <= square(p.gate_sigma) * variance) {
    gate_ = {};
    ++counters_.ranges_used;
    used_range_ns_ = sample.time_ns;
    if (!p.corners) return;
    compare(sample, beam_, m);
    off_m_ = m.residual;
    return;
  }
  ++counters_.ranges_gated;
  reopen(m, at_ns);
}

// The mean velocity since the sample before: the ground passes the camera, which is `depth_m` from
// it along -x of B, with (-v_y / depth + w_z, -v_z / depth - w_y).
void Navigation::use_flow(const FlowSample& sample) noexcept {
  const NavigationParameters& p = parameters_;
  come_to(sample.time_ns);
  const Passed passed = std::exchange(passed_, {});
  const Nominal& x = ekf_.nominal();
  Nominal middle = x;
  middle.position_N_m -= passed.moved_m / 2;
  const Vector3 turned_rad = passed.turned_rad - passed.time_s * x.gyro_bias_rad_s;
  middle.q_NB = x.q_NB * exponential(-turned_rad / 2);
  const ExpectedRange e = expected_range(middle, beam_);
  const bool whole = std::abs(passed.time_s - p.flow_period_s) < kFlowPeriod * p.flow_period_s;
  const double y_rad_s = sample.y_rad / passed.time_s, z_rad_s = sample.z_rad / passed.time_s;
  if (!p.camera || !whole || !(e.cosine >= least_cosine_) || !(e.range_m >= p.flow_min_m) ||
      !(e.range_m <= p.flow_max_m) || !(std::abs(y_rad_s) <= p.max_rate_rad_s) ||
      !(std::abs(z_rad_s) <= p.max_rate_rad_s)) {
    ++counters_.flows_bad;
    return;
  }
  // v_B of the origin; along x of N as the filter knows it
  const Vector3 rate_rad_s = turned_rad / passed.time_s;
  const Vector3 arm_m_s = rate_rad_s.cross(p.altimeter_at_B_m);
  const double y_m_s = e.range_m * (rate_rad_s.z() - y_rad_s) - arm_m_s.y();
  const double z_m_s = e.range_m * (-rate_rad_s.y() - z_rad_s) - arm_m_s.z();
  const Matrix3 c = middle.q_NB.toRotationMatrix();
  const Vector3 mean_m_s = passed.moved_m / passed.time_s;
  const double a = y_m_s - c(0, 1) * mean_m_s.x(), b = z_m_s - c(0, 2) * mean_m_s.x();
  const double scale = 1 / (c(1, 1) * c(2, 2) - c(2, 1) * c(1, 2));
  const Vector3 measured_m_s(mean_m_s.x(), scale * (c(2, 2) * a - c(2, 1) * b),
                             scale * (c(1, 1) * b - c(1, 2) * a));
  const Vector3 before_m_s = x.velocity_N_m_s;
  bool used = true;
  for (const int axis : {1, 2}) {
    Ekf::Measurement m;
    m.axis = axis;
    m.by_velocity = 1;
    m.by_attitude = Vector3::Unit(axis).cross(measured_m_s);
    m.residual = measured_m_s(axis) - mean_m_s(axis) - (x.velocity_N_m_s(axis) - before_m_s(axis));
    m.variance = square(e.range_m * p.flow_sigma_rad_s) +
                 square(p.flow_scale_sigma) * measured_m_s.squaredNorm();
    used = square(m.residual) <= square(p.gate_sigma) * ekf_.correct(m, p.gate_sigma) && used;
  }
  ++(used ? counters_.flows_used : counters_.flows_gated);
}

// Many readings that contradict the filter and agree with each other are right, and the filter, or
// its known ground, is wrong: its height is replaced by theirs.
void Navigation::reopen(const Ekf::Measurement& m, std::int64_t at_ns) noexcept {
  const NavigationParameters& p = parameters_;
  const double agree_m = p.gate_sigma * std::sqrt(2.0) * p.range_sigma_m;
  if (gate_.gated > 0 && std::abs(m.residual - gate_.last_m) > agree_m) gate_ = {};
  if (gate_.gated == 0) {
    gate_.first_ns = at_ns;
    gate_.first_m = m.residual;
  }
  ++gate_.gated;
  gate_.last_m = m.residual;
  if (gate_.gated < p.gate_reopens_after) return;
  if (in_seconds(at_ns - corners_agree_ns_) < kAgree_s) {
    doubted_ = true;
    gate_ = {};
    return;
  }
  const double seconds = std::max(in_seconds(at_ns - gate_.first_ns), p.imu_period_s);
  ekf_.blur_axis(m.axis, square(m.residual / m.by_position),
                 square((m.residual - gate_.first_m) / m.by_position / seconds));
  ekf_.correct(m);
  gate_ = {};
  ++counters_.gates_reopened;
}

// Standstill: velocity and rate are zero, and the vertical stays where the accelerometers have it.
void Navigation::stand_still(bool slides) noexcept {
  for (int axis = 0; axis < 3; ++axis) {
    Ekf::Measurement m;
    m.axis = axis;
    if (!slides) {
      m.by_velocity = 1;
      m.residual = -ekf_.nominal().velocity_N_m_s(axis);
      m.variance = square(parameters_.standing_sigma_m_s);
      ekf_.correct(m);
    }
    if (!(way_.time_s > 0)) continue;
    m.by_velocity = 0;
    m.by_rate_bias = 1;
    m.residual = way_.turned_rad(axis) / way_.time_s - ekf_.nominal().gyro_bias_rad_s(axis);
    m.variance =
        square(parameters_.standing_sigma_rad_s) + square(parameters_.rate_noise) / way_.time_s;
    ekf_.correct(m, parameters_.gate_sigma);
  }
  level(slides);
}

// The specific force of standstill is vertical, less its bias. While it slides it is that of
// before: else noise and bias of the gyroscopes turn the attitude of a vehicle that does not turn.
void Navigation::level(bool slides) noexcept {
  const NavigationParameters& p = parameters_;
  if (!(way_.time_s > 0)) return;
  if (!slides) rest_force_m_s2_ = way_.force_m_s2 / way_.time_s;
  for (const int axis : {1, 2}) {
    const Nominal& x = ekf_.nominal();
    const Matrix3 c = x.q_NB.toRotationMatrix();
    Ekf::Measurement m;
    m.axis = axis;
    m.by_attitude = p.gravity_m_s2 * Vector3::Unit(axis).cross(Vector3::UnitX());
    m.by_force_bias = c.row(axis).transpose();
    m.residual = m.by_force_bias.dot(rest_force_m_s2_ - x.accelerometer_bias_m_s2);
    m.variance = slides ? square(p.gravity_m_s2 * p.standing_sigma_rad)
                        : square(p.standing_sigma_m_s2) + square(p.force_noise) / way_.time_s;
    ekf_.correct(m, p.gate_sigma);
  }
  if (slides) return;
  const Nominal& x = ekf_.nominal();
  rest_force_m_s2_ = x.q_NB.conjugate() * Vector3(p.gravity_m_s2, 0, 0) + x.accelerometer_bias_m_s2;
}

void Navigation::hold_to_stand() noexcept {
  const Stand& stand = parameters_.stand;
  const bool fixed[] = {stand.fixed_x, stand.fixed_y, stand.fixed_z};
  for (int axis = 0; axis < 3; ++axis) {
    if (!fixed[axis]) continue;
    Ekf::Measurement m;
    m.axis = axis;
    m.by_position = 1;
    m.residual = start_.position_N_m(axis) - ekf_.nominal().position_N_m(axis);
    m.variance = square(stand.position_sigma_m);
    ekf_.correct(m);
    m.by_position = 0;
    m.by_velocity = 1;
    m.residual = -ekf_.nominal().velocity_N_m_s(axis);
    m.variance = square(stand.velocity_sigma_m_s);
    ekf_.correct(m);
  }
  switch (stand.rotation) {
    case FreeRotation::all: return;
    case FreeRotation::none:
      hold_axis(0, 1);
      hold_axis(0, 2);
      hold_axis(1, 2);
      return;
    case FreeRotation::x:
    case FreeRotation::y:
    case FreeRotation::z: {
      const int axis = static_cast<int>(stand.rotation) - static_cast<int>(FreeRotation::x);
      hold_axis(axis, (axis + 1) % 3);
      hold_axis(axis, (axis + 2) % 3);
      return;
    }
  }
}

// The axis of B that pointed along `axis` of N at calibration still has no `component`.
void Navigation::hold_axis(int axis, int component) noexcept {
  const Quaternion turned = ekf_.nominal().q_NB * start_.q_NB.conjugate();
  const Vector3 e = turned * Vector3::Unit(axis);
  Ekf::Measurement m;
  m.by_attitude = e.cross(Vector3::Unit(component));  // of (psi x e) in `component`
  m.residual = -e(component);
  m.variance = square(parameters_.stand.attitude_sigma_rad);
  ekf_.correct(m);
}

void Navigation::publish(std::int64_t end_ns) noexcept {
  ekf_.settle();
  const Nominal& x = ekf_.nominal();
  NavState s;
  s.time_ns = filter_ns_;
  s.position_N_m = x.position_N_m;
  s.velocity_N_m_s = x.velocity_N_m_s;
  s.q_NB = x.q_NB;
  s.rate_B_rad_s = rate_m_ - x.gyro_bias_rad_s;
  s.acceleration_N_m_s2 =
      way_.time_s > 0 ? Vector3(way_.velocity_m_s / way_.time_s) : state_.acceleration_N_m_s2;
  s.velocity_least_N_m_s = way_.least_m_s.cwiseMin(x.velocity_N_m_s);
  s.velocity_most_N_m_s = way_.most_m_s.cwiseMax(x.velocity_N_m_s);
  s.foot_down_m_s = way_.foot_down_m_s;
  s.position_sigma_m = ekf_.position_variance().cwiseMax(0).cwiseSqrt();
  s.velocity_sigma_m_s = ekf_.velocity_variance().cwiseMax(0).cwiseSqrt();
  if (counters_.flows_used > 0) {
    // an error of the camera's scale lasts: that much of the way, which the filter cannot see
    for (const int axis : {1, 2}) {
      const double way_m = x.position_N_m(axis) - start_.position_N_m(axis);
      s.position_sigma_m(axis) =
          math::hypot(s.position_sigma_m(axis), parameters_.flow_scale_sigma * way_m);
      s.velocity_sigma_m_s(axis) = math::hypot(
          s.velocity_sigma_m_s(axis), parameters_.flow_scale_sigma * x.velocity_N_m_s(axis));
    }
  }
  s.attitude_sigma_rad = ekf_.attitude_variance().cwiseMax(0).cwiseSqrt();
  s.gyro_bias_rad_s = x.gyro_bias_rad_s;
  s.accelerometer_bias_m_s2 = x.accelerometer_bias_m_s2;

  const double silent_s = in_seconds(end_ns - last_imu_ns_);
  if (silent_s > parameters_.hold_s) {
    lost_ = true;
  } else if (lost_ && s.attitude_sigma_rad.maxCoeff() <= parameters_.lost_attitude_rad) {
    lost_ = false;
  }
  state_ = predict(s, in_seconds(end_ns - filter_ns_));
  state_.time_ns = end_ns;
  state_.valid = !lost_;
}

}  // namespace lss::gnc::talaris
