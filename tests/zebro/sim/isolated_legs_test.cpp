// On five and on four legs in rigid-body physics: the locomotion algorithm in closed loop with the
// modules, by their bytes; the modules of the other legs are dead, their legs hang where they did.

#include <gtest/gtest.h>

#include "gnc/zebro/locomotion.h"
#include "idl/angles.h"
#include "tests/support/everything.h"
#include "tests/zebro/sim/robot_driver.h"

namespace lss::sim::zebro {
namespace {

namespace algorithm = lss::gnc::zebro;
using algorithm::Progress;
using algorithm::Speed;

constexpr double kFrame_s = 0.02;

class Loop {
 public:
  Loop(const TerrainOptions& terrain, algorithm::LegSet dead) : driver_(terrain), dead_(dead) {
    const auto kind = make_zebro_kind();
    for (int leg = 1; leg <= kLegs; ++leg) {
      if (is_dead(leg)) {
        const std::string fault = "module-dead:" + std::to_string(leg);
        driver_.zebro().set_fault(parse_fault(fault, kind->fault_kinds()).value(), true);
      }
      driver_.command(leg, 0x01);
    }
    EXPECT_TRUE(locomotion.isolate(dead));
  }

  // One frame: reports of the modules, and their orders.
  void frame() {
    std::array<algorithm::LegMeasured, kLegs> measured{};
    for (int leg = 1; leg <= kLegs; ++leg) {
      if (is_dead(leg)) continue;  // no answer
      const auto status = driver_.command(leg, 0x05);
      const double position_rad = (status[2] << 8 | status[3]) * 0.01 * kDegree;
      measured[index(leg)] = {
          .angle_rad = -position_rad, .known = true, .calibrated = (status[1] & 2) != 0};
    }
    locomotion.update(now_s(), measured);
    for (int leg = 1; leg <= kLegs; ++leg) obey(leg);
    driver_.run(kFrame_s);
    const double tilt_deg = driver_.moved(driver_.body()).tilt_deg;
    tilted_deg_ = std::max(tilted_deg_, tilt_deg);
  }

  bool finish(double most_s) {
    const double until_s = now_s() + most_s;
    do {
      frame();
    } while (locomotion.progress() == Progress::running && now_s() < until_s);
    return locomotion.progress() == Progress::done;
  }

  void run(double seconds) {
    for (const double until_s = now_s() + seconds; now_s() < until_s;) frame();
  }

  // From here on.
  void watch_attitude() { tilted_deg_ = 0; }
  double tilted_deg() const { return tilted_deg_; }

  RobotDriver& driver() { return driver_; }
  double now_s() const { return driver_.now_s(); }
  double shaft_rad(int leg) { return driver_.zebro().robot().shafts()[index(leg)].angle_rad; }

  algorithm::Locomotion locomotion{algorithm::LocomotionParameters{}};

 private:
  static std::size_t index(int leg) { return static_cast<std::size_t>(leg - 1); }
  bool is_dead(int leg) const { return algorithm::contains(dead_, index(leg)); }

  void obey(int leg) {
    const algorithm::LegTarget& target = locomotion.targets()[index(leg)];
    if (target.segment == segment_[index(leg)] || target.rotation == 0) return;
    segment_[index(leg)] = target.segment;
    const double turned_deg = std::fmod(360 - target.angle_rad / kDegree, 360.0);
    const long position = std::lround(turned_deg * 100) % 36000;
    const long time = std::lround((target.arrive_s - now_s()) * 1000);
    const auto byte = [](long value) { return static_cast<std::uint8_t>(value & 0xFF); };
    driver_.command(leg, target.rotation > 0 ? 0x03 : 0x04,
                    {byte(position >> 8), byte(position), byte(time >> 8), byte(time)});
  }

  RobotDriver driver_;
  algorithm::LegSet dead_;
  std::array<std::uint32_t, kLegs> segment_{};
  double tilted_deg_ = 0;
};

struct Cripple {
  const char* name;
  algorithm::LegSet dead;
  double direction;
  double cycle_s, speed_m_s;  // of the table in docs/gait-zebro.md
};

class Cripples : public testing::TestWithParam<Cripple> {};

// [Conf-3]
TEST_P(Cripples, StandsUpWalksAtTheSpeedOfItsGaitAndLiesDown) {
  const Cripple& robot = GetParam();
  LSS_SKIP_OUTSIDE_SAMPLE(robot.dead, 2);  // either has one that creeps and one that rows
  Loop loop({.seed = 4}, robot.dead);
  std::array<double, kLegs> hung_rad{};
  for (int leg = 1; leg <= kLegs; ++leg) {
    hung_rad[static_cast<std::size_t>(leg - 1)] = loop.shaft_rad(leg);
  }
  loop.locomotion.stand_up(loop.now_s());
  ASSERT_TRUE(loop.finish(30));
  EXPECT_NEAR(loop.driver().body().position_m.z(), 0.053, 0.002);

  loop.watch_attitude();
  loop.locomotion.walk(loop.now_s(), {.direction = robot.direction, .speed = Speed::high});
  loop.run(1.0 + 0.5 + robot.cycle_s);
  const BodyState from = loop.driver().body();
  const double began_s = loop.now_s();
  loop.run(robot.cycle_s);
  const Pose pose = loop.driver().moved(from);
  const double speed_m_s = pose.ahead_m / (loop.now_s() - began_s);
  RecordProperty("speed_mm_s", std::to_string(speed_m_s * 1e3));
  RecordProperty("tilted_deg", std::to_string(loop.tilted_deg()));
  EXPECT_EQ(loop.locomotion.progress(), Progress::running);
  EXPECT_NEAR(speed_m_s, robot.direction * robot.speed_m_s, 0.25 * robot.speed_m_s);
  EXPECT_LT(std::abs(pose.left_m), 0.1 * std::abs(pose.ahead_m));
  EXPECT_LT(loop.tilted_deg(), 7);  // a robot that tips over its feet tilts by 12 and more

  loop.locomotion.lay_down(loop.now_s());
  ASSERT_TRUE(loop.finish(20));
  EXPECT_NEAR(loop.driver().body().position_m.z(), kHipHeightLying_m, 0.002);
  for (int leg = 1; leg <= kLegs; ++leg) {
    const auto i = static_cast<std::size_t>(leg - 1);
    if (!algorithm::contains(robot.dead, i)) continue;
    EXPECT_NEAR(loop.shaft_rad(leg), hung_rad[i], 0.02);
  }
}
INSTANTIATE_TEST_SUITE_P(
    Robot, Cripples,
    testing::Values(Cripple{"WithoutFrontLeft", 0b000001, +1, 13.5, 0.0040},
                    Cripple{"WithoutHindRightBackward", 0b100000, -1, 13.5, 0.0040},
                    Cripple{"WithoutOppositeCorners", 0b100001, +1, 18.0, 0.0030},
                    Cripple{"WithoutLeftCorners", 0b010001, +1, 4.1, 0.0284},
                    Cripple{"WithoutMiddleAndCornerBackward", 0b100100, -1, 4.1, 0.0284}),
    [](const auto& robot) { return robot.param.name; });

}  // namespace
}  // namespace lss::sim::zebro
