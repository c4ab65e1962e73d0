// lss-cli shell: lines of a pipe, and what ends it, against a stand-in for the daemon.

#include <fcntl.h>
#include <unistd.h>

#include <array>
#include <csignal>
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

class ShellTest : public ProgramTest {
 protected:
  bool comes_to(Mode mode) {
    return await([&] { return daemon_.mode() == mode; });
  }
  bool beats() {
    const std::uint64_t before = daemon_.heartbeats();
    return await([&] { return daemon_.heartbeats() >= before + 10; });
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

}  // namespace
}  // namespace lss::cli::test
