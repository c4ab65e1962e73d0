// TALARIS' navigation for row vii: one frame of 200 ms, 40 samples of the IMU and two ranges, again
// and again with nothing in between; and the same filter written densely.

#include "daemon/runtime/clock.h"
#include "gnc/talaris/navigation.h"
#include "tests/bench/frame_mathematics.h"
#include "tests/talaris/gnc/flown.h"

namespace lss::bench {
namespace {

using namespace gnc::talaris;
using test::DenseEkf;
using test::Flown;

struct Frame {
  std::vector<ImuSample> imu;
  std::vector<RangeSample> ranges;
  std::int64_t end_ns = 0;
};

// A calibrated flight, and the sensor readings in it.
struct Recorded {
  explicit Recorded(int count, const NavigationParameters& parameters = {}) : begin(parameters) {
    Flown flown(parameters, 1);
    if (!flown.calibrate(begin)) throw std::runtime_error("TALARIS does not calibrate");
    flown.flying = true;
    for (int i = 0; i < count; ++i) {
      const Batch batch = flown.frame();
      frames.push_back({flown.imu, flown.ranges, batch.end_ns});
    }
  }
  Navigation begin;
  std::vector<Frame> frames;
};

Samples sparse_ns(const Recorded& recorded) {
  Navigation navigation = recorded.begin;
  const TimeNs begin = now_ns();
  for (const Frame& f : recorded.frames) {
    navigation.step({f.imu, f.ranges, f.end_ns});
    keep(&navigation);
  }
  const auto ns = static_cast<double>(now_ns() - begin);
  std::size_t samples = 0;
  for (const Frame& f : recorded.frames) samples += f.imu.size();
  const auto before = recorded.begin.counters().imu_used;
  if (!navigation.state().valid || navigation.counters().ranges_used < recorded.frames.size() ||
      navigation.counters().imu_used - before != samples) {
    throw std::runtime_error("TALARIS' navigation did not use what it got");
  }
  return {ns / static_cast<double>(recorded.frames.size())};
}

Samples dense_ns(const Recorded& recorded) {
  const NavigationParameters p;
  DenseEkf ekf;
  ekf.form = DenseEkf::Form::begin_of_step;
  ekf.force_noise = p.force_noise;
  ekf.rate_noise = p.rate_noise;
  ekf.force_bias_walk = p.force_bias_walk;
  ekf.rate_bias_walk = p.rate_bias_walk;
  ekf.start(recorded.begin.filter().nominal(), recorded.begin.filter().covariance());
  const TimeNs begin = now_ns();
  for (const Frame& f : recorded.frames) {
    std::size_t next = 0;
    for (const ImuSample& s : f.imu) {
      ekf.propagate(p.imu_period_s, s.rate_B_rad_s, s.force_B_m_s2);
      if (next == f.ranges.size() || f.ranges[next].time_ns > s.time_ns) continue;
      // height: h = p_x / C_xx
      const Eigen::RowVector3d row = ekf.q.toRotationMatrix().row(0);
      const double h = ekf.p.x() / row.x();
      DenseEkf::Vector derivative = DenseEkf::Vector::Zero();
      derivative(0) = 1 / row.x();
      derivative.segment<3>(6) = h / row.x() * (row * DenseEkf::skew(DenseEkf::V3::UnitX()));
      ekf.correct(derivative, f.ranges[next].range_m - h, p.range_sigma_m * p.range_sigma_m,
                  p.gate_sigma);
      ++next;
    }
    keep(&ekf);
  }
  return {static_cast<double>(now_ns() - begin) / static_cast<double>(recorded.frames.size())};
}

}  // namespace

std::function<Samples()> talaris_navigation(const Options& options) {
  return [recorded = Recorded(options.count(2'000, 100))] { return sparse_ns(recorded); };
}

double talaris_frame_us(int imu_samples, int frames) {
  NavigationParameters p;
  p.imu_period_s = test::kFrame_ns * 1e-9 / imu_samples;
  const Recorded recorded(frames, p);
  if (recorded.frames.front().imu.size() != static_cast<std::size_t>(imu_samples))
    throw std::runtime_error("a frame of TALARIS does not have the samples that it should have");
  return sparse_ns(recorded).front() * 1e-3;
}

Figure talaris_against_dense(const Options& options) {
  const Recorded recorded(options.count(500, 50));
  const Rounds rounds =
      turn_by_turn([&] { return sparse_ns(recorded); }, [&] { return dense_ns(recorded); });
  return noted(
      figure("vii", "TALARIS' Kalman filter, frame of 40 samples", "ns", rounds, median, 0.15),
      "reference: the filter with dense matrices of Eigen");
}

}  // namespace lss::bench
