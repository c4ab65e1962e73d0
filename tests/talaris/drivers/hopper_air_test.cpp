// The CAN bus of docs/icd-talaris.md in the air: after an outage, and when the master's memory is
// damaged.

#include <gtest/gtest.h>

#include <cstring>

#include "tests/talaris/drivers/hopper_world.h"

namespace lss::talaris {
namespace {

// Boots it; in the air, by its orders, with the fans on.
void boot_flying(HopperWorld& world) {
  world.boot();
  world.orders.boot_allowed = false;
  world.orders.fan_us = {1700, 1700, 1700, 1700};
  world.run_frames(2);
  world.sent.clear();
}

// Neither is a node reset nor are fans ordered to stop.
void expect_no_break(HopperWorld& world) {
  EXPECT_GE(world.sent_with(0x221).size(), 5u);
  for (const CanFrame& f : world.sent_with(0x221)) EXPECT_EQ(f.data[0] | f.data[1] << 8, 1700);
  for (const CanFrame& f : world.sent_with(0x000)) EXPECT_EQ(f.data[0], 1) << "start only";
  for (const CanFrame& f : world.sent_with(0x220)) EXPECT_NE(f.data[1], 0);
}

TEST(HopperBus, InTheAirABusThatWasOpenedAgainKeepsTheOrders) {
  HopperWorld world;
  boot_flying(world);
  const int resets = world.valve_node().resets + world.fan_node().resets;
  world.bus.reopened(world.now);
  world.run_for(150 * kMillisecond);
  expect_no_break(world);
  EXPECT_EQ(world.fan_node().fan_us[0], 1700);
  EXPECT_EQ(world.fan_node().forgotten, 0);
  EXPECT_EQ(world.valve_node().resets + world.fan_node().resets, resets);
  EXPECT_EQ(world.state(kFanNode), NodeState::operational);
  world.orders.all_stop = true;
  world.release();
  world.bus.reopened(world.now);
  world.run_for(100 * kMillisecond);
  EXPECT_EQ(world.fan_node().fan_us[0], 1000);
}

TEST(HopperBus, InTheAirNodesThatFellBackDuringAnOutageAreBootedWithoutAReset) {
  HopperWorld world;
  boot_flying(world);
  const int resets = world.valve_node().resets + world.fan_node().resets;
  world.master_dead = world.actuate_dead = true;
  world.run_for(300 * kMillisecond);
  ASSERT_EQ(world.fan_node().master_lost, 1);
  world.master_dead = world.actuate_dead = false;
  world.bus.reopened(world.now);  // the orders are too old now, but newer ones wait
  world.release();
  world.run_for(150 * kMillisecond);
  expect_no_break(world);
  EXPECT_EQ(world.state(kFanNode), NodeState::operational);
  EXPECT_EQ(world.fan_node().fan_us[0], 1700);
  EXPECT_EQ(world.valve_node().resets + world.fan_node().resets, resets);
}

// Both copies are damaged.
void damage(HopperWorld& world) {
  const HopperStatus said = world.bus.status();
  std::memset(static_cast<void*>(&world.bus), 0xA5, sizeof world.bus);
  world.bus.begin_again(world.parameters, said, world.orders, world.now);
}

TEST(HopperBus, InTheAirDamagedMemoryStopsNothing) {
  HopperWorld world;
  boot_flying(world);
  const int resets = world.valve_node().resets + world.fan_node().resets;
  const std::uint64_t boots = world.bus.status().link[kFanNode].node.boots;
  damage(world);
  world.run_for(150 * kMillisecond);
  expect_no_break(world);
  EXPECT_EQ(world.fan_node().fan_us[0], 1700);
  EXPECT_EQ(world.fan_node().forgotten, 0);
  world.run_frames(5);
  EXPECT_EQ(world.fan_node().master_lost + world.valve_node().master_lost, 0);
  EXPECT_EQ(world.valve_node().resets + world.fan_node().resets, resets);
  EXPECT_EQ(world.state(kValveNode), NodeState::operational);
  EXPECT_EQ(world.state(kFanNode), NodeState::operational);
  EXPECT_EQ(world.bus.status().link[kFanNode].node.boots, boots);
  EXPECT_EQ(world.counters().safe_commands, 0u);
}

// What a node is not any more is found by its heartbeats, as before.
TEST(HopperBus, InTheAirANodeThatIsSilentAfterDamagedMemoryIsLost) {
  HopperWorld world;
  boot_flying(world);
  world.fan_node().mute = true;
  damage(world);
  world.run_for(250 * kMillisecond);
  EXPECT_EQ(world.state(kFanNode), NodeState::lost);
  EXPECT_EQ(world.state(kValveNode), NodeState::operational);
}

TEST(HopperBus, OnTheGroundDamagedMemoryStopsEverythingUntilTheNextRelease) {
  HopperWorld world;
  world.boot();
  world.orders.fan_us = {1800, 1800, 1800, 1800};
  world.run_frames(1);
  damage(world);
  world.sent.clear();
  world.run_for(30 * kMillisecond);
  EXPECT_EQ(world.sent[0].id, 0x220u);
  EXPECT_EQ(world.fan_node().fan_us[0], 1000);
  world.run_frames(5);
  EXPECT_EQ(world.state(kFanNode), NodeState::operational);
  EXPECT_EQ(world.fan_node().fan_us[0], 1800);
}

}  // namespace
}  // namespace lss::talaris
