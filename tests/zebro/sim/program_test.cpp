// The program lss-sim from outside: its ports, its exit codes, faults from another process.

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <termios.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <filesystem>
#include <string>
#include <vector>

#include "drivers/file.h"
#include "tests/support/sim_process.h"

namespace lss::sim {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using Clock = std::chrono::steady_clock;

class Program : public SimProgram {
 protected:
  std::vector<std::string> zebro(const std::vector<std::string>& more = {}) const {
    return arguments("zebro", more);
  }
  fs::path legs() const { return folder_ / "legs"; }

  static File open_port(const fs::path& path) {
    File port(::open(path.c_str(), O_RDWR | O_NOCTTY | O_CLOEXEC));
    termios settings{};
    ::tcgetattr(port.get(), &settings);
    ::cfmakeraw(&settings);
    ::tcsetattr(port.get(), TCSANOW, &settings);
    return port;
  }
  // The reply, up to `expected` characters.
  static std::string ask(const File& port, const std::string& frames, std::size_t expected) {
    if (::write(port.get(), frames.data(), frames.size()) < 0) return "cannot write";
    std::string heard;
    pollfd file{port.get(), POLLIN, 0};
    while (heard.size() < expected && ::poll(&file, 1, 5000) > 0) {
      char buffer[512];
      const ssize_t bytes = ::read(port.get(), buffer, sizeof buffer);
      if (bytes <= 0) break;
      heard.append(buffer, static_cast<std::size_t>(bytes));
    }
    return heard;
  }

  static constexpr const char* kRequest = ":07050000000000000000F4\n";
  static constexpr std::size_t kFrame = 24;
};

TEST_F(Program, SaysWhenItIsReadyAndAnswersOnItsPort) {
  Process sim(zebro());
  ASSERT_TRUE(sim.says("\n")) << sim.heard;
  EXPECT_THAT(sim.heard, testing::StartsWith("lss-sim: zebro ready, port legs at " +
                                             legs().string() + " -> /dev/pts/"));
  EXPECT_EQ(ask(open_port(legs()), kRequest, kFrame).substr(0, 5), ":0740");
}

TEST_F(Program, AnswersAgainAfterTheDaemonClosedAndReopenedThePort) {
  Process sim(zebro());
  ASSERT_TRUE(sim.says("ready"));
  for (int i = 0; i < 3; ++i) EXPECT_EQ(ask(open_port(legs()), kRequest, kFrame).size(), kFrame);
}

TEST_F(Program, PacedRepliesTakeTheTimeOfTheirCharacters) {
  Process sim(zebro({"--pace", "--baud", "19200"}));
  ASSERT_TRUE(sim.says("ready"));
  const File port = open_port(legs());
  std::string seven;
  for (int i = 0; i < 7; ++i) seven += kRequest;
  const auto began = Clock::now();
  EXPECT_EQ(ask(port, seven, 7 * kFrame).size(), 7 * kFrame);
  const std::chrono::duration<double> took = Clock::now() - began;
  EXPECT_GE(took.count(), (8 * 24 + 1) * 10 / 19200.0);
}

TEST_F(Program, RemovesItsPortWhenItIsTerminated) {
  Process sim(zebro());
  ASSERT_TRUE(sim.says("ready"));
  ASSERT_TRUE(fs::is_symlink(legs()));
  sim.signal(SIGTERM);
  EXPECT_EQ(sim.wait(), 0);
  EXPECT_TRUE(fs::is_empty(folder_));
}

TEST_F(Program, RefusesAFolderThatAnotherOneUses) {
  Process first(zebro());
  ASSERT_TRUE(first.says("ready"));
  Process second(zebro());
  EXPECT_EQ(second.wait(), 1);
  EXPECT_THAT(second.heard, HasSubstr("another lss-sim"));
  EXPECT_EQ(ask(open_port(legs()), kRequest, kFrame).size(), kFrame);
}

TEST_F(Program, TakesOverTheFolderOfOneThatWasKilled) {
  {
    Process killed(zebro());
    ASSERT_TRUE(killed.says("ready"));
    killed.signal(SIGKILL);
    EXPECT_EQ(killed.wait(), -SIGKILL);
  }
  ASSERT_TRUE(fs::is_symlink(legs()));
  Process next(zebro());
  ASSERT_TRUE(next.says("ready")) << next.heard;
  EXPECT_EQ(ask(open_port(legs()), kRequest, kFrame).size(), kFrame);
}

TEST_F(Program, WritesTheTruthAsJsonLines) {
  Process sim(zebro({"--truth", truth().string(), "--fault", "0s:module-dead:3"}));
  ASSERT_TRUE(sim.says("ready"));
  const nlohmann::json third = third_truth();
  for (const auto& [key, size] : {std::pair{"position_m", 3u},
                                  {"attitude_wxyz", 4u},
                                  {"velocity_m_s", 3u},
                                  {"leg_angle_rad", 6u}}) {
    EXPECT_EQ(third.at(key).size(), size) << key;
  }
  EXPECT_EQ(third.at("attached_faults"), nlohmann::json({"module-dead:3"}));
}

TEST_F(Program, FaultsComeAndGoWhileItRuns) {
  Process sim(zebro());
  ASSERT_TRUE(sim.says("ready"));
  const File port = open_port(legs());
  ASSERT_EQ(fault("module-dead:2"), 0);
  EXPECT_EQ(ask(port, ":02050000000000000000F9\n" + std::string(kRequest), kFrame).substr(0, 3),
            ":07");
  ASSERT_EQ(fault("clear"), 0);
  EXPECT_TRUE(within_patience([&] {
    return ask(port, ":02050000000000000000F9\n" + std::string(kRequest), kFrame)
        .starts_with(":02");
  }));
}

TEST_F(Program, AnUnpluggedPortGoesAwayAndComesBack) {
  Process sim(zebro());
  ASSERT_TRUE(sim.says("ready"));
  const File port = open_port(legs());
  ASSERT_EQ(fault("unplug:3600"), 0);
  EXPECT_TRUE(within_patience([&] {
    pollfd file{port.get(), 0, 0};
    return ::poll(&file, 1, 0) > 0 && (file.revents & POLLHUP) != 0;
  }));
  ASSERT_EQ(fault("clear"), 0);
  EXPECT_TRUE(within_patience([&] { return fs::exists(legs()); }));
  EXPECT_EQ(ask(open_port(legs()), kRequest, kFrame).size(), kFrame);
}

TEST_F(Program, AWrongFaultIsRefusedWithTheNearestName) {
  Process sim(zebro());
  ASSERT_TRUE(sim.says("ready"));
  std::string said;
  EXPECT_EQ(fault("modul-dead:2", &said), 2);
  EXPECT_THAT(said, HasSubstr("did you mean 'module-dead'"));
  Process refused(zebro({"--fault", "5s:modul-dead:2"}));
  EXPECT_EQ(refused.wait(), 2);
}

TEST_F(Program, AWrongPatchIsRefused) {
  for (const auto& [patch, says] : {std::pair("sand:0.1", "it names no legs"),
                                    {"sand@7", "there is no leg '7'"},
                                    {"sand@4@2..x", "'x' is no number of metres"}}) {
    expect_refused(zebro({"--ground", "regolith", "--patch", patch}), says);
  }
  expect_refused(zebro({"--patch", "sand@4"}), "a patch is in a soil");
}

TEST_F(Program, AFaultForNobodyIsAnErrorOfItsOwn) {
  std::string said;
  EXPECT_EQ(fault("clear", &said), 3);
  EXPECT_THAT(said, HasSubstr("no lss-sim runs in"));
}

TEST_F(Program, ListsItsFaultsAndSuggestsVehicles) {
  Process list({"faults", "zebro"});
  EXPECT_EQ(list.wait(), 0);
  EXPECT_THAT(list.heard, HasSubstr("leg-stuck:N"));
  EXPECT_THAT(list.heard, HasSubstr("unplug:SECONDS"));
  expect_refused({"zbro", "--dir", folder_.string()}, "did you mean 'zebro'");
}

}  // namespace
}  // namespace lss::sim
