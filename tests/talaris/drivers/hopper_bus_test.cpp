// The CAN bus of docs/icd-talaris.md: boot, sent and received messages, and the causes of shut
// valves.

#include "drivers/talaris/hopper_bus.h"

#include <gtest/gtest.h>

#include "tests/support/allocations.h"
#include "tests/support/can_frames.h"
#include "tests/talaris/drivers/hopper_world.h"

namespace lss::talaris {
namespace {

using testing_support::data_of;
using testing_support::frame;
using Write = HopperNode::Write;

TEST(HopperBus, ShutAndOffComeFirst) {
  HopperWorld world;
  world.run_for(kSecond);
  ASSERT_GE(world.sent.size(), 4u);
  EXPECT_EQ(world.sent[0].id, 0x220u);
  EXPECT_EQ(data_of(world.sent[0]), (testing_support::Bytes{0, 0}));
  EXPECT_EQ(world.sent[1].id, 0x221u);
  EXPECT_EQ(data_of(world.sent[1]), (testing_support::Bytes{0xE8, 3, 0xE8, 3, 0xE8, 3, 0xE8, 3}));
  const auto resets = world.sent_with(0x000);
  ASSERT_GE(resets.size(), 2u);
  EXPECT_EQ(resets[0].time_ns, kSecond + 50 * kMillisecond);
  EXPECT_EQ(data_of(resets[0]), (testing_support::Bytes{0x82, 0x20}));
  EXPECT_EQ(data_of(resets[1]), (testing_support::Bytes{0x82, 0x21}));
  // And until there are orders, again and again.
  EXPECT_GE(world.sent_with(0x220).size(), 20u);
  for (const CanFrame& f : world.sent_with(0x220)) EXPECT_EQ(f.data[0] | f.data[1], 0);
}

TEST(HopperBus, NodesAreConfiguredAsTheDocumentSays) {
  HopperWorld world({.load_cell = true});
  world.boot();
  const std::vector<Write> valves = {
      {0x1017, 0, 2, 50},          {0x1016, 1, 4, 0x007F'0064}, {0x1015, 0, 2, 100},
      {0x1029, 1, 1, 0},           {0x6206, 1, 1, 0xFF},        {0x6207, 1, 1, 0},
      {0x2201, 0, 2, 250},         {0x1400, 1, 4, 0x8000'0220}, {0x1600, 0, 1, 0},
      {0x1600, 1, 4, 0x6200'0108}, {0x1600, 2, 4, 0x2200'0008}, {0x1600, 0, 1, 2},
      {0x1400, 2, 1, 255},         {0x1400, 1, 4, 0x220},       {0x1801, 1, 4, 0xC000'02A0},
      {0x1A01, 0, 1, 0},           {0x1A01, 1, 4, 0x6401'0110}, {0x1A01, 2, 4, 0x6401'0210},
      {0x1A01, 3, 4, 0x6401'0310}, {0x1A01, 4, 4, 0x6401'0410}, {0x1A01, 0, 1, 4},
      {0x1801, 2, 1, 255},         {0x1801, 5, 2, 200},         {0x1801, 1, 4, 0x4000'02A0}};
  EXPECT_EQ(world.node[0].writes, valves);
  const std::vector<Write> fans = {
      {0x1017, 0, 2, 50},          {0x1016, 1, 4, 0x007F'0064}, {0x1015, 0, 2, 100},
      {0x1029, 1, 1, 0},           {0x6443, 1, 1, 1},           {0x6443, 2, 1, 1},
      {0x6443, 3, 1, 1},           {0x6443, 4, 1, 1},           {0x6444, 1, 4, 1000},
      {0x6444, 2, 4, 1000},        {0x6444, 3, 4, 1000},        {0x6444, 4, 4, 1000},
      {0x2201, 0, 2, 250},         {0x2202, 0, 2, 2000},        {0x1400, 1, 4, 0x8000'0221},
      {0x1600, 0, 1, 0},           {0x1600, 1, 4, 0x6411'0110}, {0x1600, 2, 4, 0x6411'0210},
      {0x1600, 3, 4, 0x6411'0310}, {0x1600, 4, 4, 0x6411'0410}, {0x1600, 0, 1, 4},
      {0x1400, 2, 1, 255},         {0x1400, 1, 4, 0x221},       {0x1800, 1, 4, 0xC000'01A1},
      {0x1A00, 0, 1, 0},           {0x1A00, 1, 4, 0x6401'0110}, {0x1A00, 2, 4, 0x6401'0210},
      {0x1A00, 3, 4, 0x6401'0310}, {0x1A00, 4, 4, 0x6401'0410}, {0x1A00, 0, 1, 4},
      {0x1800, 2, 1, 255},         {0x1800, 5, 2, 20},          {0x1800, 1, 4, 0x4000'01A1}};
  EXPECT_EQ(world.node[1].writes, fans);
  const std::vector<Write> load = {
      {0x1017, 0, 2, 50},          {0x1016, 1, 4, 0x007F'0064}, {0x1015, 0, 2, 100},
      {0x1029, 1, 1, 0},           {0x1800, 1, 4, 0xC000'01A2}, {0x1A00, 0, 1, 0},
      {0x1A00, 1, 4, 0x6401'0110}, {0x1A00, 2, 4, 0x6401'0210}, {0x1A00, 3, 4, 0x6401'0310},
      {0x1A00, 0, 1, 3},           {0x1800, 2, 1, 255},         {0x1800, 5, 2, 2},
      {0x1800, 1, 4, 0x4000'01A2}, {0x1801, 1, 4, 0xC000'02A2}, {0x1A01, 0, 1, 0},
      {0x1A01, 1, 4, 0x6401'0410}, {0x1A01, 2, 4, 0x6401'0510}, {0x1A01, 3, 4, 0x6401'0610},
      {0x1A01, 0, 1, 3},           {0x1801, 2, 1, 255},         {0x1801, 5, 2, 2},
      {0x1801, 1, 4, 0x4000'02A2}};
  EXPECT_EQ(world.node[2].writes, load);
}

TEST(HopperBus, WithoutALoadCellNobodySpeaksToIt) {
  HopperWorld world;
  world.boot();
  world.run_frames(10);
  for (const CanFrame& f : world.sent) EXPECT_NE(f.id & 0x7F, 0x22u);
  EXPECT_EQ(world.state(kLoadCellNode), NodeState::off);
}

TEST(HopperBus, AnotherDeviceIsNotStarted) {
  HopperWorld world;
  world.valve_node().device_type = 0x0007'0191;
  world.run_frames(10);
  EXPECT_EQ(world.state(kValveNode), NodeState::wrong_device);
  EXPECT_EQ(world.state(kFanNode), NodeState::operational);
}

TEST(HopperBus, AConfigurationThatIsRefusedIsTried) {
  HopperWorld world;
  world.valve_node().refused.insert(0x2201'00);
  world.run_frames(5);
  EXPECT_EQ(world.state(kValveNode), NodeState::failed);
  EXPECT_EQ(world.bus.status().link[kValveNode].node.failed_entry.index, 0x2201);
  EXPECT_EQ(world.bus.status().link[kValveNode].sdo_aborts, 1u);
  world.valve_node().refused.clear();
  world.run_frames(15);
  EXPECT_EQ(world.state(kValveNode), NodeState::operational);
}

TEST(HopperBus, OurHeartbeatComesEveryTwentyFiveMillisecondsAndNoSync) {
  HopperWorld world;
  world.boot();
  const TimeNs begin = world.now;
  world.run_frames(10);
  const auto beats = world.sent_with(0x77F);
  EXPECT_EQ(beats.size(), 80u);
  for (std::size_t i = 1; i < beats.size(); ++i) {
    EXPECT_EQ(beats[i].time_ns - beats[i - 1].time_ns, 25 * kMillisecond);
  }
  EXPECT_GE(beats[0].time_ns, begin);
  EXPECT_TRUE(world.sent_with(0x080).empty());
}

TEST(HopperBus, FansAreSaidAtTheReleaseAndEveryTwentyMilliseconds) {
  HopperWorld world;
  world.boot();
  world.orders.fan_us = {1700, 1700, 1710, 1690};
  world.run_frames(3);
  const auto said = world.sent_with(0x221);
  EXPECT_GE(said.size(), 30u);
  EXPECT_LE(said.size(), 33u);
  for (const CanFrame& f : said) {
    EXPECT_EQ(data_of(f), (testing_support::Bytes{0xA4, 6, 0xA4, 6, 0xAE, 6, 0x9A, 6}));
  }
  EXPECT_EQ(world.fan_node().fan_us, (std::array<std::uint16_t, 4>{1700, 1700, 1710, 1690}));
  EXPECT_EQ(world.fan_node().forgotten, 0);
}

TEST(HopperBus, WidthsBeyondTheRangeAreCutAndCounted) {
  HopperWorld world;
  world.boot();
  world.orders.fan_us = {0, 2500, 1500, 1000};
  world.run_frames(1);
  EXPECT_EQ(world.fan_node().fan_us, (std::array<std::uint16_t, 4>{1000, 2000, 1500, 1000}));
  EXPECT_EQ(world.counters().bad_orders, 2u);
}

TEST(HopperBus, ValvesAreLeftToTheOtherThread) {
  HopperWorld world;
  world.boot();
  world.actuate_dead = true;
  world.run_frames(5);
  EXPECT_TRUE(world.sent_with(0x220).empty());
}

TEST(HopperBus, BothThreadsTogetherPulseTheValves) {
  HopperWorld world;
  world.boot();
  world.orders.pulse[0] = {50 * kMillisecond, 100 * kMillisecond};
  world.orders.pulse[7] = {0, 180 * kMillisecond};
  world.valve_node().sequences.clear();
  world.release();
  EXPECT_EQ(world.valve_node().valves, 0x80);
  world.run_for(51 * kMillisecond);
  EXPECT_EQ(world.valve_node().valves, 0x81);
  world.run_for(100 * kMillisecond);
  EXPECT_EQ(world.valve_node().valves, 0x80);
  world.run_for(30 * kMillisecond);
  EXPECT_EQ(world.valve_node().valves, 0x00);
  EXPECT_EQ(world.valve_node().repeated, 0);
  const auto& seen = world.valve_node().sequences;
  for (std::size_t i = 1; i < seen.size(); ++i) EXPECT_EQ(seen[i], seen[i - 1] % 255 + 1);
}

// Boots it, and holds a valve open.
void boot_holding(HopperWorld& world) {
  world.boot();
  world.orders.hold[2] = {true, world.now + 10 * kSecond};
}

TEST(HopperBus, AValveHeldOpenIsRenewedInTime) {
  HopperWorld world;
  boot_holding(world);
  for (int n = 0; n < 25; ++n) {
    world.run_frames(1);
    ASSERT_EQ(world.valve_node().valves, 0x04);
  }
  EXPECT_EQ(world.valve_node().forgotten, 0);
}

TEST(HopperBus, WithoutTheActuateThreadTheNodeForgets) {
  HopperWorld world;
  boot_holding(world);
  world.release();
  world.actuate_dead = true;
  world.run_for(240 * kMillisecond);
  EXPECT_EQ(world.valve_node().valves, 0x04);
  world.run_for(20 * kMillisecond);
  EXPECT_EQ(world.valve_node().valves, 0);
  EXPECT_EQ(world.valve_node().forgotten, 1);
}

TEST(HopperBus, WithoutTheMasterEverythingIsShutWithinAHundredMilliseconds) {
  HopperWorld world;
  boot_holding(world);
  world.orders.fan_us = {1800, 1800, 1800, 1800};
  world.run_frames(2);
  ASSERT_EQ(world.valve_node().valves, 0x04);
  world.master_dead = true;  // the valves are renewed still
  world.run_for(101 * kMillisecond);
  EXPECT_EQ(world.valve_node().valves, 0);
  EXPECT_EQ(world.fan_node().fan_us[0], 1000);
  EXPECT_EQ(world.valve_node().master_lost, 1);
}

TEST(HopperBus, StaleOrdersShutEverythingByThisThreadToo) {
  HopperWorld world;
  boot_holding(world);
  world.orders.fan_us = {1800, 1800, 1800, 1800};
  world.release();
  world.sent.clear();
  world.run_for(world.parameters.stale_after_ns);
  EXPECT_EQ(world.valve_node().valves, 0x04);
  EXPECT_EQ(world.fan_node().fan_us[0], 1800);
  world.run_for(kMillisecond);
  EXPECT_EQ(world.valve_node().valves, 0);
  EXPECT_EQ(world.fan_node().fan_us[0], 1000);
  EXPECT_EQ(world.counters().safe_commands, 1u);
  world.sent.clear();
  world.run_for(kSecond);
  EXPECT_GE(world.sent_with(0x220).size(), 20u);  // again and again
  for (const CanFrame& f : world.sent_with(0x220)) EXPECT_EQ(f.data[0], 0);
  world.run_frames(1);
  EXPECT_EQ(world.fan_node().fan_us[0], 1800);  // new orders count again
}

// Of three frames the second does not come in time: its orders would have been released with the
// third's at the earliest.
TEST(HopperBus, OneLateFrameShutsNothing) {
  HopperWorld world;
  boot_holding(world);
  world.orders.fan_us = {1800, 1800, 1800, 1800};
  world.release();
  world.run_for(415 * kMillisecond);  // offset and grace behind two periods
  EXPECT_EQ(world.valve_node().valves, 0x04);
  EXPECT_EQ(world.fan_node().fan_us[0], 1800);
  world.release();
  world.run_for(415 * kMillisecond);
  EXPECT_EQ(world.counters().safe_commands, 0u);
  EXPECT_EQ(world.valves.counters().stale, 0u);
  EXPECT_EQ(world.valve_node().valves, 0x04);
}

TEST(HopperBus, OrdersThatAreTooOldWhenTheyComeShut) {
  HopperWorld world;
  world.boot();
  TalarisOrders old = world.orders;
  old.fan_us = {1800, 1800, 1800, 1800};
  old.issued_ns = world.now - world.parameters.stale_after_ns - 1;
  world.bus.release(old, world.now);
  world.pump();
  EXPECT_EQ(world.fan_node().fan_us[0], 1000);
  EXPECT_EQ(world.counters().stale_orders, 1u);
}

TEST(HopperBus, AnAllStopShutsAndTurnsOff) {
  HopperWorld world;
  world.boot();
  world.orders.fan_us = {1800, 1800, 1800, 1800};
  world.run_frames(1);
  world.orders.all_stop = true;
  world.actuate_dead = true;
  world.sent.clear();
  world.release();
  ASSERT_GE(world.sent.size(), 2u);
  EXPECT_EQ(world.sent[0].id, 0x220u);
  EXPECT_EQ(data_of(world.sent[0]), (testing_support::Bytes{0, 0}));
  EXPECT_EQ(world.fan_node().fan_us[0], 1000);
  world.run_for(150 * kMillisecond);
  EXPECT_GE(world.sent_with(0x220).size(), 4u);
  for (const CanFrame& f : world.sent_with(0x221)) EXPECT_EQ(f.data[0] | f.data[1] << 8, 1000);
}

TEST(HopperBus, AnAllStopSoonAfterAnotherShutsAtOnceToo) {
  HopperWorld world;
  world.boot();
  world.orders.all_stop = true;
  world.release();
  world.run_for(10 * kMillisecond);
  world.orders.all_stop = false;
  world.release();
  world.run_for(10 * kMillisecond);
  world.actuate_dead = true;
  world.orders.all_stop = true;
  world.sent.clear();
  world.release();
  EXPECT_EQ(world.sent_with(0x220).size(), 1u);
}

TEST(HopperBus, ABusThatWasOpenedAgainForgetsTheOrders) {
  HopperWorld world;
  world.boot();
  world.orders.fan_us = {1800, 1800, 1800, 1800};
  world.run_frames(1);
  world.sent.clear();
  world.bus.reopened(world.now);
  world.run_for(30 * kMillisecond);
  EXPECT_EQ(world.sent[0].id, 0x220u);
  for (const CanFrame& f : world.sent_with(0x221)) EXPECT_EQ(f.data[0] | f.data[1] << 8, 1000);
  EXPECT_EQ(world.fan_node().fan_us[0], 1000);
  world.run_frames(5);
  EXPECT_EQ(world.state(kFanNode), NodeState::operational);
  EXPECT_EQ(world.fan_node().fan_us[0], 1800);
}

TEST(HopperBus, ANodeIsResetOncePerOrder) {
  HopperWorld world;
  world.boot();
  world.orders.node_reset_serial = 1;
  world.orders.reset_nodes = 1u << kFanNode;
  const int before = world.fan_node().resets, others = world.valve_node().resets;
  world.run_frames(5);
  EXPECT_EQ(world.fan_node().resets, before + 1);
  EXPECT_EQ(world.valve_node().resets, others);
  EXPECT_EQ(world.state(kFanNode), NodeState::operational);
}

TEST(HopperBus, ALostNodeIsBootedWhenTheOrdersAllowIt) {
  HopperWorld world;
  world.boot();
  world.orders.boot_allowed = false;
  world.fan_node().mute = true;
  world.run_for(140 * kMillisecond);
  world.release();
  EXPECT_EQ(world.state(kFanNode), NodeState::operational);
  world.run_for(65 * kMillisecond);
  EXPECT_EQ(world.state(kFanNode), NodeState::lost);
  world.fan_node().mute = false;
  world.fan_node().power_on(world.now);  // it was the power
  world.run_frames(10);
  EXPECT_NE(world.state(kFanNode), NodeState::operational);
  world.orders.boot_allowed = true;
  world.run_frames(15);
  EXPECT_EQ(world.state(kFanNode), NodeState::operational);
}

// The daemon stood still in the air: nodes shut by themselves and are brought up again, without a
// reset and shut until the next order.
TEST(HopperBus, NodesThatFellBackAreBroughtUpAgainInTheAir) {
  HopperWorld world;
  world.boot();
  world.orders.boot_allowed = false;
  world.orders.hold[0] = {true, world.now + 10 * kSecond};
  world.orders.fan_us = {1700, 1700, 1700, 1700};
  world.run_frames(2);
  const int resets = world.valve_node().resets + world.fan_node().resets;
  world.master_dead = world.actuate_dead = true;
  world.run_for(150 * kMillisecond);
  EXPECT_EQ(world.valve_node().valves, 0);
  EXPECT_EQ(world.fan_node().fan_us[0], 1000);
  world.master_dead = world.actuate_dead = false;
  world.release();
  world.run_for(10 * kMillisecond);
  EXPECT_EQ(world.fan_node().fan_us[0], 1000);  // its configuration takes longer
  EXPECT_EQ(world.valve_node().valves, 0);
  world.run_for(140 * kMillisecond);
  EXPECT_EQ(world.state(kFanNode), NodeState::operational);
  EXPECT_EQ(world.state(kValveNode), NodeState::operational);
  EXPECT_EQ(world.fan_node().fan_us[0], 1700);
  EXPECT_EQ(world.valve_node().valves, 0x01);
  EXPECT_EQ(world.valve_node().resets + world.fan_node().resets, resets);
  EXPECT_EQ(world.fan_node().master_lost, 1);
}

TEST(HopperBus, NodesThatAreToBeStoppedAreNotBootedAgain) {
  HopperWorld world;
  world.boot();
  world.orders.boot_allowed = false;
  world.orders.all_stop = true;
  world.release();
  world.master_dead = true;
  world.run_for(150 * kMillisecond);
  world.master_dead = false;
  world.run_frames(5);
  EXPECT_EQ(world.state(kFanNode), NodeState::fallen_back);
  EXPECT_EQ(world.state(kValveNode), NodeState::fallen_back);
}

TEST(HopperBus, TwoNodesOfOneNumberAreRefused) {
  HopperBusParameters twice;
  twice.node[kFanNode] = 0x20;
  EXPECT_FALSE(HopperBus(twice).parameters_fit());
}

TEST(HopperBus, NothingAllocates) {
  HopperWorld world({.load_cell = true});
  world.boot();
  std::array<TalarisSample, HopperBus::kMaxSamples> samples;
  CanFrame f;
  const CanFrame speeds = frame(0x1A1, {1, 2, 3, 4, 5, 6, 7, 8}, world.now);
  const CanFrame forces = frame(0x1A2, {1, 2, 3, 4, 5, 6}, world.now);
  const CanFrame moments = frame(0x2A2, {1, 2, 3, 4, 5, 6}, world.now);
  std::size_t heard = 0;
  const std::uint64_t before = testing_support::allocations();
  for (int n = 0; n < 500; ++n) {
    world.now += 2 * kMillisecond;
    if (n % 100 == 0) {
      world.orders.issued_ns = world.now;
      world.bus.release(world.orders, world.now);
    }
    while (world.bus.transmit(world.now, f)) {
    }
    for (CanFrame in : {speeds, forces, moments}) {
      in.time_ns = world.now;
      world.bus.receive({&in, 1});
    }
    heard += world.bus.take(samples);
    (void)world.bus.status();
  }
  EXPECT_EQ(testing_support::allocations(), before);
  EXPECT_GT(heard, 50u);
}

}  // namespace
}  // namespace lss::talaris
