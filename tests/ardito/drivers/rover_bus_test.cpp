// Messages sent and received without faults.

#include "drivers/ardito/rover_bus.h"

#include <gtest/gtest.h>

#include <limits>

#include "tests/ardito/drivers/rover_world.h"
#include "tests/support/can_frames.h"

namespace lss::ardito {
namespace {

using canopen::DriveState;
using canopen::NodeState;
using testing_support::Bytes;
using testing_support::data_of;
using testing_support::frame;

TEST(RoverBus, SyncGoesTenMillisecondsBeforeEachFrameBoundary) {
  RoverWorld world;
  world.boot();
  world.run_for(37 * kMillisecond);  // another phase than the boot's
  world.run_frames(1);
  world.sent.clear();
  const TimeNs start = world.now;
  world.run_frames(50);
  const auto syncs = world.sent_with(0x080);
  ASSERT_EQ(syncs.size(), 50u);
  for (std::size_t n = 0; n < syncs.size(); ++n) {
    EXPECT_EQ(syncs[n].size, 0);
    EXPECT_EQ(syncs[n].time_ns,
              start + static_cast<TimeNs>(n) * 100 * kMillisecond + 90 * kMillisecond);
  }
}

TEST(RoverBus, ANewPhaseOfTheFramesNeverMakesTwoSyncsOfOne) {
  for (TimeNs shift = 0; shift < 100 * kMillisecond; shift += 7 * kMillisecond) {
    RoverWorld world;
    world.boot();
    world.run_frames(2);
    world.run_for(shift);
    world.run_frames(3);
    const auto syncs = world.sent_with(0x080);
    for (std::size_t n = 1; n < syncs.size(); ++n) {
      EXPECT_GE(syncs[n].time_ns - syncs[n - 1].time_ns, 50 * kMillisecond) << shift;
      EXPECT_LE(syncs[n].time_ns - syncs[n - 1].time_ns, 150 * kMillisecond) << shift;
    }
  }
}

TEST(RoverBus, SyncGoesOnInItsRhythmWithoutOrders) {
  RoverWorld world;
  world.boot();
  world.run_for(10 * kSecond);
  const auto syncs = world.sent_with(0x080);
  ASSERT_EQ(syncs.size(), 100u);
  for (std::size_t n = 1; n < syncs.size(); ++n) {
    EXPECT_EQ(syncs[n].time_ns - syncs[n - 1].time_ns, 100 * kMillisecond);
  }
}

TEST(RoverBus, AThreadThatWasLateSendsOneSyncAndCountsTheOthers) {
  RoverWorld world;
  world.boot();
  world.now += 350 * kMillisecond;
  world.pump();
  EXPECT_EQ(world.sent_with(0x080).size(), 1u);
  EXPECT_EQ(world.counters().master.syncs_skipped, 2u);
  EXPECT_EQ(world.sent_with(0x77F).size(), 1u);
}

TEST(RoverBus, HeartbeatOfTheMasterEvery100ms) {
  RoverWorld world;
  world.run_for(5 * kSecond);
  const auto beats = world.sent_with(0x77F);
  ASSERT_EQ(beats.size(), 51u);
  for (std::size_t n = 1; n < beats.size(); ++n) {
    EXPECT_EQ(data_of(beats[n]), Bytes{5});
    EXPECT_EQ(beats[n].time_ns - beats[n - 1].time_ns, 100 * kMillisecond);
  }
}

TEST(RoverBus, WalksDrivesToOperationEnabledAStepPerFrame) {
  RoverWorld world;
  world.boot();
  world.orders.wheel[0] = {true, -1'592};
  world.run_frames(5);
  std::vector<int> words;
  for (const CanFrame& f : world.sent_with(0x201)) words.push_back(word_of(f));
  // After the boot the orders had it disabled: ready to switch on.
  EXPECT_EQ(words, (std::vector<int>{0x07, 0x0F, 0x0F, 0x0F, 0x0F}));
  EXPECT_EQ(data_of(world.sent_with(0x201).back()), (Bytes{0x0F, 0, 0xC8, 0xF9, 0xFF, 0xFF}));
  EXPECT_EQ(target_of(world.sent_with(0x201).front()), 0) << "no target before it is enabled";
  EXPECT_EQ(world.wheel(0).target(), -1'592);
  EXPECT_EQ(world.wheel(1).drive, CanNode::Drive::ready) << "not ordered";
  EXPECT_EQ(world.link(0).drive, DriveState::operation_enabled);
  world.orders.wheel[0].enabled = false;
  world.run_frames(2);
  EXPECT_EQ(world.wheel(0).drive, CanNode::Drive::ready);
}

TEST(RoverBus, DrivesLeaveAQuickStopWhenOrdered) {
  RoverWorld world;
  world.boot();
  world.drive(500);
  world.orders.quick_stop = true;
  world.run_frames(3);
  for (std::size_t i = 0; i < kIo; ++i) EXPECT_EQ(world.node[i].drive, CanNode::Drive::quick_stop);
  EXPECT_EQ(world.link(0).drive, DriveState::quick_stop_active);
  world.orders.quick_stop = false;
  world.run_frames(6);
  for (std::size_t i = 0; i < kWheels; ++i) EXPECT_EQ(world.wheel(i).target(), 500);
  world.orders.quick_stop = true;
  world.run_frames(2);
  world.orders.quick_stop = false;
  for (WheelOrder& w : world.orders.wheel) w.enabled = false;
  world.run_frames(3);
  for (std::size_t i = 0; i < kWheels; ++i) {
    EXPECT_EQ(world.wheel(i).drive, CanNode::Drive::ready) << "power off";
  }
}

TEST(RoverBus, SteeringTakesEachNewSetPointWithBothEdgesOfItsBit) {
  RoverWorld world;
  world.boot();
  world.drive(0);
  world.orders.steering[2].position_rad = 0.5;
  world.run_frames(3);
  const auto frames = world.sent_with(0x215);
  ASSERT_EQ(frames.size(), 4u);
  EXPECT_EQ(data_of(frames[0]), (Bytes{0x2F, 0, 0x90, 0xD0, 0x03, 0}));
  EXPECT_EQ(data_of(frames[1]), (Bytes{0x3F, 0, 0x90, 0xD0, 0x03, 0}));
  EXPECT_EQ(frames[1].time_ns - frames[0].time_ns, 5 * kMillisecond);
  EXPECT_EQ(data_of(frames[2]), data_of(frames[1])) << "held";
  EXPECT_EQ(data_of(frames[3]), data_of(frames[1]));
  EXPECT_EQ(world.steering(2).target(), 250'000);
  EXPECT_EQ(world.link(kFirstSteering + 2).set_points_refused, 0u);
  const int before = world.steering(2).set_points;
  for (int n = 1; n <= 10; ++n) {
    world.orders.steering[2].position_rad = 0.5 - 0.01 * n;
    world.run_frames(1);
  }
  EXPECT_EQ(world.steering(2).set_points, before + 10) << "a new one each frame";
  EXPECT_EQ(world.steering(2).target(), 200'000);
  EXPECT_EQ(world.steering(0).set_points, 2) << "not sent again, but once a second";
}

TEST(RoverBus, ASetPointThatWasNotAcknowledgedIsSentAgain) {
  RoverWorld world;
  world.boot();
  world.drive(0);
  world.orders.steering[1].position_rad = -0.2;
  world.release();
  world.steering(1).ignores_controlword = true;  // the rising edge is lost on it
  world.run_for(100 * kMillisecond);
  EXPECT_EQ(world.link(kFirstSteering + 1).set_points_refused, 1u);
  EXPECT_NE(world.steering(1).target(), -100'000);
  world.steering(1).ignores_controlword = false;
  world.run_frames(1);
  EXPECT_EQ(world.steering(1).target(), -100'000);
  world.run_frames(3);
  EXPECT_EQ(world.link(kFirstSteering + 1).set_points_refused, 1u);
}

// Its acknowledgement would be that of the set-point before.
TEST(RoverBus, ASetPointOfWhichBothFramesWereLostIsSentAgainAfterASecond) {
  RoverWorld world;
  world.boot();
  world.drive(0);
  world.orders.steering[1].position_rad = -0.2;
  world.steering(1).ignores_controlword = true;
  world.run_frames(2);
  world.steering(1).ignores_controlword = false;
  world.run_frames(10);
  EXPECT_EQ(world.steering(1).target(), -100'000);
}

TEST(RoverBus, OutputsFollowTheOrders) {
  RoverWorld world;
  world.boot();
  world.orders.clutches = 0x3D;
  world.orders.beacon = true;
  world.run_frames(1);
  EXPECT_EQ(world.io().object(0x6200, 1), 0x7Du);
  world.orders.beacon = false;
  world.run_frames(1);
  EXPECT_EQ(world.io().object(0x6200, 1), 0x3Du);
}

TEST(RoverBus, HandsUpEveryReadingOfEachFrameWithItsArrival) {
  RoverWorld world;
  world.boot();
  world.drive(1'500);
  world.orders.steering[3].position_rad = 0.1;
  world.io().object(0x6401, 1) = 0xFC18;  // -1000
  world.io().object(0x6000, 1) = 3;
  world.run_frames(2);
  world.take_all();
  world.release();
  const TimeNs sync = world.now + 90 * kMillisecond;
  world.run_for(100 * kMillisecond);
  std::map<std::size_t, int> kinds;
  for (const RoverSample& s : world.take_all()) {
    ++kinds[s.reading.index()];
    if (std::holds_alternative<WheelHealth>(s.reading)) continue;
    EXPECT_EQ(s.time_ns, sync + kMillisecond);
    if (const auto* motion = std::get_if<WheelMotion>(&s.reading)) {
      EXPECT_EQ(motion->motor_rpm, 1'500);
    } else if (const auto* speeds = std::get_if<WheelSpeeds>(&s.reading)) {
      EXPECT_DOUBLE_EQ(speeds->reduction_rpm, 30);
    } else if (const auto* angle = std::get_if<SteeringAngle>(&s.reading)) {
      EXPECT_DOUBLE_EQ(angle->reduction_rad, angle->wheel == 5 ? 0.1 : 0.0);
    } else if (const auto* inputs = std::get_if<Inputs>(&s.reading)) {
      EXPECT_TRUE(inputs->emergency_button);
    } else if (const auto* rocker = std::get_if<Rocker>(&s.reading)) {
      EXPECT_DOUBLE_EQ(rocker->beta_rad, -0.1);
    }
  }
  EXPECT_EQ(kinds[Reading(WheelMotion{}).index()], 6);
  EXPECT_EQ(kinds[Reading(WheelSpeeds{}).index()], 6);
  EXPECT_EQ(kinds[Reading(SteeringMotion{}).index()], 4);
  EXPECT_EQ(kinds[Reading(SteeringAngle{}).index()], 4);
  EXPECT_EQ(kinds[Reading(Inputs{}).index()], 1);
  EXPECT_EQ(kinds[Reading(Rocker{}).index()], 1);
  EXPECT_EQ(kinds[Reading(Imu{}).index()], 1);
  world.run_frames(10);
  EXPECT_EQ(world.take_of<WheelHealth>().size(), 6u) << "once a second";
}

TEST(RoverBus, ReadingsThatNobodyTakesAreDroppedOldestFirstAndCounted) {
  RoverWorld world;
  world.boot();
  world.run_frames(20);
  EXPECT_GT(world.counters().overflows, 0u);
  const auto all = world.take_all();
  ASSERT_EQ(all.size(), RoverBus::kMaxSamples);
  EXPECT_GT(all.front().time_ns, world.now - 700 * kMillisecond);
}

TEST(RoverBus, AnOrderThatIsNoNumberDisablesItsDrive) {
  RoverWorld world;
  world.boot();
  world.drive(100);
  world.orders.wheel[3].motor_rpm = std::numeric_limits<double>::quiet_NaN();
  world.orders.steering[1].position_rad = std::numeric_limits<double>::infinity();
  world.run_frames(2);
  EXPECT_EQ(world.wheel(3).drive, CanNode::Drive::ready);
  EXPECT_EQ(world.steering(1).drive, CanNode::Drive::ready);
  EXPECT_EQ(world.wheel(2).target(), 100);
  EXPECT_EQ(world.counters().bad_orders, 4u);
}

TEST(RoverBus, AFaultIsResetWhenOrderedAndNotByItself) {
  RoverWorld world;
  world.boot();
  world.drive(300);
  world.wheel(1).fault(0x7121, world.now);
  world.run_frames(5);
  EXPECT_EQ(world.link(1).drive, DriveState::fault);
  EXPECT_EQ(world.link(1).node.emcy_code, 0x7121);
  EXPECT_EQ(world.link(1).node.emcy_register, 0x21);
  ++world.orders.fault_reset_serial;
  world.sent.clear();
  world.run_frames(7);
  const auto frames = world.sent_with(0x202);
  EXPECT_EQ(word_of(frames[0]), 0x0000);
  EXPECT_EQ(word_of(frames[1]), 0x0080);
  EXPECT_EQ(world.wheel(1).target(), 300) << "enabled again as the orders say";
  EXPECT_EQ(world.wheel(1).drive, CanNode::Drive::enabled);
}

TEST(RoverBus, AFaultIsResetInAQuickStopToo) {
  RoverWorld world;
  world.boot();
  world.orders.quick_stop = true;
  world.run_frames(2);
  world.wheel(0).fault(0x3220, world.now);
  world.run_frames(2);
  ++world.orders.fault_reset_serial;
  world.run_frames(3);
  EXPECT_EQ(world.wheel(0).drive, CanNode::Drive::disabled);
}

TEST(RoverBus, ADriveThatIsLongNotInTheOrderedStateDisobeys) {
  RoverWorld world;
  world.boot();
  world.drive(300);
  world.wheel(4).ignores_controlword = true;
  world.orders.quick_stop = true;
  world.run_frames(20);
  EXPECT_FALSE(world.link(4).disobeys);
  world.run_frames(3);
  EXPECT_TRUE(world.link(4).disobeys);
  EXPECT_FALSE(world.link(3).disobeys);
  world.wheel(4).ignores_controlword = false;
  world.run_frames(3);
  EXPECT_FALSE(world.link(4).disobeys);
}

TEST(RoverBus, AnotherMasterOnTheBusIsNoticed) {
  RoverWorld world;
  world.boot();
  for (const CanFrame& f :
       {frame(0x000, {1, 0}), frame(0x080, {}), frame(0x201, {0, 0, 0, 0, 0, 0}), frame(0x301, {1}),
        frame(0x602, {0x40, 0, 0x10, 0, 0, 0, 0, 0}), frame(0x77F, {5})}) {
    world.deliver(f);
  }
  EXPECT_EQ(world.counters().master.other_masters, 6u);
  EXPECT_EQ(world.counters().master.unknown_frames, 0u);
}

TEST(RoverBus, FramesOfStrangersAreCountedAndNotUsed) {
  RoverWorld world;
  world.boot();
  CanFrame extended = frame(0x181, {0, 0, 0, 0, 0, 0, 0, 0}), remote = extended, error = extended;
  extended.extended = remote.remote = error.error = true;
  for (const CanFrame& f :
       {extended, remote, error, frame(0x100, {1}), frame(0x7E5, {1}), frame(0x701, {1, 2}),
        frame(0x481, {1}), frame(0x081, {1}), frame(0x701, {0x45}), frame(0x701, {0x85})}) {
    world.deliver(f);
  }
  EXPECT_EQ(world.counters().master.unknown_frames, 10u);
  EXPECT_EQ(world.state(0), NodeState::operational);
  for (const std::uint32_t id : {0x187u, 0x707u, 0x087u, 0x5A2u}) world.deliver(frame(id, {1}));
  EXPECT_EQ(world.counters().master.unknown_nodes, 4u);
  EXPECT_TRUE(world.take_all().empty());
}

}  // namespace
}  // namespace lss::ardito
