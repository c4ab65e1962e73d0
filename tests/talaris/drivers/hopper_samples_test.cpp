// Messages received on the CAN bus of docs/icd-talaris.md, in SI units.

#include <gtest/gtest.h>

#include <algorithm>

#include "drivers/talaris/hopper_bus.h"
#include "tests/support/can_frames.h"
#include "tests/talaris/drivers/hopper_world.h"

namespace lss::talaris {
namespace {

using testing_support::frame;

void set(std::array<std::uint8_t, 8>& data, std::initializer_list<int> bytes) {
  std::transform(bytes.begin(), bytes.end(), data.begin(),
                 [](int byte) { return static_cast<std::uint8_t>(byte); });
}

// Of one kind, from five frames.
template <class Reading>
auto samples_of(HopperWorld& world) {
  world.boot();
  world.run_frames(5);
  return only<Reading>(world.take_all());
}

TEST(HopperBus, PressuresVoltageAndTemperatureInSiUnits) {
  HopperWorld world;
  set(world.node[0].data[1], {0xCC, 0x50, 0x63, 0x05, 0x65, 0x09, 0xD7, 0x00});
  const auto got = samples_of<GasState>(world);
  ASSERT_EQ(got.size(), 5u);
  EXPECT_DOUBLE_EQ(got[0].second.tank_Pa, 20.684e6);
  EXPECT_DOUBLE_EQ(got[0].second.regulated_Pa, 1.379e6);
  EXPECT_DOUBLE_EQ(got[0].second.voltage_V, 24.05);
  EXPECT_DOUBLE_EQ(got[0].second.temperature_degC, 21.5);
  EXPECT_EQ(got[1].first - got[0].first, 200 * kMillisecond);
}

TEST(HopperBus, FanSpeedsEveryTwentyMilliseconds) {
  HopperWorld world;
  set(world.node[1].data[0], {0xD8, 0x72, 0xD8, 0x72, 0xA0, 0x73, 0x10, 0x72});
  const auto got = samples_of<FanSpeeds>(world);
  ASSERT_EQ(got.size(), 50u);
  EXPECT_EQ(got[0].second.rpm, (std::array<double, 4>{29400, 29400, 29600, 29200}));
}

// 200 messages in 100 ms are no babbling, and 400 in a frame more than a frame has room for.
TEST(HopperBus, ANodeThatSendsMuchTooOftenDisplacesNoOther) {
  for (const bool fans_flood : {true, false}) {
    HopperWorld world;
    world.boot();
    for (HopperNode& n : world.node) n.mute = true;  // from here on by hand
    world.take_all();
    const std::uint64_t before = world.counters().overflows;
    const TimeNs begin = world.now + 200 * kMillisecond;
    for (int half_ms = 0; half_ms < 400; ++half_ms) {
      const auto hear = [&](std::uint32_t id) {
        const TimeNs at = begin + half_ms * kMillisecond / 2;
        const CanFrame f = frame(id, {1, 0, 2, 0, 3, 0, 4, 0}, at);
        world.bus.receive({&f, 1});
      };
      if (fans_flood || half_ms % 40 == 0) hear(0x1A1);
      if (!fans_flood || half_ms == 300) hear(0x2A0);
    }
    const std::vector<TalarisSample> all = world.take_all();
    EXPECT_EQ(only<FanSpeeds>(all).size(), fans_flood ? 28u : 10u);
    EXPECT_EQ(only<GasState>(all).size(), fans_flood ? 1u : 10u);
    EXPECT_EQ(world.counters().overflows - before, fans_flood ? 372u : 390u);
    EXPECT_EQ(world.state(kFanNode), NodeState::operational);
  }
}

TEST(HopperBus, ForcesAndMomentsOfOneMomentAreOneSample) {
  HopperWorld world({.load_cell = true});
  set(world.node[2].data[0], {0x81, 0x01, 0xFC, 0xFF, 0x0C, 0x00});
  set(world.node[2].data[1], {0xF9, 0xFF, 0x00, 0x00, 0x97, 0x00});
  world.boot();
  world.run_frames(1);
  const auto got = only<Load>(world.take_all());
  ASSERT_EQ(got.size(), 100u);  // 500 Hz
  EXPECT_NEAR(got[0].second.force_N[0], 38.5, 1e-12);
  EXPECT_NEAR(got[0].second.force_N[1], -0.4, 1e-12);
  EXPECT_NEAR(got[0].second.force_N[2], 1.2, 1e-12);
  EXPECT_NEAR(got[0].second.moment_Nm[0], -0.07, 1e-12);
  EXPECT_NEAR(got[0].second.moment_Nm[2], 1.51, 1e-12);
  EXPECT_EQ(world.counters().load_unpaired, 0u);
  EXPECT_EQ(world.state(kLoadCellNode), NodeState::operational);  // not babbling
}

TEST(HopperBus, HalvesOfTheLoadThatLostTheOtherAreNotMixed) {
  HopperWorld world({.load_cell = true});
  world.boot();
  for (HopperNode& n : world.node) n.mute = true;  // from here on by hand
  world.run_for(2 * kMillisecond);
  world.take_all();
  const std::uint64_t before = world.counters().load_unpaired;
  const auto hear = [&world](std::uint32_t id, int value, TimeNs at) {
    CanFrame f = frame(id, {static_cast<std::uint8_t>(value), 0, 0, 0, 0, 0}, at);
    world.bus.receive({&f, 1});
  };
  const TimeNs t = world.now;
  hear(0x1A2, 10, t);
  hear(0x1A2, 20, t + 2 * kMillisecond);  // the moments of the first are lost
  hear(0x2A2, 30, t + 2 * kMillisecond);
  hear(0x2A2, 40, t + 4 * kMillisecond);  // the forces are lost
  hear(0x1A2, 50, t + 6 * kMillisecond);  // the moments, and the next forces, are lost
  hear(0x2A2, 60, t + 8 * kMillisecond);
  const auto got = only<Load>(world.take_all());
  ASSERT_EQ(got.size(), 1u);
  EXPECT_DOUBLE_EQ(got[0].second.force_N[0], 2.0);
  EXPECT_DOUBLE_EQ(got[0].second.moment_Nm[0], 0.3);
  EXPECT_EQ(world.counters().load_unpaired - before, 4u);
}

TEST(HopperBus, HalvesOfTheLoadPairWithinTheirTime) {
  const TimeNs limit = HopperBusParameters{}.load_pair_ns;
  for (const TimeNs age : {limit - 1, limit, 100 * limit}) {
    HopperWorld world({.load_cell = true});
    world.boot();
    for (HopperNode& n : world.node) n.mute = true;
    world.run_for(limit);
    world.take_all();
    const std::uint64_t before = world.counters().load_unpaired;
    const CanFrame halves[] = {frame(0x1A2, {1, 0, 0, 0, 0, 0}, world.now),
                               frame(0x2A2, {2, 0, 0, 0, 0, 0}, world.now + age)};
    world.bus.receive(halves);
    EXPECT_EQ(only<Load>(world.take_all()).size(), age < limit ? 1u : 0u) << age;
    EXPECT_EQ(world.counters().load_unpaired - before, age < limit ? 0u : 2u) << age;
  }
}

}  // namespace
}  // namespace lss::talaris
