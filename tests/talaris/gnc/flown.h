#pragma once

// A vehicle that stands and then flies on an ideal path, and what its IMU and altimeter say of it,
// with the noise, biases and quantisation of the real ones. No dynamics: the motion is given, and
// the truth is integrated as the filter integrates.

#include <cmath>
#include <random>
#include <vector>

#include "gnc/talaris/navigation.h"
#include "tests/talaris/gnc/dense_ekf.h"

namespace lss::gnc::talaris::test {

inline constexpr std::int64_t kFrame_ns = 200'000'000;

class Flown {
 public:
  // Noise as the parameters say it is; `seed` also chooses biases and the way it flies.
  Flown(const NavigationParameters& p, unsigned seed) : parameters(p), engine_(seed) {
    period_ns = static_cast<std::int64_t>(std::llround(p.imu_period_s * 1e9));
    for (double& f : phase_) f = std::uniform_real_distribution<double>(0, 6.28)(engine_);
    const Vector3 tilt(0, normal(0.02), normal(0.02));
    truth.q = exponential(tilt);
    truth.q = DenseEkf::exponential(Vector3(p.roll_rad + normal(p.start_heading_sigma_rad), 0, 0)) *
              truth.q;
    truth.p = Vector3(p.pointing == Pointing::down ? 1.2 : p.height_m, 0, 0) +
              vector(p.start_position_sigma_m);
    truth.v.setZero();
    truth.gravity = p.gravity_m_s2;
    truth.ba = vector(p.force_bias_sigma_m_s2);
    truth.bg = vector(0.1 * kDegree);
  }

  NavigationParameters parameters;
  DenseEkf truth;  // p, v, q, ba, bg
  std::int64_t now_ns = 1'000'000'000;
  std::int64_t period_ns = 0;
  std::vector<ImuSample> imu;
  std::vector<RangeSample> ranges;
  std::vector<FlowSample> flows;  // with a camera
  std::vector<RangeSample> corners;
  double slope = 0;                     // of the ground, along z
  std::array<double, 5> range_off_m{};  // of the altimeter in the middle, and of the corners
  double wall_m = 8;                    // distance of the wall from the origin, pointing sideways
  double ground_m = 0;
  bool quantised = true;
  bool flying = false;
  double size = 1;                     // of the motion
  Vector3 flow_off = Vector3::Zero();  // rad/s along y and z, what the camera says too much

  // The next frame; imu and ranges are its measurements.
  Batch frame() {
    imu.clear();
    ranges.clear();
    flows.clear();
    corners.clear();
    const std::int64_t end_ns = now_ns + kFrame_ns;
    while (now_ns + period_ns <= end_ns) {
      now_ns += period_ns;
      sample();
      if (now_ns >= next_range_ns_) range();
      if (parameters.camera && now_ns >= next_flow_ns_) flow();
      if (parameters.corners && now_ns >= next_corner_ns_) corner();
    }
    return batch();
  }
  Batch batch() const { return {imu, ranges, now_ns, flows, corners}; }

  double normal(double sigma) { return std::normal_distribution<double>(0, sigma)(engine_); }
  Vector3 vector(double sigma) { return {normal(sigma), normal(sigma), normal(sigma)}; }

  // Estimate minus truth as dx of the filter: the correction of the estimate.
  DenseEkf::Vector error(const Navigation& navigation) const {
    const Nominal& n = navigation.filter().nominal();
    DenseEkf x;
    x.p = n.position_N_m;
    x.v = n.velocity_N_m_s;
    x.q = n.q_NB;
    x.ba = n.accelerometer_bias_m_s2;
    x.bg = n.gyro_bias_rad_s;
    return truth.minus(x);
  }

  // Calibrates; false when that fails.
  bool calibrate(Navigation& navigation) {
    navigation.begin_calibration();
    while (navigation.calibration().phase == CalibrationPhase::running) {
      navigation.calibrate(frame());
    }
    return navigation.aligned();
  }

 private:
  void sample() {
    const double dt = static_cast<double>(period_ns) * 1e-9;
    Vector3 rate = Vector3::Zero(), acceleration = Vector3::Zero();
    if (flying) {
      t_ += dt;
      const auto wave = [&](int i, double amplitude, double w) {
        // begins at standstill: a sine's derivative with the phase only after a soft start
        const double soft = std::min(1.0, t_ / 2);
        return size * soft * amplitude * std::cos(w * t_ + phase_[i]);
      };
      rate = {wave(0, 0.3, 0.9), wave(1, 0.1, 1.7), wave(2, 0.1, 1.3)};
      acceleration = {wave(3, 0.8, 1.9), wave(4, 0.3, 1.1), wave(5, 0.5, 1.5)};
      // back towards where it was, so that it stays in the altimeter's range
      acceleration -= 0.3 * truth.v + 0.1 * (truth.p - Vector3(2.5, 0, 0));
    }
    const auto middle = truth.q * DenseEkf::exponential(rate * (dt / 2));
    const Vector3 mean_v = truth.v + acceleration * (dt / 2);
    const Vector3 mean_p = truth.p + truth.v * (dt / 2);
    const Vector3 v_B = middle.conjugate() * mean_v + rate.cross(parameters.altimeter_at_B_m);
    const Vector3 down = middle * Vector3(-Vector3::UnitX());
    const double depth =
        (ground_m - (mean_p + middle * parameters.altimeter_at_B_m).x()) / down.x();
    passed_ +=
        dt * (Vector3(0, -v_B.y() / depth + rate.z(), -v_B.z() / depth - rate.y()) + flow_off);
    const Vector3 force = middle.conjugate() * Vector3(acceleration + Vector3(truth.gravity, 0, 0));
    truth.ba += vector(parameters.force_bias_walk * std::sqrt(dt));
    truth.bg += vector(parameters.rate_bias_walk * std::sqrt(dt));
    truth.p += truth.v * dt + acceleration * (dt * dt / 2);
    truth.v += acceleration * dt;
    truth.q = (truth.q * DenseEkf::exponential(rate * dt)).normalized();

    ImuSample s;
    s.time_ns = now_ns;
    s.rate_B_rad_s = rate + truth.bg + vector(parameters.rate_noise / std::sqrt(dt));
    s.force_B_m_s2 = force + truth.ba + vector(parameters.force_noise / std::sqrt(dt));
    if (quantised) {
      s.rate_B_rad_s = rounded(s.rate_B_rad_s, 0.01 * kDegree);
      s.force_B_m_s2 = rounded(s.force_B_m_s2, 0.001 * kGravity_m_s2);
    }
    imu.push_back(s);
  }

  void range() {
    next_range_ns_ = now_ns + 97'000'000 + static_cast<std::int64_t>(engine_() % 6'000'000);
    const Vector3& at = parameters.altimeter_at_B_m;
    double r = 0;
    if (parameters.pointing == Pointing::down) {
      r = distance(at);
    } else {
      const Vector3 from = truth.p + truth.q * at, along = truth.q * Vector3::UnitZ();
      r = (wall_m - from.z()) / along.z();
    }
    ranges.push_back({now_ns, measured(r + range_off_m[0])});
  }

  // One of the four after the other.
  void corner() {
    next_corner_ns_ = now_ns + 24'000'000;
    const auto i = corner_++ % kCorners;
    const Vector3 at(parameters.corner_x_m, i < 2 ? parameters.corner_y_m : -parameters.corner_y_m,
                     i == 0 || i == 3 ? parameters.corner_z_m : -parameters.corner_z_m);
    corners.push_back(
        {now_ns, measured(distance(at) + range_off_m[i + 1]), static_cast<std::uint8_t>(i + 1)});
  }

  // Straight down to the ground.
  double distance(const Vector3& at) const {
    const Vector3 from = truth.p + truth.q * at, along = truth.q * Vector3(-Vector3::UnitX());
    return (ground_m + slope * from.z() - from.x()) / (along.x() - slope * along.z());
  }
  double measured(double r) {
    r += normal(parameters.range_sigma_m);
    return quantised ? std::round(r * 1000) / 1000 : r;
  }

  void flow() {
    const double period = parameters.flow_period_s;
    next_flow_ns_ = now_ns + static_cast<std::int64_t>(std::llround(period * 1e9));
    const double noise = parameters.flow_sigma_rad_s * period;
    flows.push_back({now_ns, passed_.y() + normal(noise), passed_.z() + normal(noise)});
    passed_.setZero();
  }

  static Vector3 rounded(const Vector3& v, double step) {
    return (v / step).array().round().matrix() * step;
  }

  std::mt19937_64 engine_;
  double phase_[6];
  double t_ = 0;
  std::int64_t next_range_ns_ = 0, next_flow_ns_ = 0, next_corner_ns_ = 0;
  std::size_t corner_ = 0;
  Vector3 passed_ = Vector3::Zero();  // the camera, since its last sample
};

}  // namespace lss::gnc::talaris::test
