// lss-cli shell: lines of a pipe or a terminal, and its end, against a stand-in for the daemon.

#include <fcntl.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <cstdlib>
#include <utility>

#include "tests/cli/program_test.h"

namespace lss::cli::test {
namespace {

using zebro::Mode;

class OpenPipe {
 public:
  OpenPipe() { EXPECT_EQ(pipe2(fds_.data(), O_CLOEXEC), 0); }
  ~OpenPipe() {
    end();
    close(fds_[0]);
  }
  OpenPipe(const OpenPipe&) = delete;
  OpenPipe& operator=(const OpenPipe&) = delete;

  int read_fd() const { return fds_[0]; }
  void put(const std::string& text) const {
    EXPECT_EQ(write(fds_[1], text.data(), text.size()), static_cast<ssize_t>(text.size()));
  }
  void end() {
    if (const int fd = std::exchange(fds_[1], -1); fd >= 0) close(fd);
  }

 private:
  std::array<int, 2> fds_{-1, -1};
};

// The keyboard of a shell, which then reads no history.
class Keyboard {
 public:
  Keyboard() : end_(posix_openpt(O_RDWR | O_NOCTTY | O_CLOEXEC)) {
    unsetenv("HOME");
    EXPECT_EQ(grantpt(end_), 0);
    EXPECT_EQ(unlockpt(end_), 0);
    terminal_ = open(ptsname(end_), O_RDWR | O_NOCTTY | O_CLOEXEC);
    EXPECT_GE(terminal_, 0);
  }
  ~Keyboard() {
    unplug();
    close(terminal_);
  }
  Keyboard(const Keyboard&) = delete;
  Keyboard& operator=(const Keyboard&) = delete;

  int terminal() const { return terminal_; }
  void type(const std::string& text) const {
    EXPECT_EQ(write(end_, text.data(), text.size()), static_cast<ssize_t>(text.size()));
  }
  void unplug() {
    if (const int fd = std::exchange(end_, -1); fd >= 0) close(fd);
  }

 private:
  int end_, terminal_ = -1;
};

class ShellTest : public ProgramTest {
 protected:
  bool comes_to(Mode mode) {
    return await([&] { return daemon_.mode() == mode; });
  }
  bool beats() {
    const std::uint64_t before = daemon_.heartbeats();
    return await([&] { return daemon_.heartbeats() >= before + 10; });
  }
  // No heartbeat comes for the time of seven.
  bool falls_silent() {
    std::uint64_t last = daemon_.heartbeats();
    Clock::time_point since = Clock::now();
    return await([&] {
      if (const std::uint64_t now = daemon_.heartbeats(); std::exchange(last, now) != now)
        since = Clock::now();
      return Clock::now() - since > seconds(1.5);
    });
  }
  bool hears(std::uint16_t kind) {
    return await([&] { return daemon_.last(kind).kind == kind; });
  }
  // The first motion has stopped, and no other one followed.
  void expect_stopped(const Ended& ended) const {
    EXPECT_EQ(ended.code, 6) << ended.err;
    EXPECT_THAT(daemon_.kinds(), ElementsAre(kStart, kStand, kWalk, kStop));
    EXPECT_EQ(daemon_.state(), lss_STATE_IDLE);
  }

  FakeDaemon daemon_{domain()};
};

class ShellOfASignal : public ShellTest, public testing::WithParamInterface<int> {};

TEST_P(ShellOfASignal, EndsAfterTheSafeStopOfTheLineThatItInterrupts) {
  Program shell(domain(), {"shell"}, "walk forward --for 10min\nwalk backward --for 100ms\n");
  ASSERT_TRUE(comes_to(Mode::walking));
  shell.signal(GetParam());
  expect_stopped(shell.wait());
}

TEST_P(ShellOfASignal, EndsWithASafeStopWhileItWaitsForALineUnderItsHeartbeat) {
  const OpenPipe input;
  Program shell(domain(), {"shell"}, input.read_fd());
  input.put("walk forward\n");
  ASSERT_TRUE(comes_to(Mode::walking) && beats());
  shell.signal(GetParam());
  expect_stopped(shell.wait());
}

INSTANTIATE_TEST_SUITE_P(Each, ShellOfASignal, testing::Values(SIGINT, SIGTERM, SIGHUP));

TEST_F(ShellTest, LinesOfAPipeComeInPiecesAndTheLastMayLackItsEnd) {
  OpenPipe input;
  Program shell(domain(), {"shell"}, input.read_fd());
  input.put("stand\n\nsto");
  ASSERT_TRUE(comes_to(Mode::standing));
  input.put("w");
  input.end();
  EXPECT_EQ(shell.wait().code, 0);
  EXPECT_THAT(daemon_.kinds(), ElementsAre(kStart, kStand, kStow, kStop));
}

TEST_F(ShellTest, NoLineFollowsAVerbThatEndsByCtrlC) {
  Program shell(domain(), {"shell"}, "walk forward\nheartbeat\nwalk backward --for 100ms\n");
  ASSERT_TRUE(comes_to(Mode::walking) && beats());
  shell.signal(SIGINT);
  EXPECT_EQ(shell.wait().code, 0);
  EXPECT_THAT(daemon_.kinds(), ElementsAre(kStart, kStand, kWalk, kStop));
}

TEST_F(ShellTest, NoStepOfASequenceFollowsAVerbThatEndsByCtrlC) {
  Program sequence(domain(), {"run", "-e", "walk forward; heartbeat; walk backward --for 100ms"});
  ASSERT_TRUE(comes_to(Mode::walking) && beats());
  sequence.signal(SIGINT);
  expect_stopped(sequence.wait());
}

TEST_F(ShellTest, AfterAStopThatWasLostTheHeartbeatEndsAndTheNextCtrlCStopsAgain) {
  daemon_.trouble(kStop, {Trouble::Kind::no_answer, Reason::none, 1});
  const Keyboard keyboard;
  Program shell(domain(), {"shell"}, keyboard.terminal());
  keyboard.type("walk forward --for 10min\n");
  ASSERT_TRUE(comes_to(Mode::walking));
  shell.signal(SIGINT);
  ASSERT_TRUE(hears(kStop) && falls_silent());
  EXPECT_EQ(daemon_.mode(), Mode::walking);
  shell.signal(SIGINT);
  EXPECT_TRUE(await([&] { return daemon_.state() == lss_STATE_IDLE; }));
  keyboard.type("exit\n");
  const Ended ended = shell.wait();
  EXPECT_EQ(ended.code, 0) << ended.err;
  EXPECT_THAT(ended.err, HasSubstr("without a heartbeat the daemon stops the vehicle in"));
  EXPECT_THAT(daemon_.kinds(), ElementsAre(kStart, kStand, kWalk, kStop, kStop));
}

TEST_F(ShellTest, AtThePromptTheNextCtrlCStopsAgainToo) {
  daemon_.trouble(kStop, {Trouble::Kind::no_answer, Reason::none, 1});
  const Keyboard keyboard;
  Program shell(domain(), {"shell"}, keyboard.terminal());
  keyboard.type("walk forward\n");
  ASSERT_TRUE(comes_to(Mode::walking) && beats());
  shell.signal(SIGINT);
  ASSERT_TRUE(hears(kStop) && falls_silent());
  shell.signal(SIGINT);
  EXPECT_TRUE(await([&] { return daemon_.state() == lss_STATE_IDLE; }));
  keyboard.type("exit\n");
  EXPECT_EQ(shell.wait().code, 0);
  EXPECT_THAT(daemon_.kinds(), ElementsAre(kStart, kStand, kWalk, kStop, kStop));
}

TEST_F(ShellTest, ASequenceWhoseStopWasLostSendsItAgainAtItsEnd) {
  daemon_.trouble(kStop, {Trouble::Kind::no_answer, Reason::none, 1});
  Program sequence(domain(), {"run", "-e", "walk forward --for 10min"});
  ASSERT_TRUE(comes_to(Mode::walking));
  sequence.signal(SIGINT);
  EXPECT_EQ(sequence.wait().code, 7);
  EXPECT_EQ(daemon_.state(), lss_STATE_IDLE);
  EXPECT_THAT(daemon_.kinds(), ElementsAre(kStart, kStand, kWalk, kStop, kStop));
}

TEST_F(ShellTest, ASecondCtrlCLeavesATerminalAtOnce) {
  daemon_.trouble(kStop, {Trouble::Kind::never_ends});
  Keyboard keyboard;
  Program shell(domain(), {"shell"}, keyboard.terminal());
  keyboard.type("walk forward --for 10min\n");
  ASSERT_TRUE(comes_to(Mode::walking));
  shell.signal(SIGINT);
  ASSERT_TRUE(hears(kStop));
  shell.signal(SIGINT);
  keyboard.unplug();
  const Ended ended = shell.wait();
  EXPECT_EQ(ended.code, 7);
  EXPECT_THAT(ended.err, HasSubstr("left at once"));
}

}  // namespace
}  // namespace lss::cli::test
