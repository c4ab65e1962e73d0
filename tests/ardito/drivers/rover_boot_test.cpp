// Nodes are reset, identified, configured and started; those with which that does not work.

#include <gtest/gtest.h>

#include "tests/ardito/drivers/rover_world.h"
#include "tests/support/can_frames.h"

namespace lss::ardito {
namespace {

using canopen::NodeState;
using testing_support::Bytes;
using testing_support::data_of;

TEST(RoverBoot, BeginsWithAQuickStopToAllDrives) {
  RoverWorld world;
  world.pump();
  ASSERT_GE(world.sent.size(), 10u);
  for (std::size_t i = 0; i < 10; ++i) {
    const std::uint8_t id =
        i < 6 ? world.parameters.wheel_node[i] : world.parameters.steering_node[i - kFirstSteering];
    EXPECT_EQ(world.sent[i].id, 0x200u + id);
    EXPECT_EQ(data_of(world.sent[i]), (Bytes{0x02, 0, 0, 0, 0, 0}));
  }
}

TEST(RoverBoot, BeginsWithTheStopAlsoWithoutARestart) {
  RoverBus bus{RoverBusParameters{}};
  CanFrame first;
  ASSERT_TRUE(bus.transmit(0, first));
  EXPECT_EQ(first.id, 0x201u);
  EXPECT_EQ(data_of(first), (Bytes{0x02, 0, 0, 0, 0, 0}));
}

TEST(RoverBoot, ResetsNodesOnlyWhenDrivesHadTimeToStand) {
  RoverWorld world;
  const TimeNs start = world.now;
  world.run_for(499 * kMillisecond);
  EXPECT_TRUE(world.sent_with(0x000).empty());
  EXPECT_GE(world.sent_with(0x201).size(), 2u);
  world.run_for(kMillisecond);
  const auto resets = world.sent_with(0x000);
  ASSERT_EQ(resets.size(), kNodes);
  for (const CanFrame& f : resets) {
    EXPECT_EQ(f.time_ns, start + 500 * kMillisecond);
    EXPECT_EQ(f.data[0], 0x82);
  }
  EXPECT_EQ(resets[0].data[1], 0x01);
  EXPECT_EQ(resets[kImu].data[1], 0x21);
}

TEST(RoverBoot, BringsAllNodesUpWithoutAnyOrders) {
  RoverWorld world;
  world.run_for(kSecond);
  for (std::size_t i = 0; i < kNodes; ++i) {
    EXPECT_EQ(world.state(i), NodeState::operational) << i;
    EXPECT_EQ(world.node[i].nmt, CanNode::Nmt::operational) << i;
  }
  EXPECT_FALSE(world.stuck);
  EXPECT_EQ(world.counters().master.unknown_frames, 0u);
  EXPECT_EQ(world.counters().master.unknown_nodes, 0u);
}

TEST(RoverBoot, WritesTheConfigurationOfTheInterfaceDocument) {
  RoverWorld world;
  world.boot();
  for (CanNode& n : world.node) {
    EXPECT_EQ(n.object(0x1017), 100u);
    EXPECT_EQ(n.object(0x1016, 1), 0x007F012Cu);
    EXPECT_EQ(n.object(0x1015), 100u);
    EXPECT_EQ(n.object(0x1029, 1), 0u);
  }
  for (std::size_t i = 0; i < kIo; ++i) {
    EXPECT_EQ(world.node[i].object(0x6007), 3u);
    EXPECT_EQ(world.node[i].object(0x605A), 6u);
  }
  CanNode& wheel = world.wheel(4);
  EXPECT_EQ(wheel.object(0x6060), 3u);
  for (const std::uint16_t i :
       {std::uint16_t{0x6083}, std::uint16_t{0x6084}, std::uint16_t{0x6085}})
    EXPECT_EQ(wheel.object(i), 8'000u);
  EXPECT_EQ(wheel.object(0x1400, 1), 0x205u);
  EXPECT_EQ(wheel.object(0x1400, 2), 255u);
  EXPECT_EQ(wheel.object(0x1800, 1), 0x40000185u);
  EXPECT_EQ(wheel.object(0x1800, 2), 1u);
  EXPECT_EQ(wheel.object(0x1801, 1), 0x40000285u);
  EXPECT_EQ(wheel.object(0x1802, 1), 0x40000385u);
  EXPECT_EQ(wheel.object(0x1802, 5), 1'000u);
  EXPECT_EQ(wheel.object(0x1A00, 3), 0x60780010u);
  EXPECT_EQ(wheel.object(0x1A01, 2), 0x21000220u);
  CanNode& steering = world.steering(2);
  EXPECT_EQ(steering.object(0x6060), 1u);
  EXPECT_EQ(steering.object(0x6081), 250'000u);
  EXPECT_EQ(steering.object(0x6083), 1'000'000u);
  EXPECT_EQ(steering.object(0x1A01), 1u);
  EXPECT_EQ(steering.object(0x1A01, 1), 0x21000320u);
  EXPECT_EQ(world.io().object(0x6206, 1), 0x40u);
  EXPECT_EQ(world.io().object(0x6207, 1), 0x40u);
  EXPECT_EQ(world.io().object(0x1800, 2), 254u);
  EXPECT_EQ(world.io().object(0x1800, 3), 20u);
  EXPECT_EQ(world.imu().object(0x1A00), 4u);
}

TEST(RoverBoot, ANodeThatIsNotThereIsMissingAndTriedAgainWhileTheOthersRun) {
  RoverWorld world;
  world.wheel(2).powered = false;
  world.orders.standing = true;
  world.run_frames(30);
  EXPECT_EQ(world.state(2), NodeState::missing);
  EXPECT_EQ(world.state(3), NodeState::operational);
  world.sent.clear();
  world.run_frames(60);
  EXPECT_EQ(world.sent_with(0x000).size(), 2u) << "two seconds for it to boot, one to the next";
  world.wheel(2).powered = true;
  world.wheel(2).reboot(world.now);
  world.run_frames(5);
  EXPECT_EQ(world.state(2), NodeState::operational);
}

TEST(RoverBoot, AnotherDeviceIsNotStarted) {
  RoverWorld world;
  world.steering(1).object(0x1000) = 0x0002'0192;
  world.orders.standing = true;
  world.run_frames(20);
  const auto& status = world.link(kFirstSteering + 1).node;
  EXPECT_EQ(status.state, NodeState::wrong_device);
  EXPECT_EQ(status.found_type, 0x0002'0192u);
  EXPECT_EQ(world.steering(1).nmt, CanNode::Nmt::pre_operational);
  EXPECT_EQ(world.steering(1).object(0x1017), 0u) << "nothing is written into it";
  world.steering(1).object(0x1000) = 0x0004'0192;
  world.run_frames(55);
  EXPECT_EQ(world.state(kFirstSteering + 1), NodeState::operational) << "it is asked again";
}

TEST(RoverBoot, ARefusedObjectIsReportedWithItsAbortCodeAndTriedAgain) {
  RoverWorld world;
  world.wheel(5).refused.insert(0x6084 << 8);
  world.orders.standing = true;
  world.run_frames(20);
  const RoverLink link = world.link(5);
  EXPECT_EQ(link.node.failed_entry, (canopen::Entry{0x6084, 0, 4, 8'000}));
  EXPECT_EQ(link.node.abort_code, 0x06090030u);
  EXPECT_GE(link.sdo_aborts, 1u);
  EXPECT_NE(link.node.state, NodeState::operational);
  world.wheel(5).refused.clear();
  world.run_frames(20);
  EXPECT_EQ(world.state(5), NodeState::operational);
}

TEST(RoverBoot, AnSdoAnswerThatGotLostIsAskedForAgain) {
  RoverWorld world;
  world.imu().ignored_requests = 2;
  world.run_for(2 * kSecond);
  EXPECT_EQ(world.state(kImu), NodeState::operational);
  EXPECT_EQ(world.link(kImu).sdo_repeats, 2u);
  EXPECT_EQ(world.link(kImu).sdo_aborts, 0u);
}

TEST(RoverBoot, NoSdoAnswerAtAllIsAFailedBoot) {
  RoverWorld world;
  world.io().ignored_requests = 3;
  world.run_for(1'300 * kMillisecond);
  EXPECT_EQ(world.state(kIo), NodeState::failed);
  EXPECT_EQ(world.link(kIo).node.abort_code, canopen::kAbortTimeout);
  EXPECT_EQ(world.link(kIo).node.failed_entry.index, 0x1000);
  world.run_for(2 * kSecond);
  EXPECT_EQ(world.state(kIo), NodeState::operational);
}

// A restart of a killed daemon must not let a rover on a slope roll.
TEST(RoverBoot, DrivesThatHoldAndClutchesAreLeftAsTheyAre) {
  RoverWorld world;
  world.boot();
  world.drive(1'000);
  world.bus = RoverBus(world.parameters);
  world.bus.restart(world.now);
  for (int n = 0; n < 20; ++n) {
    world.run_for(100 * kMillisecond);
    for (std::size_t i = 0; i < kWheels; ++i) {
      EXPECT_EQ(world.wheel(i).drive, CanNode::Drive::quick_stop) << i;
    }
    EXPECT_EQ(world.io().object(0x6200, 1), 0x3Fu);
  }
  for (std::size_t i = 0; i < kNodes; ++i) EXPECT_EQ(world.state(i), NodeState::operational) << i;
}

TEST(RoverBoot, ANodeIsResetAsAWholeWhenOrdered) {
  RoverWorld world;
  world.boot();
  world.orders.clutches = 0x3F;
  world.run_frames(1);
  world.sent.clear();
  world.orders.reset_nodes = 1u << 3 | 1u << kIo;
  ++world.orders.node_reset_serial;
  world.release();
  const auto resets = world.sent_with(0x000);
  ASSERT_EQ(resets.size(), 2u);
  EXPECT_EQ(data_of(resets[0]), (Bytes{0x81, 0x04}));
  EXPECT_EQ(data_of(resets[1]), (Bytes{0x81, 0x20}));
  EXPECT_EQ(world.io().object(0x6200, 1), 0u);
  world.run_frames(10);
  EXPECT_EQ(world.sent_with(0x000).size(), 4u) << "once, and two starts";
  EXPECT_EQ(world.state(3), NodeState::operational);
  EXPECT_EQ(world.io().object(0x6200, 1), 0x3Fu);
  EXPECT_EQ(world.link(3).node.reboots, 0u) << "that was asked for";
}

TEST(RoverBoot, ARestartBootsEverythingAgain) {
  RoverWorld world;
  world.boot();
  world.drive(1'000);
  world.bus.restart(world.now);
  for (std::size_t i = 0; i < kNodes; ++i) EXPECT_EQ(world.state(i), NodeState::off);
  world.pump();
  for (std::size_t i = 0; i < kIo; ++i) EXPECT_EQ(world.node[i].quick_stops, 1) << i;
  for (int n = 0; n < 10; ++n) {
    world.release(false);
    world.run_for(world.parameters.period_ns);
  }
  for (std::size_t i = 0; i < kNodes; ++i) EXPECT_EQ(world.state(i), NodeState::operational) << i;
  for (std::size_t i = 0; i < kWheels; ++i) {
    EXPECT_NE(world.wheel(i).drive, CanNode::Drive::enabled) << "by orders from before";
  }
  world.run_frames(6);
  EXPECT_EQ(world.wheel(0).target(), 1'000) << "by new orders";
}

TEST(RoverBoot, TwoNodesOfOneNumberGetNoMessages) {
  RoverBusParameters parameters;
  parameters.wheel_node[3] = parameters.wheel_node[0];
  RoverBus bus(parameters);
  EXPECT_FALSE(bus.parameters_fit());
  CanFrame frame;
  for (TimeNs now = kSecond; now < 10 * kSecond; now += 10 * kMillisecond) {
    while (bus.transmit(now, frame)) EXPECT_TRUE(frame.id == 0x080 || frame.id == 0x77F);
  }
  RoverBusParameters master;
  master.master_node = 0x20;
  EXPECT_FALSE(RoverBus(master).parameters_fit());
  EXPECT_TRUE(RoverBus({}).parameters_fit());
}

}  // namespace
}  // namespace lss::ardito
