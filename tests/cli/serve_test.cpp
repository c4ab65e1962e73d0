// lss-cli serve: what an OBC that polls gets, against a stand-in for the daemon.

#include <poll.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <cstring>
#include <filesystem>

#include "tests/cli/program_test.h"
#include "tests/cli/strider.h"
#include "tools/lss-cli/obc/frame.h"

namespace lss::cli::test {
namespace {

// The end of an OBC.
class Obc {
 public:
  explicit Obc(const std::string& path) : fd_(::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    std::memcpy(address.sun_path, path.data(), path.size());
    connected_ = ::connect(fd_, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0;
  }
  ~Obc() { close(fd_); }
  Obc(const Obc&) = delete;
  Obc& operator=(const Obc&) = delete;

  bool connected() const { return connected_; }
  void write(const std::string& bytes) const {
    ASSERT_EQ(send(fd_, bytes.data(), bytes.size(), MSG_NOSIGNAL),
              static_cast<ssize_t>(bytes.size()));
  }
  // Without its line end; empty when none came in that time.
  std::string line(int timeout_ms = 20'000) {
    while (text_.find('\n') == std::string::npos) {
      pollfd wait{fd_, POLLIN, 0};
      std::array<char, 4096> buffer{};
      if (::poll(&wait, 1, timeout_ms) != 1) return "";
      const ssize_t count = recv(fd_, buffer.data(), buffer.size(), 0);
      if (count <= 0) return "";
      text_.append(buffer.data(), static_cast<std::size_t>(count));
    }
    const std::size_t end = text_.find('\n');
    std::string line = text_.substr(0, end);
    text_.erase(0, end + 1);
    return line;
  }
  struct Reply {
    std::uint32_t sequence = 0;
    json document;
  };
  Reply reply() {
    const std::string text = line();
    const std::size_t blank = text.find(' ', 9);
    EXPECT_NE(blank, std::string::npos) << text;
    if (blank == std::string::npos) return {};
    const auto sequence = static_cast<std::uint32_t>(std::stoul(text.substr(9)));
    EXPECT_EQ(obc::frame(sequence, text.substr(blank + 1)), text + "\n");  // its CRC
    return {sequence, json::parse(text.substr(blank + 1))};
  }
  json ask(std::uint32_t sequence, const std::string& words) {
    write(obc::frame(sequence, words));
    const Reply answer = reply();
    EXPECT_EQ(answer.sequence, sequence);
    return answer.document;
  }

 private:
  int fd_;
  bool connected_ = false;
  std::string text_;
};

class Serve : public ProgramTest {
 protected:
  explicit Serve(const Birth& birth = {}) : daemon_(domain(), birth) {}
  ~Serve() override { std::filesystem::remove(path_); }

  std::unique_ptr<Obc> connect() {
    std::unique_ptr<Obc> obc;
    EXPECT_TRUE(await([&] {
      obc = std::make_unique<Obc>(path_);
      return obc->connected();
    }));
    return obc;
  }

  FakeDaemon daemon_;
  std::string path_ = "/tmp/lss-obc-test-" + std::to_string(getpid());
  Program program_{domain(), {"serve", "--socket", path_}};
};

TEST_F(Serve, AnswersWhatIsAskedAndNothingElse_O_Int_1) {
  const auto obc = connect();
  EXPECT_EQ(obc->line(1500), "");  // the status of the daemon comes meanwhile
  EXPECT_EQ(obc->ask(1, "status")["state"], "Idle");
  EXPECT_EQ(obc->ask(2, "data")["telemetry"]["modules"][0]["name"], "LF");
  EXPECT_EQ(obc->ask(3, "heartbeat")["obc"]["requests"], 3);
  EXPECT_EQ(obc->line(1500), "");
}

TEST_F(Serve, CommandsAreTheDaemonsOwnAndTheirCourseIsAskedFor) {
  const auto obc = connect();
  EXPECT_THAT(obc->ask(1, "start")["phase"], AnyOf("accepted", "executing", "completed"));
  EXPECT_EQ(daemon_.last(kStart).lease_ms, 2000U);
  EXPECT_STREQ(daemon_.last(kStart).source, "obc");
  std::uint32_t next = 2;
  EXPECT_TRUE(await([&] { return obc->ask(next++, "result 1")["phase"] == "completed"; }));
  EXPECT_THAT(obc->ask(next++, "stand")["command"], "stand");
  EXPECT_THAT(obc->ask(next++, "walk backward --speed high --heading=30")["command"], "walk");
  EXPECT_DOUBLE_EQ(daemon_.last(kWalk).parameter[2], 3);
  EXPECT_THAT(daemon_.kinds(), ElementsAre(kStart, kStand, kWalk));
}

TEST_F(Serve, TheCourseOfACommandIsKnownHoweverOftenItIsAskedFor) {
  const auto obc = connect();
  obc->ask(1, "start");
  for (std::uint32_t i = 2; i < 202; ++i)
    ASSERT_EQ(obc->ask(i, "result 1")["command"], "start") << i;
  EXPECT_EQ(obc->ask(1, "start")["command"], "start");
  EXPECT_THAT(daemon_.kinds(), ElementsAre(kStart)) << "the same line: the stored reply";
}

TEST_F(Serve, ARejectionSaysWhy) {
  daemon_.trouble(kStand, {.kind = Trouble::Kind::reject, .reason = Reason::not_in_state});
  const auto obc = connect();
  const json document = obc->ask(1, "stand");
  EXPECT_EQ(document["phase"], "rejected");
  EXPECT_EQ(document["reason"]["name"], "not_in_state");
  EXPECT_TRUE(document.contains("measured"));
  EXPECT_TRUE(document.contains("limit"));
}

TEST_F(Serve, WhatIsNoRequestIsAnsweredWithSequence0CountedAndNotExecuted_Env_1) {
  const auto obc = connect();
  const std::string sent = obc::frame(5, "start stand");
  int refused = 0;
  for (std::size_t bit = 0; bit < (sent.size() - 1) * 8; ++bit) {
    std::string received = sent;
    received[bit / 8] = static_cast<char>(received[bit / 8] ^ (1 << (bit % 8)));
    const auto lines = std::ranges::count(received, '\n');
    obc->write(received);
    for (int i = 0; i < lines; ++i) {
      EXPECT_EQ(obc->reply().sequence, 0U);
      ++refused;
    }
  }
  obc->write(std::string(5000, 'x') + "\n");
  EXPECT_THAT(obc->reply().document["error"]["text"].get<std::string>(), HasSubstr("longer"));
  EXPECT_EQ(obc->ask(6, "heartbeat")["obc"]["refused"], refused + 1);
  EXPECT_THAT(daemon_.kinds(), IsEmpty());
}

TEST_F(Serve, TheSameLineGetsTheStoredReplyAndIsNotExecutedAgain) {
  const auto obc = connect();
  obc->write(obc::frame(1, "start"));
  const std::string first = obc->line();
  obc->write(obc::frame(1, "start"));
  EXPECT_EQ(obc->line(), first);
  obc->ask(2, "heartbeat");
  EXPECT_TRUE(await([&] { return daemon_.heartbeats() >= 2; }));
  EXPECT_EQ(daemon_.heartbeats(), 2U) << "a sender that hangs in one line renews no lease";
  EXPECT_THAT(daemon_.kinds(), ElementsAre(kStart));
  EXPECT_EQ(obc->ask(1, "stand")["command"], "stand");  // other words: another request
}

TEST_F(Serve, AnEmergencyStopOvertakesACommandThatIsNotAnswered) {
  daemon_.trouble(kStart, {.kind = Trouble::Kind::no_answer});
  const auto obc = connect();
  obc->write(obc::frame(1, "start") + obc::frame(2, "estop"));
  const Obc::Reply stop = obc->reply();
  EXPECT_EQ(stop.sequence, 2U);
  EXPECT_EQ(stop.document["stopped"], true);
  EXPECT_EQ(daemon_.state(), lss_STATE_FATAL_ERROR);
  const Obc::Reply start = obc->reply();
  EXPECT_EQ(start.sequence, 1U);
  EXPECT_EQ(start.document["error"]["exit_code"], 7);
}

TEST_F(Serve, OnlyRequestsAreHeartbeats) {
  const auto obc = connect();
  const std::uint64_t before = daemon_.heartbeats();
  EXPECT_EQ(obc->line(1500), "");
  EXPECT_EQ(daemon_.heartbeats(), before);
  obc->ask(1, "heartbeat");
  EXPECT_TRUE(await([&] { return daemon_.heartbeats() == before + 1; }));
}

TEST_F(Serve, WordsThatAreNoCommandHereAreRefusedWithAnAdvice) {
  const auto obc = connect();
  EXPECT_EQ(obc->ask(1, "wlak forward")["error"]["advice"], "did you mean walk?");
  EXPECT_EQ(obc->ask(2, "walk --for 3s")["error"]["exit_code"], 2);
  EXPECT_EQ(obc->ask(3, "start; stand")["error"]["exit_code"], 2);
  EXPECT_EQ(obc->ask(4, "# nothing")["error"]["exit_code"], 2);
  EXPECT_EQ(obc->ask(5, "walk --heading 120")["error"]["exit_code"], 2);
  EXPECT_EQ(obc->ask(6, "result 77")["error"]["exit_code"], 4);
  EXPECT_EQ(obc->ask(7, "leg ''")["error"]["exit_code"], 2);
  EXPECT_EQ(obc->ask(8, "walk 'forward")["error"]["exit_code"], 2);
  EXPECT_THAT(daemon_.kinds(), IsEmpty());
}

TEST_F(Serve, ANewConnectionReplacesTheOldOneWithoutItsReplies) {
  const auto old = connect();
  old->ask(1, "start");
  const auto next = connect();
  EXPECT_EQ(next->ask(1, "start")["command"], "start");
  EXPECT_EQ(old->line(), "");  // closed
  EXPECT_THAT(daemon_.kinds(), ElementsAre(kStart, kStart));
}

TEST_F(Serve, ASecondServerAtItsSocketEndsAndLeavesTheConnection) {
  const auto obc = connect();
  obc->ask(1, "start");
  const Ended second = run({"serve", "--socket", path_});
  EXPECT_EQ(second.code, 2);
  EXPECT_THAT(second.err, HasSubstr("another process listens at"));
  EXPECT_EQ(obc->ask(1, "start")["command"], "start") << "of the stored replies";
  EXPECT_EQ(obc->ask(2, "heartbeat")["state"], "Operational");
  EXPECT_THAT(daemon_.kinds(), ElementsAre(kStart));
}

TEST_F(Serve, WhatAKilledServerLeftIsReplaced) {
  const auto obc = connect();
  obc->ask(1, "heartbeat");
  program_.signal(SIGKILL);
  program_.wait();
  EXPECT_TRUE(std::filesystem::exists(path_));
  Program next(domain(), {"serve", "--socket", path_});
  EXPECT_TRUE(await([&] { return Obc(path_).connected(); }));
  next.signal(SIGTERM);
  EXPECT_EQ(next.wait().code, 0);
}

TEST_F(Serve, TheSocketIsForItsGroupAndGoesWithTheProgram) {
  const auto obc = connect();
  obc->ask(1, "heartbeat");
  struct stat file {};
  ASSERT_EQ(stat(path_.c_str(), &file), 0);
  EXPECT_EQ(file.st_mode & 0777U, 0660U);
  EXPECT_EQ(run({"serve", "--socket", path_}).code, 2) << "it is taken";
  EXPECT_EQ(run({"serve", "--socket", path_ + "-2", "--group", "no-such-group"}).code, 4);
  EXPECT_EQ(run({"serve", "--socket", "/nowhere/obc"}).code, 2);
  program_.signal(SIGTERM);
  EXPECT_EQ(program_.wait().code, 0);
  EXPECT_NE(stat(path_.c_str(), &file), 0);
}

TEST_F(Serve, WhatWaitedWhileItStoodStillIsNotExecutedExceptAnEmergencyStop) {
  const auto obc = connect();
  obc->ask(1, "start");
  program_.signal(SIGSTOP);
  obc->write(obc::frame(2, "stand") + obc::frame(3, "estop"));
  EXPECT_EQ(obc->line(1500), "");
  program_.signal(SIGCONT);
  const Obc::Reply stand = obc->reply();
  EXPECT_EQ(stand.sequence, 2U);
  EXPECT_EQ(stand.document["error"]["exit_code"], 5);
  EXPECT_THAT(stand.document["error"]["text"].get<std::string>(), HasSubstr("stood still"));
  const Obc::Reply stop = obc->reply();
  EXPECT_EQ(stop.sequence, 3U);
  EXPECT_EQ(stop.document["stopped"], true);
  EXPECT_EQ(obc->ask(4, "heartbeat")["obc"]["late"], 1);
  EXPECT_THAT(daemon_.kinds(), Each(AnyOf(kStart, kEstop)));
}

TEST_F(Serve, TheSameEmergencyStopIsExecutedEachTime) {
  const auto obc = connect();
  const std::string stop = obc::frame(1, "estop");
  for (int i = 0; i < 3; ++i) {
    daemon_.set_state(lss_STATE_OPERATIONAL);
    obc->write(stop);
    EXPECT_EQ(obc->reply().document["stopped"], true);
    EXPECT_EQ(daemon_.state(), lss_STATE_FATAL_ERROR) << i;
  }
}

TEST_F(Serve, WhatAConnectionSentBeforeItWasReplacedIsExecuted) {
  const auto obc = connect();
  obc->ask(1, "start");
  program_.signal(SIGSTOP);
  {
    const auto short_one = connect();
    short_one->write(obc::frame(2, "estop"));
  }
  const auto last = connect();
  program_.signal(SIGCONT);
  EXPECT_TRUE(await([&] { return daemon_.state() == lss_STATE_FATAL_ERROR; }));
  EXPECT_EQ(last->ask(3, "status")["state"], "FatalError");
}

// Its status comes every 8 s then.
TEST_F(Serve, StaysWithADaemonAtRest) {
  const auto obc = connect();
  const Clock::time_point until = Clock::now() + std::chrono::milliseconds(4500);
  ASSERT_TRUE(await([&] { return Clock::now() >= until; }));
  EXPECT_EQ(obc->ask(1, "status")["state"], "Idle");
}

TEST_F(Serve, EndsWithTheDaemon) {
  const auto obc = connect();
  daemon_.fall_silent();
  EXPECT_EQ(program_.wait().code, 3);
  EXPECT_EQ(obc->line(), "");
}

class ServeDescribed : public Serve {
 protected:
  ServeDescribed() : Serve(strider()) {}
};

TEST_F(ServeDescribed, AVehicleThatItWasBuiltWithoutHasItsOwnCommandsAndTelemetry_O_Int_1) {
  const auto obc = connect();
  EXPECT_EQ(obc->ask(1, "status")["vehicle"], "strider");
  EXPECT_EQ(obc->ask(2, "data")["telemetry"]["modules"][2]["temperature_degC"], 21.5);
  EXPECT_EQ(obc->ask(3, "walk forward")["error"]["exit_code"], 4);
  EXPECT_EQ(obc->ask(4, "stride --length 2")["error"]["exit_code"], 2);
  // It answers with the next sample, which this daemon sends also unasked.
  EXPECT_TRUE(await([&] { return daemon_.kinds() == std::vector{kData}; }));
  EXPECT_EQ(obc->ask(5, "stride backward --length 0.3")["command"], "stride");
  EXPECT_DOUBLE_EQ(daemon_.last(kWalk).parameter[1], 0.3);
  EXPECT_EQ(obc->ask(6, "estop")["stopped"], true);
  EXPECT_EQ(daemon_.state(), lss_STATE_FATAL_ERROR);
}

}  // namespace
}  // namespace lss::cli::test
