// TALARIS' navigation for row vii: one frame of 200 ms, 40 samples of the IMU and two ranges, again
// and again with nothing in between; the same with a second IMU and control allocation, as after
// the failure of a valve and a fan; that allocation alone; and the same filter written densely.

#include <random>

#include "daemon/runtime/clock.h"
#include "daemon/vehicles/talaris/standby_imu.h"
#include "gnc/talaris/allocation.h"
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

// What flight_failed.cpp asks in a frame, with another thrust in each.
class Allocated {
 public:
  Allocated() {
    constexpr double kValveCost = 5e-6, kFanCost = 5e-5, kFan_N = 100;
    constexpr Eigen::Index kFirstFan = 8, kShut = 2;
    problem_.effect = effect_of(Thrusters{}, Fans{});
    problem_.weight << 5e-4, 5e-5, 0.05, 1, 1;
    for (Eigen::Index i = 0; i < kActuators; ++i) {
      problem_.most[i] = i < kFirstFan ? Thrusters{}.force_N : kFan_N;
      problem_.cost[i] = i < kFirstFan ? kValveCost : kFanCost;
    }
    problem_.most[kShut] = problem_.most[kFirstFan] = 0;  // a valve stuck shut, a fan dead
  }
  // The equilibrium, the frame, and again with pulses that are possible.
  void frame(std::size_t number) {
    const double wave = static_cast<double>(number % 16) / 8 - 1;
    problem_.wanted << 420 + 40 * wave, 10 * wave, 2 * wave, 12 * wave, -8 * wave;
    for (int i = 0; i < 3; ++i) problem_.preferred = allocate(problem_).force_N;
    keep(&problem_);
  }

 private:
  AllocationProblem problem_;
};

// The problems of a frame as flight_failed.cpp asks them: the equilibrium, the frame, and again
// with pulses that are possible. Demands are like those of flights with a failed actuator.
class Failed {
 public:
  explicit Failed(Samples& us) : us_(us) {
    problem_.effect = effect_of(Thrusters{}, Fans{});
    problem_.weight << 5e-4, 5e-5, 0.05, 1, 1;
    problem_.cost.head<kFirstFan>().setConstant(5e-6);
    problem_.most.head<kFirstFan>().setConstant(Thrusters{}.force_N);
    problem_.cost.tail<kFans>().setConstant(2.5e-6);
    problem_.preferred.tail<kFans>().setConstant(110);
    problem_.most.tail<kFans>().setConstant(110);
  }
  // Stuck shut or dead; a valve may be stuck open.
  void fail(Eigen::Index actuator, bool open) {
    (open ? problem_.least : problem_.most)[actuator] = open ? Thrusters{}.force_N : 0;
  }
  void frame(std::mt19937& random) {
    const auto about = [&](double sigma) {
      return std::normal_distribution<double>(0, sigma)(random);
    };
    AllocationProblem p = problem_;
    p.wanted << 430 + about(15), about(3), about(0.5), about(0.5), about(0.5);
    p.preferred = solve(p);
    p.wanted << 260 + about(80), about(80), about(1.5), about(15), about(12);
    for (Eigen::Index i = kFirstFan; i < kActuators; ++i) {
      if (p.least[i] < p.most[i]) p.most[i] = 100;
      p.least[i] = std::min(20.0, p.most[i]);
      p.cost[i] = 5e-5;
    }
    const Forces force_N = solve(p);
    const double least_N = Thrusters{}.force_N * Thrusters{}.min_on_s / kFrame_s;
    const double most_N = Thrusters{}.force_N * Thrusters{}.max_on_s / kFrame_s;
    for (Eigen::Index i = 0; i < kFirstFan; ++i) {
      if (p.least[i] >= p.most[i]) continue;
      const bool shortest = force_N[i]<least_N, longest = force_N[i]> most_N;
      p.least[i] = longest ? Thrusters{}.force_N : shortest ? 0 : least_N;
      p.most[i] = longest ? Thrusters{}.force_N : shortest ? 0 : most_N;
    }
    solve(p);
  }

 private:
  static constexpr Eigen::Index kFirstFan = kValves;
  Forces solve(const AllocationProblem& problem) {
    const TimeNs begin = now_ns();
    const Allocation found = allocate(problem);
    keep(&found);
    us_.push_back(static_cast<double>(now_ns() - begin) * 1e-3);
    return found.force_N;
  }

  AllocationProblem problem_;
  Samples& us_;
};

// With a second IMU of half the rate.
class Whole {
 public:
  explicit Whole(int count) : recorded_(kLearnt + count), standby_(lss::talaris::Parameters{}) {
    for (const Frame& f : recorded_.frames) {
      std::vector<Packet>& second = second_.emplace_back();
      for (std::size_t i = 1; i < f.imu.size(); i += 2) {
        Packet& packet = second.emplace_back();
        packet.time_ns = f.imu[i].time_ns;
        std::ranges::copy(f.imu[i].rate_B_rad_s, packet.imu.rate_rad_s.begin());
        std::ranges::copy(f.imu[i].force_B_m_s2, packet.imu.force_m_s2.begin());
      }
    }
  }

  Samples frame_ns() const {
    lss::talaris::StandbyImu standby = standby_;
    Navigation navigation = recorded_.begin;
    Allocated allocated;
    TimeNs begin = 0;
    std::span<const ImuSample> before;
    for (std::size_t i = 0; i < recorded_.frames.size(); ++i) {
      if (i == kLearnt) begin = now_ns();
      const Frame& f = recorded_.frames[i];
      standby.begin(f.end_ns, before, i < kLearnt);
      for (const Packet& packet : second_[i]) standby.take(packet.imu, packet.time_ns);
      navigation.step({standby.with(f.imu), f.ranges, f.end_ns});
      keep(&navigation);
      allocated.frame(i);
      before = f.imu;
    }
    const auto ns = static_cast<double>(now_ns() - begin);
    if (!standby.heard() || !navigation.state().valid)
      throw std::runtime_error("TALARIS' navigation did not use what it got");
    return {ns / static_cast<double>(recorded_.frames.size() - kLearnt)};
  }

 private:
  static constexpr int kLearnt = 30;  // frames, until the difference of both is known
  struct Packet {
    TimeNs time_ns = 0;
    lss::talaris::ImuPacket imu;
  };
  Recorded recorded_;
  lss::talaris::StandbyImu standby_;
  std::vector<std::vector<Packet>> second_;
};

}  // namespace

std::function<Samples()> talaris_whole(const Options& options) {
  return [whole = Whole(options.count(2'000, 100))] { return whole.frame_ns(); };
}

Figures talaris_allocation(const Options& options) {
  Samples us;
  std::mt19937 random(1);
  const int frames = options.count(100, 10);
  for (Eigen::Index actuator = -1; actuator < kActuators; ++actuator) {
    for (const bool open : {false, true}) {
      if (open && (actuator < 0 || actuator >= static_cast<Eigen::Index>(kValves))) continue;
      Failed failed(us);
      if (actuator >= 0) failed.fail(actuator, open);
      for (int i = 0; i < frames; ++i) failed.frame(random);
    }
  }
  const auto made = [](const char* name, double value) {
    return figure_of("vii", name, "us", value, kNone, kNone,
                     "one problem of twelve actuators; of the three in a frame after a failure");
  };
  Figures figures{at_most(made("TALARIS' allocation, p99", p99(us)), 20)};
  if (options.maxima) figures.push_back(made("TALARIS' allocation, max", quantile(us, 1)));
  return figures;
}

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
