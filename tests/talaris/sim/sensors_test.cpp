// IMUs and altimeter by their bytes (ICD sections 2 to 4).

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

#include "tests/support/can_script.h"
#include "tools/lss-sim/talaris/altimeter.h"
#include "tools/lss-sim/talaris/flow_camera.h"
#include "tools/lss-sim/talaris/imu.h"

namespace lss::sim::talaris {
namespace {

using Packet = std::vector<std::uint8_t>;
using testing::ElementsAreArray;
using testing::MatchesRegex;

constexpr ImuOptions kIdeal = {.gyro_noise_rad_s = 0,
                               .accel_noise_m_s2 = 0,
                               .gyro_bias_rad_s = 0,
                               .accel_bias_m_s2 = 0,
                               .gyro_walk_rad_s_rts = 0,
                               .accel_walk_m_s2_rts = 0};
const Inertial kRest = {.rate_rad_s = Vector3::Zero(), .force_m_s2 = {kGravity_m_s2, 0, 0}};

// Its unrequested bytes in this number of milliseconds.
std::vector<Packet> listen(Imu& imu, int ms, const Inertial& truth = kRest) {
  std::vector<Packet> heard;
  for (int i = 0; i < ms; ++i) {
    imu.step(truth);
    for (auto said = imu.send(0); !said.empty(); said = imu.send(0)) {
      heard.emplace_back(said.begin(), said.end());
    }
  }
  return heard;
}

Packet ask(LineDevice& device, const std::string& letters) {
  Packet answer;
  for (const char letter : letters) {
    const auto said = device.receive(static_cast<std::uint8_t>(letter), 0);
    answer.insert(answer.end(), said.begin(), said.end());
  }
  return answer;
}

int le(const Packet& packet, std::size_t at) {
  return static_cast<std::int16_t>(packet[at] | packet[at + 1] << 8);
}
int be(const Packet& packet, std::size_t at) {
  return static_cast<std::int16_t>(packet[at] << 8 | packet[at + 1]);
}
bool sums_to_zero(const Packet& packet) {
  return std::accumulate(packet.begin(), packet.end(), 0) % 256 == 0;
}

TEST(TalarisLandMark, TheGoldenPacket) {
  EXPECT_THAT(LandMark::encode(7, {100, -250, 5, 1000, -12, 3, 2512}, 0x42),
              ElementsAreArray(bytes("2A 07 64 00 06 FF 05 00 E8 03 F4 FF 03 00 D0 09 42 65")));
}

TEST(TalarisLandMark, SaysTwoHundredPacketsASecondWithARunningCounter) {
  LandMark imu(kIdeal, 1);
  const auto heard = listen(imu, 2'000);
  ASSERT_EQ(heard.size(), 400u);
  for (std::size_t i = 0; i < heard.size(); ++i) {
    ASSERT_EQ(heard[i].size(), 18u);
    EXPECT_EQ(heard[i][0], 0x2A);
    EXPECT_EQ(heard[i][1], i % 256);
    EXPECT_TRUE(sums_to_zero(heard[i]));
  }
}

TEST(TalarisLandMark, GivesTheMeanOfItsFiveMillisecondsInItsUnits) {
  LandMark imu(kIdeal, 1);
  std::vector<Packet> heard;
  for (int i = 0; i < 5; ++i) {
    const double ramp = i;  // mean 2
    heard = listen(imu, 1, {{0.1 * ramp, -0.2, 0}, {kGravity_m_s2, ramp, -3}});
  }
  ASSERT_EQ(heard.size(), 1u);
  EXPECT_EQ(le(heard[0], 2), std::lround(0.2 / kDegree * 100));
  EXPECT_EQ(le(heard[0], 4), std::lround(-0.2 / kDegree * 100));
  EXPECT_EQ(le(heard[0], 8), 1000);
  EXPECT_EQ(le(heard[0], 10), std::lround(2 / kGravity_m_s2 * 1000));
  EXPECT_EQ(le(heard[0], 12), std::lround(-3 / kGravity_m_s2 * 1000));
  EXPECT_EQ(le(heard[0], 14), 2512);
}

TEST(TalarisLandMark, TheStatusReportsProductFlagsAndScales) {
  LandMark imu(kIdeal, 1);
  const auto heard = listen(imu, 512 * 5);
  EXPECT_EQ(heard[0][16] & 0x80, 0);       // firmware
  EXPECT_EQ(heard[256][16] & 0x80, 0x80);  // product, next time
  EXPECT_EQ(heard[100][16], 0x00);
  EXPECT_EQ(heard[101][16], 0x40);
  EXPECT_EQ(heard[248][16], 0x47);
  EXPECT_EQ(heard[255][16], 0x11);
}

TEST(TalarisLandMark, OtherScalesAreSaidAndUsed) {
  LandMark imu(kIdeal, 1);
  imu.set_faults({.scale = 0x21 | 3 << 1});
  const auto heard = listen(imu, 50, {{1, 0, 0}, {kGravity_m_s2, 0, 0}});
  EXPECT_EQ(heard[3][16], 0x40 | 0x21 | 3 << 1);
  EXPECT_EQ(le(heard[3], 2), std::lround(1 / kDegree / 0.05));
  EXPECT_EQ(le(heard[3], 8), 2000);  // 0.0005 g
}

TEST(TalarisLandMark, PauseAndRun) {
  LandMark imu(kIdeal, 1);
  ask(imu, std::string(10, '\xD4'));
  EXPECT_TRUE(listen(imu, 100).empty());
  ask(imu, {'\x2B', '\x0D', '\0', '\xC9', 0, 0, 0, 0});  // wrong sum
  EXPECT_TRUE(listen(imu, 100).empty());
  ask(imu, {'\x2B', '\x0A', '\0', '\xCB', 0, 0, 0, 0});
  ask(imu, {'\x2B', '\x0D', '\0', '\xC8', 0, 0, 0, 0});
  EXPECT_EQ(listen(imu, 100).size(), 10u);
  ask(imu, {'\x2B', '\x02', '\0', '\xD3', 0, 0, 0, 0});
  EXPECT_EQ(listen(imu, 100).size(), 20u);
}

TEST(TalarisLandMark, NoiseAndBiasAreAsTheOptionsSay) {
  LandMark imu({.gyro_bias_rad_s = 0.01, .accel_bias_m_s2 = 0.2}, 3);
  const auto heard = listen(imu, 20'000);
  double sum = 0, squares = 0;
  for (const Packet& packet : heard) sum += le(packet, 2) * 0.01 * kDegree;
  const double mean = sum / static_cast<double>(heard.size());
  for (const Packet& packet : heard) {
    squares += std::pow(le(packet, 2) * 0.01 * kDegree - mean, 2);
  }
  EXPECT_NEAR(mean, imu.bias().rate_rad_s.x(), 2e-4);
  EXPECT_NE(mean, 0);
  EXPECT_NEAR(std::sqrt(squares / static_cast<double>(heard.size())), 0.05 * kDegree, 5e-5);
}

TEST(TalarisLandMark, FaultsShow) {
  LandMark imu(kIdeal, 1);
  imu.set_faults({.silent = true});
  EXPECT_TRUE(listen(imu, 100).empty());
  imu.set_faults({});
  const auto before = listen(imu, 5).at(0);
  imu.set_faults({.stuck = true});
  const auto stuck = listen(imu, 10, {{1, 1, 1}, {1, 1, 1}});
  EXPECT_TRUE(std::equal(stuck[1].begin() + 2, stuck[1].begin() + 14, before.begin() + 2));
  EXPECT_EQ(stuck[1][1], static_cast<std::uint8_t>(stuck[0][1] + 1));
  imu.set_faults({.checksum = 1});
  EXPECT_FALSE(sums_to_zero(listen(imu, 5).at(0)));
  imu.set_faults({.parity = 1});
  EXPECT_NE(listen(imu, 5).at(0)[0], 0x2A);
  imu.set_faults({.bias = {0, 0, 0.5, 0, 0, 0}});
  EXPECT_EQ(le(listen(imu, 5).at(0), 6), std::lround(0.5 / kDegree * 100));
  imu.set_faults({});
  const int counter = listen(imu, 5).at(0)[1];
  imu.jump(7);
  EXPECT_EQ(listen(imu, 5).at(0)[1], (counter + 8) % 256);
}

TEST(TalarisCrossbow, TheGoldenPacket) {
  EXPECT_THAT(Crossbow::encode({218, -437, 0, 10923, -22, 5}, 0x0640, 0xFDE8),
              ElementsAreArray(bytes("FF 00 DA FE 4B 00 00 2A AB FF EA 00 05 06 40 FD E8 11")));
}

TEST(TalarisCrossbow, AnswersItsLettersAndIsSilentOtherwise) {
  Crossbow imu(kIdeal, 1);
  EXPECT_TRUE(listen(imu, 100).empty());
  EXPECT_EQ(ask(imu, "R"), Packet{'H'});
  EXPECT_TRUE(ask(imu, "P").empty());
  EXPECT_EQ(ask(imu, "c"), Packet{'C'});
  EXPECT_TRUE(ask(imu, "?x").empty());
  listen(imu, 10, {{0.1, 0, -0.1}, {kGravity_m_s2, 0, 1}});
  const Packet packet = ask(imu, "G");
  ASSERT_EQ(packet.size(), 18u);
  EXPECT_EQ(packet[0], 0xFF);
  EXPECT_NEAR(be(packet, 1) * 150.0 / 32768, 0.1 / kDegree, 0.005);
  EXPECT_NEAR(be(packet, 7) * 3.0 / 32768, 1, 1e-4);
  EXPECT_NEAR(be(packet, 11) * 3.0 / 32768, 1 / kGravity_m_s2, 1e-4);
  EXPECT_EQ(std::accumulate(packet.begin() + 1, packet.begin() + 17, 0) % 256, packet[17]);
}

TEST(TalarisCrossbow, SendsUnaskedOnlyInContinuousMode) {
  Crossbow imu(kIdeal, 1);
  ask(imu, "C");
  EXPECT_EQ(listen(imu, 100).size(), 10u);
  ask(imu, "R");
  EXPECT_TRUE(listen(imu, 100).empty());
}

class TalarisAltimeter : public testing::Test {
 protected:
  std::vector<std::string> listen(Altimeter& altimeter, int ms, std::optional<double> distance_m) {
    std::vector<std::string> heard;
    for (int i = 0; i < ms; ++i) {
      altimeter.step(distance_m);
      for (auto said = altimeter.send(0); !said.empty(); said = altimeter.send(0)) {
        heard.emplace_back(said.begin(), said.end());
        times_ms_.push_back(i);
      }
    }
    return heard;
  }
  std::vector<std::string> listen(int ms, std::optional<double> distance_m) {
    return listen(altimeter_, ms, distance_m);
  }

  Altimeter altimeter_{{.noise_m = 0}, 1};
  std::vector<int> times_ms_;
};

TEST_F(TalarisAltimeter, SaysNothingUntilItIsReportedTo) {
  EXPECT_TRUE(listen(1'000, 1).empty());
  ask(altimeter_, "dw\r");
  const auto heard = listen(1'000, 0.934);
  ASSERT_GE(heard.size(), 7u);
  EXPECT_EQ(heard.front(), "000.934\r\n");
  ask(altimeter_, "\x1B");
  EXPECT_TRUE(listen(1'000, 1).empty());
  EXPECT_FALSE(altimeter_.measuring());
}

TEST_F(TalarisAltimeter, TenTimesASecondButNotInStepWithAnything) {
  ask(altimeter_, "DW\r");
  EXPECT_NEAR(static_cast<double>(listen(100'000, 12.3456).size()), 998, 12);
  int least = 1'000, most = 0;
  for (std::size_t i = 1; i < times_ms_.size(); ++i) {
    least = std::min(least, times_ms_[i] - times_ms_[i - 1]);
    most = std::max(most, times_ms_[i] - times_ms_[i - 1]);
  }
  EXPECT_GE(least, 91);
  EXPECT_LE(most, 109);
  EXPECT_GT(most - least, 10);
}

TEST_F(TalarisAltimeter, NoiseIsThreeMillimetres) {
  Altimeter altimeter({}, 4);
  ask(altimeter, "DW\r");
  double squares = 0;
  const auto heard = listen(altimeter, 100'000, 5);
  for (const std::string& line : heard) squares += std::pow(std::stod(line) - 5, 2);
  EXPECT_NEAR(std::sqrt(squares / static_cast<double>(heard.size())), 0.003, 0.0004);
}

TEST_F(TalarisAltimeter, OutsideItsRangeItSaysE15) {
  ask(altimeter_, "DT\r");
  for (const auto& distance : {std::optional(0.05), std::optional(30.5), std::optional<double>()}) {
    EXPECT_THAT(listen(600, distance), testing::Each("E15\r\n"));
  }
  EXPECT_EQ(listen(300, 29.9).back(), "029.900\r\n");
}

TEST_F(TalarisAltimeter, FaultsShow) {
  ask(altimeter_, "DW\r");
  altimeter_.set_faults({.silent = true});
  EXPECT_TRUE(listen(1'000, 1).empty());
  altimeter_.set_faults({.error = 16});
  EXPECT_EQ(listen(500, 1).back(), "E16\r\n");
  altimeter_.set_faults({.out_of_range = true});
  EXPECT_EQ(listen(500, 1).back(), "E15\r\n");
  altimeter_.set_faults({.offset_m = 0.5});
  EXPECT_EQ(listen(500, 1).back(), "001.500\r\n");
  altimeter_.set_faults({.garbage = true});
  EXPECT_THAT(listen(500, 1), testing::Each(testing::Not(MatchesRegex("[0-9]+\\.[0-9]+\r\n"))));
}

using Passes = std::optional<std::array<double, 2>>;
constexpr FlowCameraOptions kIdealCamera = {.present = true, .jitter_s = 0, .noise_rad_s = 0};

std::vector<Packet> frames(FlowCamera& camera, int ms, const Passes& passes) {
  std::vector<Packet> heard;
  for (int i = 0; i < ms; ++i) {
    camera.step(passes);
    for (auto said = camera.send(0); !said.empty(); said = camera.send(0))
      heard.emplace_back(said.begin(), said.end());
  }
  return heard;
}

TEST(TalarisCamera, SaysTwentyTimesASecondHowFarTheGroundPassed) {
  FlowCamera camera(kIdealCamera, 1);
  const auto heard = frames(camera, 1'000, Passes{{1.2, -0.4}});
  ASSERT_EQ(heard.size(), 20u);
  // 60 counts along y, -20 along z; the check by another program.
  EXPECT_THAT(heard.front(),
              ElementsAreArray(bytes("24 58 3C 00 02 1F 09 00 C8 3C 00 00 00 EC FF FF FF 6C")));
}

TEST(TalarisCamera, WithoutAPictureItSaysThatItIsOfNoQuality) {
  FlowCamera camera(kIdealCamera, 1);
  const auto quality = [&](const Passes& passes) { return frames(camera, 50, passes).at(0)[8]; };
  EXPECT_GT(quality(Passes{{1, 1}}), 100);
  EXPECT_EQ(quality({}), 0) << "too high, too low, too inclined";
  EXPECT_EQ(quality(Passes{{5, 6}}), 0) << "blurred";
  camera.set_faults({.blind = true});
  EXPECT_EQ(quality(Passes{{1, 1}}), 0);
  camera.set_faults({.off_rad_s = 1});
  EXPECT_EQ(frames(camera, 50, Passes{{0, 0}}).at(0)[9], 50);
  camera.set_faults({.silent = true});
  EXPECT_TRUE(frames(camera, 500, Passes{{1, 1}}).empty());
}

TEST(TalarisCamera, SpeaksLaterByItsLatency) {
  FlowCamera camera({.present = true, .jitter_s = 0, .latency_s = 0.03, .noise_rad_s = 0}, 1);
  EXPECT_TRUE(frames(camera, 79, Passes{{1, 1}}).empty());
  EXPECT_EQ(frames(camera, 1, Passes{{1, 1}}).size(), 1u);
}

}  // namespace
}  // namespace lss::sim::talaris
