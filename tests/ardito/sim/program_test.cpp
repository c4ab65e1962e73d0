// lss-sim ardito from outside: its bus over UDP, its exit codes, faults from another process.

#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>

#include <chrono>
#include <filesystem>
#include <string>
#include <vector>

#include "drivers/can/cannelloni.h"
#include "tests/support/can_script.h"
#include "tests/support/sim_process.h"

namespace lss::sim::ardito {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using Clock = std::chrono::steady_clock;

// A master's end of the bus.
class Peer {
 public:
  explicit Peer(const std::string& port)
      : socket_(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)) {
    sockaddr_in to{};
    to.sin_family = AF_INET;
    to.sin_port = htons(static_cast<std::uint16_t>(std::stoi(port)));
    to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    connected_ = ::connect(socket_.get(), reinterpret_cast<sockaddr*>(&to), sizeof to) == 0;
  }

  bool connected() const { return connected_; }
  void send(const std::string& frame_text) {
    writer_.add(frame(frame_text));
    const auto bytes = writer_.take();
    ::send(socket_.get(), bytes.data(), bytes.size(), 0);
  }
  // Waits for a frame with this beginning, asking again with `question` until it comes.
  std::string ask(const std::string& question, const std::string& beginning) {
    const auto deadline = Clock::now() + kPatience;
    while (Clock::now() < deadline) {
      send(question);
      const std::string heard = wait(beginning, std::chrono::milliseconds(200));
      if (!heard.empty()) return heard;
    }
    return "nothing";
  }
  std::string wait(const std::string& beginning, Clock::duration patience) {
    const auto deadline = Clock::now() + patience;
    pollfd file{socket_.get(), POLLIN, 0};
    for (;;) {
      const auto left =
          std::chrono::duration_cast<std::chrono::milliseconds>(deadline - Clock::now());
      if (left.count() <= 0 || ::poll(&file, 1, static_cast<int>(left.count())) <= 0) return "";
      std::array<std::uint8_t, kMaxDatagram> bytes;
      const ssize_t count = ::recv(socket_.get(), bytes.data(), bytes.size(), 0);
      if (count <= 0) continue;
      reader_.begin(std::span(bytes).first(static_cast<std::size_t>(count)));
      for (CanFrame next; reader_.next(next);) {
        if (text(next).starts_with(beginning)) return text(next);
      }
    }
  }

 private:
  File socket_;
  bool connected_ = false;
  CannelloniReader reader_;
  CannelloniWriter writer_;
};

class Program : public SimProgram {
 protected:
  std::vector<std::string> ardito(const std::vector<std::string>& more = {}) const {
    return on_can("ardito", more);
  }
  // The port that it says it has.
  static std::string port_of(Process& sim) {
    if (!sim.says("\n")) return "0";
    const std::size_t at = sim.heard.find("udp://127.0.0.1:");
    return at == std::string::npos ? "0"
                                   : sim.heard.substr(at + 16, sim.heard.find('\n') - at - 16);
  }
  static constexpr const char* kAskType = "601 [8] 40 00 10 00 00 00 00 00";
  static constexpr const char* kWheel = "581 [8] 43 00 10 00 92 01 02 00";
};

TEST_F(Program, SaysWhereItsBusIsAndAnswersThere) {
  Process sim(ardito());
  Peer peer(port_of(sim));
  ASSERT_TRUE(peer.connected());
  EXPECT_THAT(sim.heard, testing::StartsWith("lss-sim: ardito ready, CAN bus rover at udp://127."));
  EXPECT_EQ(peer.ask(kAskType, "581"), kWheel);
  sim.signal(SIGTERM);
  EXPECT_EQ(sim.wait(), 0);
  EXPECT_TRUE(fs::is_empty(folder_));
}

TEST_F(Program, AnswersWhoeverSpokeLast) {
  Process sim(ardito({"--pace"}));
  const std::string port = port_of(sim);
  for (int i = 0; i < 3; ++i) EXPECT_EQ(Peer(port).ask(kAskType, "581"), kWheel);
}

TEST_F(Program, PacedAnswersAreNotFasterThanTheBus) {
  Process sim(ardito({"--pace"}));
  Peer peer(port_of(sim));
  ASSERT_EQ(peer.ask(kAskType, "581"), kWheel);
  constexpr int kQuestions = 500;
  const auto began = Clock::now();
  for (int i = 0; i < kQuestions; ++i) {
    peer.send(kAskType);
    ASSERT_EQ(peer.wait("581", kPatience), kWheel);
  }
  const std::chrono::duration<double> took = Clock::now() - began;
  EXPECT_GE(took.count(), kQuestions * 2 * (47 + 64) / 500e3);
}

TEST_F(Program, ASecondOneOnTheSameBusIsRefused) {
  Process first(ardito());
  const std::string port = port_of(first);
  const fs::path other = folder_ / "other";
  Process second({"ardito", "--dir", other.string(), "--can", "udp://127.0.0.1:" + port});
  EXPECT_EQ(second.wait(), 1);
  EXPECT_THAT(second.heard, HasSubstr("is in use"));
  Process wrong({"ardito", "--dir", other.string(), "--can", "udp://localhost"});
  EXPECT_EQ(wrong.wait(), 1);
  EXPECT_THAT(wrong.heard, HasSubstr("no address of a CAN bus"));
  Process nowhere({"ardito", "--dir", other.string(), "--can", "nosuchcan0"});
  EXPECT_EQ(nowhere.wait(), 1);
  EXPECT_THAT(nowhere.heard, HasSubstr("CAN"));
}

TEST_F(Program, FaultsComeAndGoWhileItRuns) {
  Process sim(ardito());
  Peer peer(port_of(sim));
  ASSERT_EQ(peer.ask(kAskType, "581"), kWheel);
  ASSERT_EQ(fault("node-silent:0x01"), 0);
  peer.send(kAskType);
  EXPECT_EQ(peer.wait("581", std::chrono::milliseconds(300)), "");
  ASSERT_EQ(fault("clear"), 0);
  EXPECT_EQ(peer.ask(kAskType, "581"), kWheel);
  ASSERT_EQ(fault("bus-cut"), 0);
  peer.send(kAskType);
  EXPECT_EQ(peer.wait("581", std::chrono::milliseconds(300)), "");
  ASSERT_EQ(fault("clear:bus-cut"), 0);
  EXPECT_EQ(peer.ask(kAskType, "581"), kWheel);
}

TEST_F(Program, AnUnpluggedBusComesBackAtItsPort) {
  Process sim(ardito());
  Peer peer(port_of(sim));
  ASSERT_EQ(peer.ask(kAskType, "581"), kWheel);
  ASSERT_EQ(fault("unplug:0.5"), 0);
  const auto began = Clock::now();
  EXPECT_EQ(peer.ask(kAskType, "581"), kWheel);
  EXPECT_GE(Clock::now() - began, std::chrono::milliseconds(200));
}

TEST_F(Program, WritesTheTruthWithItsFaults) {
  Process sim(ardito({"--truth", truth().string(), "--fault", "0s:E-TM:2", "--fault",
                      "0s:node-silent:0x11", "--ground", "hills,regolith:0.5"}));
  ASSERT_TRUE(sim.says("ready"));
  const nlohmann::json third = third_truth();
  EXPECT_EQ(third.at("wheel_rad_s").size(), 6u);
  for (const double sinkage_m : third.at("wheel_sinkage_m")) EXPECT_GT(sinkage_m, 0.001);
  EXPECT_EQ(third.at("attached_faults"), nlohmann::json({"E-TM:2:0", "node-silent:0x11"}));
}

TEST_F(Program, ListsItsFaultsAndRefusesOthers) {
  Process list({"faults", "ardito"});
  EXPECT_EQ(list.wait(), 0);
  for (const char* each : {"H-TM:WHEEL[:RPM]", "E-SRG:WHEEL", "node-silent:NODE", "bus-off:SECONDS",
                           "one of 0x01, 0x02", "unplug:SECONDS"}) {
    EXPECT_THAT(list.heard, HasSubstr(each));
  }
  expect_refused(ardito({"--fault", "5s:E-TN:2"}), "did you mean 'E-TM'");
}

TEST_F(Program, RefusesGroundThatItDoesNotKnow) {
  for (const auto& [ground, says] : {std::pair("mud", "on hard ground: flat, hills, rough"),
                                     {"hills,mud", "'mud' is no soil"},
                                     {"sand,hills", "before the comma flat, hills or rough"},
                                     {"sand:0", "'sand:0' is no soil"}}) {
    expect_refused(ardito({"--ground", ground}), says);
  }
  for (const auto& [patch, says] : {std::pair("sand:0.1", "it names no wheels"),
                                    {"mud@4", "'mud' is no soil"},
                                    {"sand@7", "there is no wheel '7'"},
                                    {"sand@4@2-3", "'2-3' is no stretch FROM..TO"},
                                    {"sand@4@2..x", "'x' is no number of metres"},
                                    {"sand@4@3..2", "the stretch ends before it begins"}}) {
    expect_refused(ardito({"--ground", "regolith", "--patch", patch}), says);
  }
  expect_refused(ardito({"--rocks", "1.5"}), "--rocks");
  expect_refused(ardito({"--patch", "sand@4"}), "a patch is in a soil");
  expect_refused(ardito({"--ground", "sand", "--step", "60"}), "there is no step on soil");
}

}  // namespace
}  // namespace lss::sim::ardito
