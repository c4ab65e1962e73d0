// The whole simulated TALARIS in virtual time: bytes in, bytes out, the vehicle between, and what
// can be broken.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "tests/talaris/sim/hopper_master.h"

namespace lss::sim::talaris {
namespace {

using testing::Contains;

constexpr double kWeight_N = 45 * kGravity_m_s2;

class TalarisVehicle : public testing::Test {
 protected:
  void fly(const TalarisOptions& options) {
    world_ = std::make_unique<Talaris>(options);
    master_ = std::make_unique<Master>(*world_);
    ASSERT_TRUE(master_->bring_up());
  }
  void inject(const std::string& text, bool attach = true) {
    const auto fault = parse_fault(text, fault_kinds());
    ASSERT_TRUE(fault) << fault.error();
    world_->set_fault(*fault, attach);
  }
  // Bytes of a line in this number of milliseconds.
  std::string listen(LineDevice& device, int ms) {
    std::string heard;
    for (int i = 0; i < ms; ++i) {
      master_->run(1);
      for (auto said = device.send(0); !said.empty(); said = device.send(0)) {
        heard.append(said.begin(), said.end());
      }
    }
    return heard;
  }
  std::string listen_imu(int ms) { return listen(world_->imu(), ms); }
  std::string listen_altimeter(int ms) {
    for (const char letter : {'D', 'W', '\r'}) {
      world_->altimeter().receive(static_cast<std::uint8_t>(letter), 0);
    }
    return listen(world_->altimeter(), ms);
  }
  const BodyState& body() { return world_->plant().body(); }

  std::unique_ptr<Talaris> world_;
  std::unique_ptr<Master> master_;
};

TEST_F(TalarisVehicle, APulseOverTheBusIsThrustTimesOnTime) {
  fly({.plant = {.stand = Stand::rail, .friction_m_s2 = 0}});
  master_->valves(0x82);
  master_->run(100);
  master_->valves(0);
  master_->run(100);
  EXPECT_NEAR(body().velocity_m_s.z(), 2 * 58 * 0.100 / 45, 0.002);
  EXPECT_NEAR(world_->gas().used_s(), 0.2, 0.003);
}

TEST_F(TalarisVehicle, FansCarryFiveSixthsAndTheColdGasLiftsTheRest) {
  fly({.fans = {.started = true}});
  const auto us = static_cast<unsigned>(std::lround(1000 + 1000 * 29'384.0 / 33'000));
  master_->fan_us.fill(us);
  master_->run(3'000);
  EXPECT_TRUE(world_->plant().contact());
  EXPECT_NEAR(body().force_B_m_s2.x(), kGravity_m_s2, 1e-3);
  master_->valves(0x55);
  master_->run(1'000);
  EXPECT_FALSE(world_->plant().contact());
  // 232 N of cold gas, 368 N of fans.
  EXPECT_NEAR(body().velocity_m_s.x(), (4 * 58 - kWeight_N / 6) / 45, 0.1);
}

TEST_F(TalarisVehicle, ArmsItsFansByTheirProcedureOnly) {
  fly({});
  master_->fan_us.fill(1500);
  master_->run(1'000);
  EXPECT_EQ(world_->fans().rpm(0), 0);
  master_->arm();
  EXPECT_TRUE(world_->fans().armed(3));
  EXPECT_EQ(world_->fans().rpm(0), 0);
  master_->fan_us.fill(1500);
  master_->run(2'000);
  EXPECT_NEAR(world_->fans().rpm(3), 16'500, 50);
  inject("esc-unarmed:4");
  master_->run(2'000);
  EXPECT_LT(world_->fans().rpm(3), 50);
  EXPECT_GT(world_->fans().rpm(2), 16'000);
}

TEST_F(TalarisVehicle, TheSameSeedGivesTheSameBytesAnotherOneOthers) {
  const auto bytes_of = [&](unsigned seed) {
    fly({.plant = {.height_m = 1}, .seed = seed});
    return listen_imu(300) + listen_altimeter(500) + world_->truth().dump();
  };
  const std::string first = bytes_of(5);
  EXPECT_EQ(bytes_of(5), first);
  EXPECT_NE(bytes_of(6), first);
}

TEST_F(TalarisVehicle, DispersionsAreDrawnFromTheSeedWithinTheirBounds) {
  const TalarisOptions nominal;
  double least = 99, most = 0;
  for (unsigned seed = 0; seed < 200; ++seed) {
    const TalarisOptions drawn = dispersed(nominal, seed);
    least = std::min(least, drawn.plant.inertia_kg_m2.z());
    most = std::max(most, drawn.plant.inertia_kg_m2.z());
    EXPECT_NEAR(drawn.plant.mass_kg, 45, 0.91);
    EXPECT_LE(drawn.plant.cg_m.tail(2).cwiseAbs().maxCoeff(), 0.0015);
    for (const double scale : drawn.gas.thrust_scale) EXPECT_NEAR(scale, 1, 0.031);
  }
  EXPECT_NEAR(least, 1.8 * 0.7, 0.03);
  EXPECT_NEAR(most, 1.8 * 1.3, 0.03);
  EXPECT_EQ(dispersed(nominal, 3).plant.mass_kg, dispersed(nominal, 3).plant.mass_kg);
}

TEST_F(TalarisVehicle, SensorsFeelItsAttitude) {
  fly({.plant = {.stand = Stand::pivot, .tilt_rad = 0.2}});
  listen_imu(5);  // waiting bytes
  const std::string packet = listen_imu(5);
  const auto forward = static_cast<std::int16_t>(static_cast<std::uint8_t>(packet[12]) |
                                                 static_cast<std::uint8_t>(packet[13]) << 8);
  EXPECT_NEAR(forward, 1000 * std::sin(0.2), 20);
  const std::string heard = listen_altimeter(320);
  EXPECT_NEAR(std::stod(heard), 0.247 / std::cos(0.2), 0.015);
}

TEST_F(TalarisVehicle, LinesHaveTheirRates) {
  fly({});
  const auto lines = world_->lines();
  ASSERT_EQ(lines.size(), 2u);
  EXPECT_EQ(lines[0].name, "imu");
  EXPECT_EQ(lines[0].baud, 115'200);
  EXPECT_EQ(lines[0].bits, 12);
  EXPECT_EQ(lines[1].name, "altimeter");
  EXPECT_EQ(lines[1].baud, 9'600);
  Talaris crossbow({.imu = {.kind = ImuKind::crossbow}});
  EXPECT_EQ(crossbow.lines()[0].baud, 38'400);
  EXPECT_EQ(crossbow.lines()[0].bits, 10);
}

TEST_F(TalarisVehicle, APacketOfTheImuTakesItsTimeOnTheLine) {
  fly({});
  listen_imu(100);  // waiting bytes
  const SerialLine line = world_->lines()[0];
  while (!line.device->wants_to_send()) world_->step();
  Uart uart({.baud = line.baud, .bits = line.bits}, *line.device);
  uart.advance(kSecond);
  std::size_t heard = 0;
  TimeNs now = kSecond;
  while (heard < 18) {
    now = uart.next_wake();
    ASSERT_LT(now, 2 * kSecond);
    heard += uart.take(now).size();
  }
  EXPECT_EQ(heard, 18u);
  EXPECT_NEAR(static_cast<double>(now - kSecond), 1.875e6, 1e3);
}

TEST_F(TalarisVehicle, FaultsOfTheImuShow) {
  fly({});
  listen_imu(5);  // waiting bytes
  ASSERT_EQ(listen_imu(100).size(), 20u * 18);
  inject("imu-silent");
  EXPECT_EQ(listen_imu(100), "");
  inject("imu-silent", false);
  inject("imu-bias:3:0.5");
  const std::string biased = listen_imu(5);
  const auto counts = static_cast<std::int16_t>(static_cast<std::uint8_t>(biased[6]) |
                                                static_cast<std::uint8_t>(biased[7]) << 8);
  EXPECT_NEAR(counts, 0.5 / kDegree * 100, 60);
  inject("imu-bias:3:0.5", false);
  const auto counter = [&] { return static_cast<std::uint8_t>(listen_imu(5)[1]); };
  const int before = counter();
  inject("imu-counter-jump:9");
  EXPECT_EQ(counter(), (before + 10) % 256);
  inject("imu-scale:0x31");
  const std::string scaled = listen_imu(10);
  EXPECT_TRUE(static_cast<std::uint8_t>(scaled[16]) == 0x71 ||
              static_cast<std::uint8_t>(scaled[34]) == 0x71);
}

TEST_F(TalarisVehicle, FaultsOfTheAltimeterShow) {
  fly({.plant = {.height_m = 5}});
  const auto last = [&] {
    const std::string heard = listen_altimeter(320);
    const std::size_t end = heard.rfind("\r\n");
    const std::size_t begin = heard.rfind("\r\n", end - 1);
    return heard.substr(begin == std::string::npos ? 0 : begin + 2, 3);
  };
  inject("altimeter-error:17");
  EXPECT_EQ(last(), "E17");
  inject("altimeter-error:17", false);
  inject("altimeter-range");
  EXPECT_EQ(last(), "E15");
  inject("altimeter-silent");
  EXPECT_EQ(listen_altimeter(500), "");
}

TEST_F(TalarisVehicle, FaultsOfNodesShow) {
  fly({});
  inject("node-silent:0x20");
  master_->last.erase(0x720);
  master_->run(200);
  EXPECT_FALSE(master_->last.contains(0x720));
  inject("node-silent:0x20", false);
  inject("node-reset:0x21");
  master_->heard.clear();
  master_->run(300);
  EXPECT_THAT(master_->heard, Contains("721 [1] 00"));
  inject("node-babble:0x21:3000");
  master_->heard.clear();
  master_->run(100);
  EXPECT_GT(master_->heard.size(), 250u);
  inject("node-babble:0x21:3000", false);
  inject("wrong-device-type:0x20:0x123");
  master_->run(1);
  EXPECT_EQ(master_->ask("620 [8] 40 00 10 00 00 00 00 00"), "5A0 [8] 43 00 10 00 23 01 00 00");
}

TEST_F(TalarisVehicle, FaultsOfValvesFansAndGasShow) {
  fly({.fans = {.started = true}});
  inject("valve-stuck-open:4");
  master_->run(50);
  EXPECT_EQ(world_->truth().at("valves").get<int>(), 0x08);
  inject("valve-stuck-open:4", false);
  inject("valve-stuck-shut:1");
  master_->valves(0x05);
  master_->run(50);
  EXPECT_EQ(world_->truth().at("valves").get<int>(), 0x04);
  inject("pressure-drop:0.25");
  master_->run(500);
  EXPECT_NEAR(u16_at(master_->last[0x2A0], 2), 1'034, 40);
  inject("pressure-drop:0.25", false);
  inject("gas:20");
  master_->run(300);
  EXPECT_NEAR(world_->gas().left_s(), 19.7, 0.03);
  inject("gas-leak:1");
  master_->valves(0);
  master_->run(1'000);
  EXPECT_NEAR(world_->gas().left_s(), 18.7, 0.06);
  master_->fan_us.fill(1300);
  inject("fan-dead:2");
  master_->run(1'500);
  EXPECT_EQ(world_->fans().rpm(1), 0);
  EXPECT_GT(world_->fans().rpm(0), 9'000);
}

TEST_F(TalarisVehicle, APushMovesItOnTheSled) {
  fly({.plant = {.stand = Stand::sled}});
  inject("push:45:90");
  master_->run(1'000);
  EXPECT_NEAR(body().velocity_m_s.y(), 0.95, 0.02);
  EXPECT_NEAR(body().velocity_m_s.z(), 0, 0.01);
}

TEST_F(TalarisVehicle, EveryKindOfFaultCanBeAttachedAndClearedWhileItFlies) {
  fly({.plant = {.stand = Stand::load}, .fans = {.started = true}});
  master_->fan_us.fill(1600);
  for (const FaultKind& kind : fault_kinds()) {
    Fault fault{.kind = &kind, .values = {}, .clear = false};
    for (const FaultArgument& argument : kind.arguments) {
      fault.values.push_back(argument.choices.empty() ? std::max(argument.min, 1.0)
                                                      : argument.choices.back());
    }
    world_->set_fault(fault, true);
    master_->run(50);
    if (!kind.momentary) world_->set_fault(fault, false);
    master_->run(50);
  }
  EXPECT_TRUE(std::isfinite(body().position_m.norm()));
  // All gone again.
  listen_imu(5);
  EXPECT_EQ(listen_imu(100).size(), 20u * 18);
}

TEST_F(TalarisVehicle, TheTruthHasWhatATestNeeds) {
  fly({});
  const auto truth = world_->truth();
  for (const auto& [key, size] : {std::pair{"position_m", 3u},
                                  {"attitude_wxyz", 4u},
                                  {"velocity_m_s", 3u},
                                  {"rate_rad_s", 3u},
                                  {"rpm", 4u},
                                  {"armed", 4u}}) {
    EXPECT_EQ(truth.at(key).size(), size) << key;
  }
  EXPECT_NEAR(truth.at("gas_kg").get<double>(), 2, 1e-9);
  EXPECT_TRUE(truth.at("contact").get<bool>());
  EXPECT_NEAR(truth.at("range_m").get<double>(), 0.247, 1e-3);
}

}  // namespace
}  // namespace lss::sim::talaris
