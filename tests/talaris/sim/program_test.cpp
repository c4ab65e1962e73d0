// lss-sim talaris from outside: its lines and its bus, faults from another process, truth, exit
// codes.

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <termios.h>

#include <chrono>
#include <filesystem>
#include <string>
#include <vector>

#include "tests/support/sim_process.h"

namespace lss::sim {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

// The master's end of a serial line.
class Line {
 public:
  explicit Line(const fs::path& path)
      : file_(::open(path.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK)) {
    termios raw{};
    ::tcgetattr(file_.get(), &raw);
    ::cfmakeraw(&raw);
    ::tcsetattr(file_.get(), TCSANOW, &raw);
  }
  void write(const std::string& text) {
    EXPECT_EQ(::write(file_.get(), text.data(), text.size()), static_cast<ssize_t>(text.size()));
  }
  // The bytes received until this number, or until this time without a byte.
  std::string read(std::size_t count, std::chrono::milliseconds patience = kPatience) {
    std::string heard;
    pollfd file{file_.get(), POLLIN, 0};
    while (heard.size() < count) {
      if (::poll(&file, 1, static_cast<int>(patience.count())) <= 0) break;
      char buffer[512];
      const ssize_t bytes = ::read(file_.get(), buffer, sizeof buffer);
      if (bytes <= 0) break;
      heard.append(buffer, static_cast<std::size_t>(bytes));
    }
    return heard;
  }

 private:
  File file_;
};

class TalarisProgram : public SimProgram {
 protected:
  std::vector<std::string> talaris(const std::vector<std::string>& more = {}) const {
    return on_can("talaris", more);
  }
  fs::path imu() const { return folder_ / "imu"; }
  fs::path altimeter() const { return folder_ / "altimeter"; }

  // Whether whole packets of the IMU stand in these bytes.
  static bool has_packet(const std::string& heard) {
    for (std::size_t at = 0; at + 18 <= heard.size(); ++at) {
      int sum = 0;
      for (std::size_t i = 0; i < 18; ++i) sum += static_cast<std::uint8_t>(heard[at + i]);
      if (heard[at] == 0x2A && sum % 256 == 0) return true;
    }
    return false;
  }
};

TEST_F(TalarisProgram, SaysWhereItsLinesAndItsBusAreAndSpeaksThere) {
  Process sim(talaris({"--pace"}));
  ASSERT_TRUE(sim.says("\n"));
  EXPECT_THAT(sim.heard, HasSubstr("talaris ready, port imu at "));
  EXPECT_THAT(sim.heard, HasSubstr("port altimeter at "));
  EXPECT_THAT(sim.heard, HasSubstr("CAN bus hopper at udp://127.0.0.1:"));
  Line imu_line(imu()), altimeter_line(altimeter());
  EXPECT_TRUE(has_packet(imu_line.read(100)));
  altimeter_line.write("DW\r");
  EXPECT_THAT(altimeter_line.read(9), testing::MatchesRegex("000\\.[0-9][0-9][0-9]\r\n.*"));
  sim.signal(SIGTERM);
  EXPECT_EQ(sim.wait(), 0);
  EXPECT_TRUE(fs::is_empty(folder_));
}

TEST_F(TalarisProgram, TheCrossbowAnswersOnItsLine) {
  Process sim(talaris({"--imu", "crossbow"}));
  ASSERT_TRUE(sim.says("\n"));
  Line line(imu());
  line.write("R");
  EXPECT_EQ(line.read(1), "H");
  line.write("G");
  EXPECT_EQ(line.read(18).size(), 18u);
}

TEST_F(TalarisProgram, FaultsOfLinesGoByTheirNumber) {
  Process sim(talaris());
  ASSERT_TRUE(sim.says("\n"));
  Line line(imu());
  ASSERT_TRUE(has_packet(line.read(100)));
  ASSERT_EQ(fault("line-cut:1"), 0);
  line.read(1'000'000, std::chrono::milliseconds(200));  // until it is quiet
  EXPECT_EQ(line.read(1, std::chrono::milliseconds(200)), "");
  ASSERT_EQ(fault("clear:line-cut:1"), 0);
  EXPECT_TRUE(has_packet(line.read(100)));
  ASSERT_EQ(fault("line-cut:2"), 0);
  EXPECT_TRUE(has_packet(line.read(100)));
  ASSERT_EQ(fault("imu-silent"), 0);
  line.read(1'000'000, std::chrono::milliseconds(200));
  EXPECT_EQ(line.read(1, std::chrono::milliseconds(200)), "");
}

TEST_F(TalarisProgram, AnUnpluggedLineComesBack) {
  Process sim(talaris());
  ASSERT_TRUE(sim.says("\n"));
  ASSERT_EQ(fault("line-unplug:1:0.3"), 0);
  ASSERT_TRUE(within_patience([this] { return !fs::exists(imu()); }));
  ASSERT_TRUE(within_patience([this] { return fs::exists(imu()); }));
  EXPECT_TRUE(has_packet(Line(imu()).read(100)));
}

TEST_F(TalarisProgram, WritesTheTruthWithItsFaults) {
  Process sim(talaris({"--truth", truth().string(), "--stand", "sled", "--heading", "45", "--fault",
                       "0s:node-silent:0x20", "--fault", "0s:push:20"}));
  ASSERT_TRUE(sim.says("ready"));
  const nlohmann::json third = third_truth();
  EXPECT_NEAR(third.at("attitude_wxyz")[1].get<double>(), 0.3827, 1e-3);
  EXPECT_GT(third.at("position_m")[2].get<double>(), 0.005);
  EXPECT_EQ(third.at("attached_faults"), nlohmann::json({"node-silent:0x20", "push:20:0"}));
}

TEST_F(TalarisProgram, StandsInSoil) {
  Process sim(talaris({"--truth", truth().string(), "--ground", "sand:0.5"}));
  ASSERT_TRUE(sim.says("ready"));
  for (const double sinkage_m : third_truth().at("foot_sinkage_m"))
    EXPECT_NEAR(sinkage_m, 0.026, 0.002);
}

TEST_F(TalarisProgram, ListsItsFaultsAndRefusesWhatDoesNotGo) {
  Process list({"faults", "talaris"});
  EXPECT_EQ(list.wait(), 0);
  for (const char* each :
       {"imu-counter-jump[:PACKETS]", "valve-stuck-open:VALVE", "bus-off:SECONDS",
        "line-late:LINE:MS", "one of 0x20, 0x21, 0x22", "unplug:SECONDS"}) {
    EXPECT_THAT(list.heard, HasSubstr(each));
  }
  expect_refused(talaris({"--fault", "5s:imu-silnt"}), "did you mean 'imu-silent'");
  expect_refused(talaris({"--stand", "rail", "--heading", "45"}), "--heading is for");
  expect_refused(talaris({"--stand", "bench"}),
                 "bench not in {fans,free,lift,load,pivot,rail,sled}");
  expect_refused(talaris({"--ground", "mud"}), "'mud' is no soil: sand, loam, regolith");
  expect_refused(talaris({"--stand", "sled", "--ground", "sand"}),
                 "soil is for the stand free only");
}

TEST_F(TalarisProgram, EveryStandRuns) {
  for (const char* stand : {"free", "rail", "sled", "pivot", "lift", "fans", "load"}) {
    Process sim(talaris({"--stand", stand, "--disperse", "--seed", "7"}));
    ASSERT_TRUE(sim.says("\n")) << stand;
    EXPECT_TRUE(has_packet(Line(imu()).read(100))) << stand;
    sim.signal(SIGTERM);
    EXPECT_EQ(sim.wait(), 0) << stand;
  }
}

}  // namespace
}  // namespace lss::sim
