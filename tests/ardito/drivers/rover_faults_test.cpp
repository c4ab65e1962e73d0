// Stale orders, emergencies, and nodes that fail while the rover drives.

#include <gtest/gtest.h>

#include "tests/ardito/drivers/rover_world.h"
#include "tests/support/can_frames.h"

namespace lss::ardito {
namespace {

using canopen::NodeState;
using testing_support::frame;

bool all_stopped(RoverWorld& world) {
  for (std::size_t i = 0; i < kIo; ++i) {
    if (world.node[i].drive == CanNode::Drive::enabled) return false;
  }
  return true;
}

TEST(RoverFaults, StaleOrdersStopAllDrivesByThemselves) {
  RoverWorld world;
  world.boot();
  world.drive(1'000);
  world.release();
  const TimeNs issued = world.now;
  world.run_until(issued + 300 * kMillisecond);
  EXPECT_FALSE(all_stopped(world));
  world.run_until(issued + 300 * kMillisecond + 1);
  EXPECT_TRUE(all_stopped(world));
  EXPECT_EQ(world.counters().safe_commands, 1u);
  world.sent.clear();
  world.run_for(kSecond);
  EXPECT_EQ(world.sent_with(0x201).size(), 10u) << "again and again";
  EXPECT_TRUE(world.sent_with(0x220).empty()) << "clutches stay";
  EXPECT_EQ(world.counters().safe_commands, 1u);

  world.release(false);
  world.run_for(50 * kMillisecond);
  EXPECT_TRUE(all_stopped(world)) << "the same orders once more";
  EXPECT_EQ(world.counters().old_orders, 1u);
  world.run_frames(6);
  EXPECT_EQ(world.wheel(5).target(), 1'000) << "new orders";
}

TEST(RoverFaults, OrdersThatAreTooOldWhenTheyComeStop) {
  RoverWorld world;
  world.boot();
  world.drive(1'000);
  ++world.orders.serial;
  world.orders.issued_ns = world.now - 301 * kMillisecond;
  world.bus.release(world.orders, world.now);
  world.pump();
  EXPECT_TRUE(all_stopped(world));
  EXPECT_EQ(world.counters().stale_orders, 1u);
  EXPECT_EQ(world.counters().safe_commands, 1u);
}

TEST(RoverFaults, AnEmergencyStopsAtOnceAndEndsTheOrdersBeforeIt) {
  RoverWorld world;
  world.boot();
  world.drive(1'000);
  world.sent.clear();
  ++world.orders.emergency_serial;
  world.release();
  EXPECT_TRUE(all_stopped(world));
  ASSERT_GE(world.sent.size(), 10u);
  for (std::size_t i = 0; i < 10; ++i) EXPECT_EQ(word_of(world.sent[i]), 0x0002);
  for (int n = 0; n < 10; ++n) {
    world.release(false);  // the orders of the emergency, fresh again and again
    world.run_for(100 * kMillisecond);
    EXPECT_TRUE(all_stopped(world));
  }
  --world.orders.serial;
  world.release(false);
  world.run_for(100 * kMillisecond);
  EXPECT_TRUE(all_stopped(world)) << "older orders";
  ++world.orders.serial;
  world.run_frames(6);
  EXPECT_EQ(world.wheel(0).target(), 1'000);
}

TEST(RoverFaults, OrdersThatWaitBehindAnEmergencyAreNotSent) {
  RoverWorld world;
  world.boot();
  world.drive(1'000);
  world.run_until(world.now);
  // Released, not yet transmitted, and then the emergency.
  ++world.orders.serial;
  world.orders.issued_ns = world.now;
  world.bus.release(world.orders, world.now);
  ++world.orders.emergency_serial;
  world.bus.release(world.orders, world.now);
  world.sent.clear();
  world.run_for(90 * kMillisecond);
  for (std::uint32_t id = 0x201; id <= 0x206; ++id) {
    for (const CanFrame& f : world.sent_with(id)) EXPECT_EQ(word_of(f), 0x0002);
  }
}

TEST(RoverFaults, AnEmergencyDropsAnEdgeOfASetPointThatIsDue) {
  RoverWorld world;
  world.boot();
  world.drive(0);
  world.orders.steering[0].position_rad = 0.3;
  world.release();
  ++world.orders.emergency_serial;
  world.release();
  world.sent.clear();
  world.run_for(50 * kMillisecond);
  EXPECT_TRUE(world.sent_with(0x211).empty());
  EXPECT_NE(world.steering(0).target(), 150'000);
}

TEST(RoverFaults, NodesStopByThemselvesWhenTheMasterIsGone) {
  RoverWorld world;
  world.boot();
  world.drive(1'000);
  world.orders.beacon = false;
  world.run_frames(1);
  world.master_dead = true;
  const TimeNs last = world.sent_with(0x77F).back().time_ns;
  world.run_until(last + 299 * kMillisecond);
  EXPECT_FALSE(all_stopped(world));
  world.run_until(last + 300 * kMillisecond);
  EXPECT_TRUE(all_stopped(world));
  for (CanNode& n : world.node) EXPECT_EQ(n.nmt, CanNode::Nmt::pre_operational);
  EXPECT_EQ(world.io().object(0x6200, 1), 0x7Fu) << "clutches engaged, beacon on";

  world.master_dead = false;
  world.now = std::max(world.now, last + 300 * kMillisecond);
  world.run_frames(3);
  EXPECT_TRUE(all_stopped(world));
  EXPECT_EQ(world.state(0), NodeState::fallen_back);
  world.orders.standing = true;
  for (WheelOrder& w : world.orders.wheel) w.enabled = false;
  world.run_frames(6);
  for (std::size_t i = 0; i < kNodes; ++i) EXPECT_EQ(world.state(i), NodeState::operational) << i;
}

TEST(RoverFaults, ASilentNodeIsLostAfter300msStoppedAndBootedWhenTheRoverStands) {
  RoverWorld world;
  world.boot();
  world.drive(1'000);
  const TimeNs last = world.link(2).node.heartbeat_ns;
  world.wheel(2).mute = true;
  while (world.state(2) == NodeState::operational && world.now < last + kSecond) {
    world.release();
    world.run_for(kMillisecond);
  }
  EXPECT_NEAR(static_cast<double>(world.now - last), 300e6, 2e6);
  EXPECT_EQ(world.state(2), NodeState::lost);
  EXPECT_EQ(world.link(2).node.losses, 1u);
  world.sent.clear();
  world.run_frames(30);
  EXPECT_EQ(world.wheel(2).quick_stops, 1) << "it may hear us still";
  EXPECT_EQ(world.wheel(1).target(), 1'000) << "what the others do is ordered above";
  EXPECT_TRUE(world.sent_with(0x000).empty()) << "not reset while driving";
  EXPECT_EQ(world.state(2), NodeState::lost);

  world.wheel(2).mute = false;
  world.orders.standing = true;
  world.orders.quick_stop = true;
  world.run_frames(10);
  EXPECT_EQ(world.state(2), NodeState::operational);
}

TEST(RoverFaults, ANodeWhoseHeartbeatComesBackGoesOn) {
  RoverWorld world;
  world.boot();
  world.drive(1'000);
  world.wheel(2).mute = true;
  world.run_frames(4);
  EXPECT_EQ(world.state(2), NodeState::lost);
  world.wheel(2).mute = false;
  world.run_frames(6);
  EXPECT_EQ(world.state(2), NodeState::operational);
  EXPECT_EQ(world.link(2).node.losses, 1u);
  EXPECT_EQ(world.wheel(2).target(), 1'000);
}

TEST(RoverFaults, ANodeThatRebootsIsReportedWhileDrivingAndBroughtUpWhenTheRoverStands) {
  RoverWorld world;
  world.boot();
  world.drive(1'000);
  world.steering(3).reboot(world.now);
  world.sent.clear();
  world.run_frames(20);
  const std::size_t index = kFirstSteering + 3;
  EXPECT_EQ(world.state(index), NodeState::rebooted);
  EXPECT_EQ(world.link(index).node.reboots, 1u);
  EXPECT_TRUE(world.sent_with(0x616).empty());
  EXPECT_EQ(world.steering(3).nmt, CanNode::Nmt::pre_operational);
  world.orders.standing = true;
  world.run_frames(5);
  EXPECT_EQ(world.state(index), NodeState::operational);
  EXPECT_TRUE(world.sent_with(0x000).size() == 1) << "started, not reset";
}

TEST(RoverFaults, ANodeThatFallsBackByItselfIsReported) {
  RoverWorld world;
  world.boot();
  world.drive(1'000);
  world.imu().nmt = CanNode::Nmt::stopped;
  world.run_frames(3);
  EXPECT_EQ(world.state(kImu), NodeState::fallen_back);
  EXPECT_EQ(world.link(kImu).node.fall_backs, 1u);
  EXPECT_EQ(world.link(kImu).node.nmt, canopen::NmtState::stopped);
}

TEST(RoverFaults, APdoOfAnotherLengthIsCountedAndNotUsed) {
  RoverWorld world;
  world.boot();
  world.run_frames(1);
  world.take_all();
  world.wheel(0).shorter_pdos = 2;
  world.run_frames(1);
  EXPECT_EQ(world.link(0).node.wrong_lengths, 2u);
  for (const auto& [time, motion] : world.take_of<WheelMotion>()) EXPECT_NE(motion.wheel, 0);
  world.run_frames(1);
  EXPECT_EQ(world.take_of<WheelMotion>().size(), 6u);
}

TEST(RoverFaults, PdosOfANodeThatIsNotOperationalAreNotUsed) {
  RoverWorld world;
  world.deliver(frame(0x181, {0x37, 0x02, 0, 0, 0, 0, 0, 0}, world.now));
  EXPECT_TRUE(world.take_all().empty());
  EXPECT_EQ(world.link(0).node.ignored, 1u);
}

TEST(RoverFaults, ANodeThatBabblesIsNotListenedToUntilItIsQuiet) {
  RoverWorld world;
  world.boot();
  world.drive(1'000);
  world.run_for(70 * kMillisecond);
  for (int n = 0; n < 150; ++n) {
    world.deliver(frame(0x1A1, {0, 0, 0, 0, 0, 0, 1, 0}, world.now));
  }
  EXPECT_EQ(world.state(kImu), NodeState::babbling);
  EXPECT_EQ(world.link(kImu).node.babbles, 1u);
  EXPECT_LE(world.take_of<Imu>().size(), 100u);
  world.run_frames(5);
  EXPECT_EQ(world.state(kImu), NodeState::babbling);
  EXPECT_TRUE(world.take_of<Imu>().empty());
  EXPECT_EQ(world.state(0), NodeState::operational) << "the others are heard";
  world.run_frames(10);
  EXPECT_EQ(world.state(kImu), NodeState::operational);
  world.run_frames(1);
  EXPECT_FALSE(world.take_of<Imu>().empty());
}

TEST(RoverFaults, AnEmcyStormIsCountedAndEnds) {
  RoverWorld world;
  world.boot();
  for (int n = 0; n < 40; ++n) {
    world.wheel(3).send_emcy(n % 2 == 0 ? 0x8611 : 0x0000, 0x21, world.now);
    world.release();
    world.run_for(20 * kMillisecond);
  }
  EXPECT_EQ(world.link(3).node.emcys, 40u);
  EXPECT_TRUE(world.link(3).node.emcy_storm);
  EXPECT_EQ(world.link(3).node.emcy_code, 0x0000);
  EXPECT_EQ(world.state(3), NodeState::operational);
  world.run_frames(30);
  EXPECT_FALSE(world.link(3).node.emcy_storm);
}

TEST(RoverFaults, NodesAreNotBootedWhileOrdersAreStale) {
  RoverWorld world;
  world.boot();
  world.run_for(kSecond);
  world.wheel(0).reboot(world.now);
  world.sent.clear();
  world.run_for(3 * kSecond);
  EXPECT_EQ(world.state(0), NodeState::rebooted);
  EXPECT_TRUE(world.sent_with(0x601).empty());
  EXPECT_FALSE(world.stuck);
}

}  // namespace
}  // namespace lss::ardito
