// Row vii: the mathematics of one frame, against one product of two 15 x 15 matrices by Eigen. A
// vehicle is a function, below or in frame_mathematics_NAME.cpp, and an entry of kMathematics.

#include "tests/bench/frame_mathematics.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <iterator>

#include "daemon/runtime/clock.h"
#include "gnc/zebro/locomotion.h"

namespace lss::bench {
namespace {

// Lunar Zebro: gait, legs and odometry while it walks with the tripod gait. Legs are where they
// were ordered to be.
class Walk {
 public:
  explicit Walk(int frames) {
    using namespace gnc::zebro;
    Locomotion locomotion{LocomotionParameters{}};
    double now_s = 0;
    PerLeg<double> angle_rad{};
    PerLeg<LegMeasured> measured;
    const auto frame = [&] {
      for (std::size_t i = 0; i < kLegs; ++i)
        measured[i] = {.angle_rad = angle_rad[i], .known = true, .calibrated = true};
      locomotion.update(now_s, measured);
      for (std::size_t i = 0; i < kLegs; ++i) follow(locomotion.targets()[i], now_s, angle_rad[i]);
      now_s += kFrame_s;
    };
    locomotion.stand_up(now_s);
    for (int i = 0; i < 6000 && locomotion.progress() == Progress::running; ++i) frame();
    locomotion.walk(now_s, {.speed = Speed::high});
    for (int i = 0; i < 1000; ++i) frame();
    if (locomotion.steps() == 0) throw std::runtime_error("the gait does not walk");
    begin_ = locomotion;
    begin_s_ = now_s;
    for (int i = 0; i < frames; ++i) {
      frame();
      recorded_.push_back(measured);
    }
  }

  // Again the same frames, and nothing but the mathematics.
  Samples frame_ns() const {
    gnc::zebro::Locomotion locomotion = begin_;
    double now_s = begin_s_;
    const TimeNs begin = now_ns();
    for (const auto& measured : recorded_) {
      locomotion.update(now_s, measured);
      keep(&locomotion);
      now_s += kFrame_s;
    }
    return {static_cast<double>(now_ns() - begin) / static_cast<double>(recorded_.size())};
  }

 private:
  static constexpr double kFrame_s = 0.02;

  static void follow(const gnc::zebro::LegTarget& target, double now_s, double& angle_rad) {
    if (target.rotation == 0) return;
    constexpr double kTurn = 2 * 3.14159265358979323846;
    double way = std::remainder(target.angle_rad - angle_rad, kTurn);
    // Forward rotation makes theta fall; the long way round unless it is nearly there.
    if (target.rotation > 0 && way > 0.09) way -= kTurn;
    if (target.rotation < 0 && way < -0.09) way += kTurn;
    const double left_s = std::max(target.arrive_s - now_s, kFrame_s);
    angle_rad += way * kFrame_s / left_s;
  }

  gnc::zebro::Locomotion begin_{gnc::zebro::LocomotionParameters{}};
  double begin_s_ = 0;
  std::vector<gnc::zebro::PerLeg<gnc::zebro::LegMeasured>> recorded_;
};

std::function<Samples()> zebro_frame(const Options& options) {
  return [walk = Walk(options.count(20'000, 2'000))] { return walk.frame_ns(); };
}

struct Mathematics {
  const char* name;
  std::function<Samples()> (*frame)(const Options&);  // ns of one frame
  const char* held_back;                              // when the goal is not met, by what
  double goal = 3;                                    // products
};
constexpr Mathematics kMathematics[] = {
    {"Zebro's gait, legs and odometry", zebro_frame, ""},
#ifdef LSS_BENCH_ARDITO
    {"Ardito's controller, three times, vote and failure detection", ardito_frame,
     "44 readings to check, six wheels to judge and 15 sines and arc tangents, in each of three "
     "instances"},
#endif
#ifdef LSS_BENCH_TALARIS
    {"TALARIS' navigation", talaris_navigation,
     "forty quaternions and rotations, two corrections of fifteen states"},
    {"TALARIS' navigation with both IMUs, and allocation", talaris_whole,
     "as without them; three problems of twelve actuators", 5},
#endif
};

Samples product_ns(int count) {
  Eigen::Matrix<double, 15, 15> a, b, c;
  a.setConstant(1.25);
  b.setConstant(0.75);
  const TimeNs begin = now_ns();
  for (int i = 0; i < count; ++i) {
    keep(&a);
    c.noalias() = a * b;
    keep(&c);
  }
  return {static_cast<double>(now_ns() - begin) / count};
}

}  // namespace

Figures frame_mathematics(const Options& options) {
  Figures figures;
  for (const Mathematics& vehicle : kMathematics) {
    const Rounds rounds = turn_by_turn(vehicle.frame(options),
                                       [&] { return product_ns(options.count(20'000, 2'000)); });
    const Figure frame =
        figure("vii", std::string("frame of ") + vehicle.name, "ns", rounds, median, vehicle.goal);
    figures.push_back(
        held_back(noted(frame, "reference: one 15 x 15 product by Eigen"), vehicle.held_back));
  }
#ifdef LSS_BENCH_TALARIS
  figures.push_back(talaris_against_dense(options));
  std::ranges::copy(talaris_allocation(options), std::back_inserter(figures));
#endif
  return figures;
}

}  // namespace lss::bench
