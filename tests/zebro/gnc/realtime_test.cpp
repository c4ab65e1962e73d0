// What the frame thread relies on: no allocation, the same bits for the same calls, bytes that can
// be kept and replayed, and any clock.

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <cstring>
#include <memory>

#include "gnc/zebro/locomotion.h"
#include "tests/support/allocations.h"
#include "tests/zebro/gnc/generators.h"
#include "tests/zebro/gnc/robot.h"

namespace lss::gnc::zebro::test {
namespace {

void ask(Locomotion& locomotion, double now_s, int what) {
  switch (what) {
    case 0: return locomotion.hold(now_s);
    case 1: return locomotion.stand_up(now_s);
    case 2: return locomotion.finish_step(now_s);
    case 3: return locomotion.lay_down(now_s);
    case 4: return locomotion.stow(now_s);
    default: {
      const WalkRequest request{.direction = what % 2 == 0 ? 1.0 : -1.0,
                                .heading_rad = (what % 7 - 3) * 0.5,
                                .speed = static_cast<Speed>(what % 4)};
      return locomotion.walk(now_s, request);
    }
  }
}

TEST(Realtime, CounterCountsAllocations) {
  const std::uint64_t before = testing_support::allocations();
  const auto one = std::make_unique<int>(1);
  EXPECT_EQ(testing_support::allocations(), before + 1);
}

TEST(Realtime, NothingAllocatesInAnyMotion) {
  Robot robot;
  for (RobotLeg& leg : robot.legs) leg.calibrated = false;
  for (int what = 1; what < 40; ++what) {
    const std::uint64_t before = testing_support::allocations();
    ask(robot.locomotion, robot.now_s, what);
    robot.run(12);
    ASSERT_EQ(testing_support::allocations(), before);
  }
  EXPECT_GT(robot.locomotion.steps(), 10U);
}

bool same_targets(const Locomotion& a, const Locomotion& b) {
  for (std::size_t i = 0; i < kLegs; ++i) {
    const LegTarget &x = a.targets()[i], &y = b.targets()[i];
    if (x.angle_rad != y.angle_rad || x.arrive_s != y.arrive_s || x.rotation != y.rotation ||
        x.segment != y.segment || x.swing != y.swing) {
      return false;
    }
  }
  return a.distance_m() == b.distance_m() && a.yaw_rad() == b.yaw_rad() &&
         a.progress() == b.progress();
}

RC_GTEST_PROP(Realtime, SameCallsGiveTheSameBitsAlsoFromASnapshotInTheMiddle, ()) {
  Robot robot;
  Locomotion twin(robot.parameters);
  Locomotion replayed(robot.parameters);
  const int snapshot_at = *rc::gen::inRange(0, 20);
  for (int n = 0; n < 20; ++n) {
    if (n == snapshot_at) {
      std::memcpy(static_cast<void*>(&replayed), &robot.locomotion, sizeof replayed);
    }
    const int what = *rc::gen::inRange(0, 40);
    ask(robot.locomotion, robot.now_s, what);
    ask(twin, robot.now_s, what);
    if (n >= snapshot_at) ask(replayed, robot.now_s, what);
    const int frames = *rc::gen::inRange(1, 500);
    for (int frame = 0; frame < frames; ++frame) {
      robot.remember();
      twin.update(robot.now_s, robot.measured());
      if (n >= snapshot_at) replayed.update(robot.now_s, robot.measured());
      robot.update_and_move();
      RC_ASSERT(same_targets(robot.locomotion, twin));
      if (n >= snapshot_at) RC_ASSERT(same_targets(robot.locomotion, replayed));
    }
  }
}

// [Prod-1]
RC_GTEST_PROP(Realtime, AnySequenceOfMotionsEndsWellOnLegsThatObey, ()) {
  Robot robot;
  for (RobotLeg& leg : robot.legs) {
    put_anywhere(leg);
    leg.has_sensor = *rc::gen::weightedElement<bool>({{5, true}, {1, false}});
  }
  robot.on_order = [&](std::size_t, const LegTarget& target, double way_rad) {
    RC_ASSERT(target.arrive_s > robot.now_s + 1.5 * kFrame_s);
    RC_ASSERT(std::abs(target.angle_rad) <= kPi);
    RC_ASSERT(std::abs(way_rad) / (target.arrive_s - robot.now_s) <=
              robot.parameters.swing_limit_rad_s * (1 + 1e-9));
  };
  for (int n = 0; n < 12; ++n) {
    ask(robot.locomotion, robot.now_s, *rc::gen::inRange(0, 40));
    robot.run(*rc::gen::inRange(1, 150) * 0.1);
    RC_ASSERT(robot.locomotion.progress() != Progress::failed);
  }
  robot.locomotion.lay_down(robot.now_s);
  RC_ASSERT(robot.succeeds());
}

TEST(Realtime, AMillionSecondsOnTheClockChangeNothing) {
  Robot early(LocomotionParameters{}, 0), late(LocomotionParameters{}, 1e6);
  for (Robot* robot : {&early, &late}) {
    robot->locomotion.walk(robot->now_s,
                           {.direction = 1, .heading_rad = 0.4, .speed = Speed::high});
    robot->run(40);
  }
  for (std::size_t i = 0; i < kLegs; ++i) {
    EXPECT_EQ(early.locomotion.targets()[i].segment, late.locomotion.targets()[i].segment);
    EXPECT_NEAR(early.locomotion.targets()[i].arrive_s + 1e6, late.locomotion.targets()[i].arrive_s,
                1e-6);
    EXPECT_NEAR(early.locomotion.targets()[i].angle_rad, late.locomotion.targets()[i].angle_rad,
                1e-6);
  }
}

}  // namespace
}  // namespace lss::gnc::zebro::test
