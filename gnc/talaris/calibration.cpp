#include "gnc/talaris/calibration.h"

#include <algorithm>
#include <cmath>

#include "gnc/math.h"

namespace lss::gnc::talaris {
namespace {

constexpr int kEnough = 8;      // samples of a frame that make a mean
constexpr double kBegun_s = 1;  // movement before this collected time is no restart
// Of the samples: with more it sends at another rate, and its packets make shorter frames.
constexpr double kMostSamples = 1.1;

double largest(const Vector3& v) noexcept { return v.cwiseAbs().maxCoeff(); }

// False for values that are not numbers, too.
bool within(const Vector3& v, double limit) noexcept {
  return std::abs(v.x()) <= limit && std::abs(v.y()) <= limit && std::abs(v.z()) <= limit;
}

double spread(const Vector3& square, int count) noexcept {
  return std::sqrt(square.maxCoeff() / (count - 1));
}

}  // namespace

bool usable(const ImuSample& s, const NavigationParameters& p) noexcept {
  return within(s.rate_B_rad_s, p.max_rate_rad_s) && within(s.force_B_m_s2, p.max_force_m_s2);
}

bool usable(const RangeSample& s, const NavigationParameters& p) noexcept {
  return s.range_m >= p.range_min_m && s.range_m <= p.range_max_m;
}

const char* describe(CalibrationFault fault) noexcept {
  constexpr const char* kTexts[] = {
      // in the order of CalibrationFault
      "no fault",
      "the vehicle turns (rad/s)",
      "the rate swings (rad/s)",
      "the vehicle is pushed (m/s2)",
      "the specific force swings (m/s2)",
      "the mean rate is no bias: it turns, or a gyroscope is broken (rad/s)",
      "the mean specific force is not gravity (m/s2)",
      "the vehicle does not stand upright (rad)",
      "too few samples of the IMU, or too many (share that came)",
      "too few readings of the altimeter (count)",
      "the readings of the altimeter scatter (m)"};
  return kTexts[static_cast<std::size_t>(fault)];
}

void Calibration::Mean::add(const ImuSample& s) noexcept {
  ++count;
  const Vector3 dr = s.rate_B_rad_s - rate, df = s.force_B_m_s2 - force;
  rate += dr / count;
  force += df / count;
  rate_square += dr.cwiseProduct(s.rate_B_rad_s - rate);
  force_square += df.cwiseProduct(s.force_B_m_s2 - force);
}

void Calibration::Mean::add(const Mean& other) noexcept {
  count += other.count;
  const double share = static_cast<double>(other.count) / count;
  rate += share * (other.rate - rate);
  force += share * (other.force - force);
}

void Calibration::begin() noexcept {
  *this = {};
  status_.phase = CalibrationPhase::running;
}

void Calibration::start_over() noexcept {
  mean_ = {};
  ranges_ = 0;
  begun_ = false;
  status_.progress = 0;
}

void Calibration::fail(CalibrationFault fault, double measured, double limit) noexcept {
  status_.phase = CalibrationPhase::failed;
  status_.fault = fault;
  status_.measured = measured;
  status_.limit = limit;
}

void Calibration::moved(CalibrationFault fault, double measured, double limit,
                        const NavigationParameters& p) noexcept {
  const bool collected = begun_ && in_seconds(last_ns_ - first_ns_) >= kBegun_s;
  if (collected && status_.restarts >= p.calibration_restarts) {
    fail(fault, measured, limit);
    return;
  }
  if (collected) ++status_.restarts;
  start_over();
  status_.fault = fault;
  status_.measured = measured;
  status_.limit = limit;
}

// Reports the first movement in the frame.
bool Calibration::still(const Mean& frame, const NavigationParameters& p) noexcept {
  if (frame.count < kEnough) return true;
  struct Check {
    CalibrationFault fault;
    double measured, limit;
  };
  const bool known = mean_.count >= kEnough;
  const Check checks[] = {
      {CalibrationFault::rate_spread, spread(frame.rate_square, frame.count), p.rate_spread_rad_s},
      {CalibrationFault::force_spread, spread(frame.force_square, frame.count),
       p.force_spread_m_s2},
      {CalibrationFault::turning, known ? largest(frame.rate - mean_.rate) : 0, p.still_rate_rad_s},
      {CalibrationFault::shaking, known ? largest(frame.force - mean_.force) : 0,
       p.still_force_m_s2},
  };
  for (const Check& c : checks) {
    if (c.measured <= c.limit) continue;
    moved(c.fault, c.measured, c.limit, p);
    return false;
  }
  return true;
}

void Calibration::collect(const Batch& batch, const Mean& frame, std::int64_t first_ns,
                          const NavigationParameters& p) noexcept {
  if (!begun_ && frame.count > 0) {
    begun_ = true;
    first_ns_ = first_ns;
  }
  if (frame.count > 0) mean_.add(frame);
  for (const RangeSample& r : batch.ranges) {
    if (begun_ && usable(r, p) && ranges_ < kMaxRanges) range_m_[ranges_++] = r.range_m;
  }
}

const CalibrationStatus& Calibration::step(const Batch& batch,
                                           const NavigationParameters& p) noexcept {
  if (status_.phase != CalibrationPhase::running) return status_;
  if (!called_) {
    called_ = true;
    called_ns_ = batch.end_ns;
  }
  Mean frame;
  std::int64_t first_ns = 0;
  for (const ImuSample& s : batch.imu) {
    if (!usable(s, p) || (heard_ && s.time_ns <= last_ns_)) continue;
    if (in_seconds(s.time_ns - batch.end_ns) > p.imu_period_s) continue;  // from the future
    if (frame.count == 0) first_ns = s.time_ns;
    frame.add(s);
    last_ns_ = s.time_ns;
    heard_ = true;
  }
  if (still(frame, p)) collect(batch, frame, first_ns, p);
  if (status_.phase != CalibrationPhase::running) return status_;

  const double spent_s = in_seconds(batch.end_ns - called_ns_);
  const double collected_s = begun_ ? in_seconds(batch.end_ns - first_ns_) : 0;
  status_.progress = std::clamp(collected_s / p.calibration_s, 0.0, 1.0);
  if (collected_s >= p.calibration_s) {
    finish(collected_s, p);
  } else if (spent_s > (2 + p.calibration_restarts) * p.calibration_s) {
    if (heard_) {
      fail(status_.fault, status_.measured, status_.limit);  // never still for long enough
    } else {
      fail(CalibrationFault::imu_silent, 0, p.min_samples);
    }
  }
  return status_;
}

void Calibration::finish(double collected_s, const NavigationParameters& p) noexcept {
  const double size = mean_.force.norm();
  const double share = mean_.count * p.imu_period_s / collected_s;
  if (share < p.min_samples) return fail(CalibrationFault::imu_silent, share, p.min_samples);
  if (share > kMostSamples) return fail(CalibrationFault::imu_silent, share, kMostSamples);
  if (largest(mean_.rate) > p.max_rate_bias_rad_s) {
    return fail(CalibrationFault::rate_bias, largest(mean_.rate), p.max_rate_bias_rad_s);
  }
  if (std::abs(size - p.gravity_m_s2) > p.max_force_error_m_s2) {
    return fail(CalibrationFault::force_size, std::abs(size - p.gravity_m_s2),
                p.max_force_error_m_s2);
  }
  const Vector3 up = mean_.force / size;
  const double tilt = math::atan2(math::hypot(up.y(), up.z()), up.x());
  if (tilt > p.max_calibration_tilt_rad) {
    return fail(CalibrationFault::tilted, tilt, p.max_calibration_tilt_rad);
  }
  if (p.altimeter) {
    if (static_cast<int>(ranges_) < p.min_ranges) {
      return fail(CalibrationFault::few_ranges, static_cast<double>(ranges_), p.min_ranges);
    }
    double* const begin = range_m_.data();
    std::sort(begin, begin + ranges_);
    const double between = range_m_[ranges_ * 3 / 4] - range_m_[ranges_ / 4];
    if (between > p.range_spread_m) {
      return fail(CalibrationFault::range_spread, between, p.range_spread_m);
    }
    result_.range_m = (range_m_[ranges_ / 2] + range_m_[(ranges_ - 1) / 2]) / 2;
  }
  result_.ranges = static_cast<int>(ranges_);
  result_.time_ns = last_ns_;
  result_.seconds = collected_s;
  result_.gyro_bias_rad_s = mean_.rate;
  result_.accelerometer_bias_m_s2 = (size - p.gravity_m_s2) * up;
  result_.up_B = up;
  // the shortest turn that brings `up` to x, then the heading
  Quaternion level(1 + up.x(), 0, up.z(), -up.y());
  level.normalize();
  const Quaternion heading(math::cos(p.roll_rad / 2), math::sin(p.roll_rad / 2), 0, 0);
  result_.q_NB = heading * level;
  status_.phase = CalibrationPhase::done;
  status_.progress = 1;
}

}  // namespace lss::gnc::talaris
