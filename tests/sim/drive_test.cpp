// The shared drive of CiA 402 by its frames: power states, ramps, and each option of 0x6007.

#include "tools/lss-sim/canopen/drive.h"

#include <gtest/gtest.h>

#include <numbers>

#include "tools/lss-sim/canopen/wire.h"

namespace lss::sim::nodes {
namespace {

constexpr double kRpm = 2 * std::numbers::pi / 60;

// A drive whose motor follows exactly, and a master that only writes by SDO.
class VelocityBench : public testing::Test {
 protected:
  VelocityBench() {
    pass(300);  // it boots
    write(0x1016, 1, 4, 0x007F'0064);
    write(0x6085, 0, 4, 10'000);
    write(0x605A, 0, 2, 6);
  }

  void pass(int ms) {
    for (; ms > 0; --ms) {
      drive_.step();
      drive_.feel({.velocity_rad_s = blocked_ ? 0 : drive_.reference_rad_s(),
                   .current_per_mille = 0,
                   .at_limit = blocked_,
                   .temperature_degC = temperature_degC_});
      while (const auto frame = drive_.send()) last_ = *frame;
    }
  }
  // 0, or the abort code.
  std::uint32_t write(std::uint16_t index, std::uint8_t sub, std::size_t bytes,
                      std::uint32_t value) {
    CanFrame request{.id = 0x601, .size = 8};
    request.data = {static_cast<std::uint8_t>(0x23 | (4 - bytes) << 2),
                    static_cast<std::uint8_t>(index), static_cast<std::uint8_t>(index >> 8), sub};
    to_little_endian(value, std::span(request.data).subspan(4, bytes));
    return exchange(request);
  }
  std::uint32_t read(std::uint16_t index) {
    CanFrame request{.id = 0x601, .size = 8};
    request.data = {0x40, static_cast<std::uint8_t>(index), static_cast<std::uint8_t>(index >> 8)};
    exchange(request);
    return little_endian(std::span(last_.data).subspan(4));
  }
  void control(std::uint32_t word) { EXPECT_EQ(write(0x6040, 0, 2, word), 0u); }
  void enable() {
    nmt(0x01);
    for (const std::uint32_t word : {0x06u, 0x07u, 0x0Fu}) control(word);
    ASSERT_EQ(drive_.power(), Power::enabled);
  }
  void nmt(std::uint8_t command) {
    CanFrame frame{.id = 0x000, .size = 2};
    frame.data = {command, 1};
    drive_.receive(frame);
  }
  void heartbeat() {
    CanFrame frame{.id = 0x77F, .size = 1};
    frame.data = {0x05};
    drive_.receive(frame);
  }
  double rpm() const { return drive_.reference_rad_s() / kRpm; }

  VelocityDrive drive_{{.id = 1, .device_type = kServo}, 1};
  bool blocked_ = false;
  double temperature_degC_ = 25;

 private:
  std::uint32_t exchange(const CanFrame& request) {
    drive_.receive(request);
    while (const auto frame = drive_.send()) last_ = *frame;
    EXPECT_EQ(last_.id, 0x581u);
    return last_.data[0] == 0x80 ? little_endian(std::span(last_.data).subspan(4)) : 0;
  }

  CanFrame last_;
};

TEST_F(VelocityBench, ItSaysWhatItIs) {
  EXPECT_EQ(read(0x1000), 0x0002'0192u);
  EXPECT_EQ(read(0x6061), 3u);
  EXPECT_EQ(read(0x6502), 1u << 2);
  EXPECT_EQ(write(0x6060, 0, 1, 3), 0u);
  EXPECT_EQ(write(0x6060, 0, 1, 1), std::uint32_t{kOutOfRange});
  EXPECT_EQ(write(0x2100, 1, 4, 1), std::uint32_t{kNoObject}) << "an object of Ardito";
}

TEST_F(VelocityBench, EachRampIsItsOwn) {
  write(0x6083, 0, 4, 1000);
  write(0x6084, 0, 4, 2000);
  enable();
  write(0x60FF, 0, 4, 500);
  pass(250);
  EXPECT_NEAR(rpm(), 250, 1e-6);
  pass(300);
  EXPECT_NEAR(rpm(), 500, 1e-6);
  EXPECT_EQ(read(0x6041), 0x0637u);  // enabled, voltage, remote, target reached
  write(0x60FF, 0, 4, 0);
  pass(100);
  EXPECT_NEAR(rpm(), 300, 1e-6);
  control(0x02);
  pass(10);
  EXPECT_NEAR(rpm(), 200, 1e-6);
  pass(30);
  EXPECT_EQ(rpm(), 0);
  EXPECT_EQ(drive_.power(), Power::quick_stop) << "0x605A = 6: it holds";
  EXPECT_TRUE(drive_.on());
}

TEST_F(VelocityBench, ALostMasterHasTheEffectOf6007) {
  constexpr Power kEffects[] = {Power::enabled, Power::fault, Power::switch_on_disabled,
                                Power::quick_stop};
  for (std::uint32_t option = 0; option < 4; ++option) {
    drive_.power_on();
    pass(300);
    write(0x1016, 1, 4, 0x007F'0064);
    write(0x605A, 0, 2, 6);
    write(0x1029, 1, 1, 0);
    write(0x6007, 0, 2, option);
    enable();
    heartbeat();
    write(0x60FF, 0, 4, 500);
    pass(99);
    EXPECT_EQ(drive_.power(), Power::enabled) << option;
    pass(2);
    EXPECT_EQ(drive_.power(), kEffects[option]) << option;
    EXPECT_EQ(drive_.state(), Nmt::pre_operational) << option;
    EXPECT_EQ(read(0x603F), option == 1 ? 0x8130u : 0u) << option;
  }
}

TEST_F(VelocityBench, AFaultIsResetByARisingEdgeWhenItsCauseIsGone) {
  enable();
  temperature_degC_ = 115;
  pass(2);
  EXPECT_EQ(drive_.power(), Power::fault);
  EXPECT_EQ(read(0x603F), 0x4310u);
  control(0x80);
  EXPECT_EQ(drive_.power(), Power::fault) << "it is hot";
  temperature_degC_ = 60;
  pass(2);
  control(0x80);
  EXPECT_EQ(drive_.power(), Power::fault) << "no rising edge";
  control(0x00);
  control(0x80);
  EXPECT_EQ(drive_.power(), Power::switch_on_disabled);
  EXPECT_EQ(read(0x603F), 0u);
}

TEST_F(VelocityBench, AMotorThatStandsAtItsLimitFailsAfterThreeSeconds) {
  enable();
  write(0x60FF, 0, 4, 500);
  blocked_ = true;
  pass(2990);
  EXPECT_EQ(drive_.power(), Power::enabled);
  EXPECT_NE(read(0x6041) & 1u << 11, 0u) << "internal limit";
  pass(20);
  EXPECT_EQ(drive_.power(), Power::fault);
  EXPECT_EQ(read(0x603F), 0x7121u);
}

TEST_F(VelocityBench, WithoutSupplyItFailsAndWithItItCanBeReset) {
  enable();
  drive_.set_link_V(9);
  pass(1);
  EXPECT_EQ(drive_.power(), Power::fault);
  EXPECT_EQ(read(0x6041) & 1u << 4, 0u) << "voltage enabled";
  drive_.set_link_V(24);
  control(0x80);
  EXPECT_EQ(drive_.power(), Power::switch_on_disabled);
  EXPECT_STREQ(text(drive_.power()), "switch on disabled");
}

}  // namespace
}  // namespace lss::sim::nodes
