// On real pseudo-terminals.

#include "drivers/serial/serial_port.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <stdlib.h>
#include <sys/ioctl.h>
#include <sys/wait.h>
#include <termios.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <numeric>
#include <span>
#include <string>
#include <vector>

#include "daemon/runtime/serial_bus.h"
#include "tests/support/temp_folder.h"

namespace lss {
namespace {

using Status = SerialPort::Status;
using Bytes = std::vector<std::uint8_t>;

// The far end of a pseudo-terminal.
class Pty {
 public:
  Pty() : master_(::posix_openpt(O_RDWR | O_NOCTTY)) {
    EXPECT_GE(master_, 0);
    EXPECT_EQ(::grantpt(master_), 0);
    EXPECT_EQ(::unlockpt(master_), 0);
    path_ = ::ptsname(master_);
  }
  ~Pty() { hang_up(); }
  Pty(const Pty&) = delete;
  Pty& operator=(const Pty&) = delete;

  void hang_up() {
    if (master_ >= 0) ::close(master_);
    master_ = -1;
  }
  int fd() const { return master_; }
  const std::string& path() const { return path_; }

 private:
  int master_;
  std::string path_;
};

bool readable(int fd) {
  pollfd p{fd, POLLIN, 0};
  return ::poll(&p, 1, 2000) == 1;
}

Bytes read_from(int fd, std::size_t count) {
  Bytes bytes;
  while (bytes.size() < count && readable(fd)) {
    std::uint8_t piece[256];
    const ssize_t n = ::read(fd, piece, sizeof piece);
    if (n <= 0) break;
    bytes.insert(bytes.end(), piece, piece + n);
  }
  return bytes;
}

Bytes read_from(SerialPort& port, std::size_t count) {
  Bytes bytes;
  while (bytes.size() < count && readable(port.fd())) {
    std::uint8_t piece[256];
    const auto got = port.read(piece);
    if (got.lost) break;
    bytes.insert(bytes.end(), piece, piece + got.bytes);
  }
  return bytes;
}

class SerialPortOnDisk : public ::testing::Test {
 protected:
  std::string path(const char* name) const { return (folder_ / name).string(); }
  const testing_support::TempFolder folder_;
};

TEST(SerialPort, All256BytesPassUnchangedInBothDirections) {
  Pty pty;
  SerialPort port;
  ASSERT_EQ(port.open(pty.path().c_str(), 115'200, false), Status::ok);
  Bytes all(256);
  std::iota(all.begin(), all.end(), std::uint8_t{0});

  EXPECT_EQ(port.write(all).bytes, all.size());
  EXPECT_EQ(read_from(pty.fd(), all.size()), all);
  ASSERT_EQ(::write(pty.fd(), all.data(), all.size()), 256);
  EXPECT_EQ(read_from(port, all.size()), all);
}

TEST(SerialPort, NothingToReadIsNeitherBytesNorLoss) {
  Pty pty;
  SerialPort port;
  ASSERT_EQ(port.open(pty.path().c_str(), 115'200, false), Status::ok);
  std::uint8_t byte[1];
  const auto got = port.read(byte);
  EXPECT_EQ(got.bytes, 0u);
  EXPECT_FALSE(got.lost);
}

TEST(SerialPort, TheLineIsRawEightBitsNoParityOneStopAtTheRateAskedFor) {
  Pty pty;
  SerialPort port;
  ASSERT_EQ(port.open(pty.path().c_str(), 1'000'000, false), Status::ok);
  termios line{};
  ASSERT_EQ(::tcgetattr(port.fd(), &line), 0);
  EXPECT_EQ(::cfgetospeed(&line), static_cast<speed_t>(B1000000));
  EXPECT_EQ(::cfgetispeed(&line), static_cast<speed_t>(B1000000));
  EXPECT_EQ(line.c_cflag & CSIZE, static_cast<tcflag_t>(CS8));
  EXPECT_EQ(line.c_cflag & (PARENB | CSTOPB | CRTSCTS), 0u);
  EXPECT_EQ(line.c_lflag & (ECHO | ICANON | ISIG), 0u);
  EXPECT_NE(::fcntl(port.fd(), F_GETFL) & O_NONBLOCK, 0);
  EXPECT_NE(::fcntl(port.fd(), F_GETFD) & FD_CLOEXEC, 0);
}

TEST(SerialPort, BytesFromBeforeOpeningAreGone) {
  Pty pty;
  {
    SerialPort before;
    ASSERT_EQ(before.open(pty.path().c_str(), 115'200, false), Status::ok);
    ASSERT_EQ(::write(pty.fd(), "old", 3), 3);
    ASSERT_TRUE(readable(before.fd()));
    const int keep = ::open(pty.path().c_str(), O_RDWR | O_NOCTTY);  // the queue outlives the port
    ASSERT_GE(keep, 0);
    before.close();
    SerialPort port;
    ASSERT_EQ(port.open(pty.path().c_str(), 115'200, false), Status::ok);
    ASSERT_EQ(::write(pty.fd(), "new", 3), 3);
    EXPECT_EQ(read_from(port, 3), (Bytes{'n', 'e', 'w'}));
    ::close(keep);
  }
}

TEST(SerialPort, AFullQueueTakesFewerBytesAndIsNoLoss) {
  Pty pty;
  SerialPort port;
  ASSERT_EQ(port.open(pty.path().c_str(), 115'200, false), Status::ok);
  const Bytes much(1 << 20, 0x55);
  std::size_t taken = 0;
  SerialPort::Transfer put;
  do {
    put = port.write(much);
    taken += put.bytes;
  } while (put.bytes > 0);
  EXPECT_FALSE(put.lost);
  EXPECT_GT(taken, 0u);
  EXPECT_LT(taken, much.size());
}

std::size_t fill(SerialPort& port) {
  const Bytes piece(1 << 10, 0x55);
  std::size_t taken = 0;
  while (const std::size_t put = port.write(piece).bytes) taken += put;
  return taken;
}

// The other end of a pseudo-terminal has up to 4 KiB already.
TEST(SerialPort, ClosingDiscardsWhatTheLineHasNotTaken) {
  Pty pty;
  SerialPort port;
  ASSERT_EQ(port.open(pty.path().c_str(), 115'200, false), Status::ok);
  const std::size_t taken = fill(port);
  ASSERT_GT(taken, 4096u);
  port.close();
  EXPECT_LE(read_from(pty.fd(), taken).size(), 4096u);
}

TEST(SerialPort, ASecondOpenerDiscardsNothingOfTheFirst) {
  Pty pty;
  SerialPort first, second;
  ASSERT_EQ(first.open(pty.path().c_str(), 115'200, false), Status::ok);
  const std::size_t taken = fill(first);
  EXPECT_EQ(second.open(pty.path().c_str(), 115'200, false), Status::in_use);
  second.close();
  EXPECT_EQ(read_from(pty.fd(), taken).size(), taken);
}

// A driver that has always something to send.
struct Talkative {
  static constexpr std::size_t kMaxReplies = 1;
  explicit Talkative(int) {}
  void receive(std::span<const std::uint8_t>, TimeNs) noexcept {}
  std::span<const std::uint8_t> transmit(TimeNs) noexcept {
    ++transmitted;
    return bytes;
  }
  TimeNs next_wake() const noexcept { return 0; }
  int counters() const noexcept { return 0; }
  Bytes bytes = Bytes(4096, 0x55);
  static inline int transmitted = 0;
};

TEST(SerialLine, ThatTakesNoBytesForATenthOfASecondIsGivenUp) {
  Pty pty;
  SerialLine<Talkative, int, int, int, int> line(0, {.path = pty.path()});
  ASSERT_EQ(line.open(), Status::ok);
  TimeNs now = 5 * kSecond;
  EXPECT_TRUE(line.serve(false, now)) << "its queue is full now, which is no loss";
  EXPECT_NE(line.events() & POLLOUT, 0);
  // Once more the kernel may pass on what is in its queue, and take more.
  bool served = true;
  for (int before = -1; before != Talkative::transmitted;) {
    EXPECT_TRUE(served);
    EXPECT_EQ(line.next_wake(), now + 100 * kMillisecond);
    now += 100 * kMillisecond;
    before = Talkative::transmitted;
    served = line.serve(false, now);
  }
  EXPECT_FALSE(served);
}

TEST(SerialLine, ThatTakesBytesAgainWithinATenthOfASecondIsKept) {
  Pty pty;
  SerialLine<Talkative, int, int, int, int> line(0, {.path = pty.path()});
  ASSERT_EQ(line.open(), Status::ok);
  const TimeNs full = 5 * kSecond;
  EXPECT_TRUE(line.serve(false, full));
  EXPECT_TRUE(line.serve(false, full + 100 * kMillisecond - 1));
}

struct Counted : Talkative {
  struct Counters {
    std::uint64_t overflows = 0;
  };
  using Talkative::Talkative;
  Counters counters() const noexcept { return {.overflows = 2}; }
};

TEST(SerialLine, ReportsRepliesThatTheThreadDroppedWithThoseOfTheDriver) {
  SerialLine<Counted, int, int, int, Counted::Counters> line(0, {});
  decltype(line)::Report report;
  line.describe(report, 3);
  EXPECT_EQ(report.counters.overflows, 5u);
}

// A driver that only listens.
struct Quiet : Talkative {
  using Talkative::Talkative;
  void receive(std::span<const std::uint8_t> more, TimeNs) noexcept { received += more.size(); }
  std::span<const std::uint8_t> transmit(TimeNs) noexcept { return {}; }
  TimeNs next_wake() const noexcept { return kSecond; }
  std::size_t received = 0;
};

// Whether the kernel passes on so many bytes within 2 s, all at once.
bool wait_together(int fd, int count) {
  int bytes = 0;
  for (int ms = 0; bytes != count && ms < 2000; ++ms) {
    ::poll(nullptr, 0, 1);
    if (::ioctl(fd, FIONREAD, &bytes) != 0) return false;
  }
  return bytes == count;
}

TEST(SerialLine, LeavesTheRestOfAFloodForItsNextTurn) {
  Pty pty;
  SerialLine<Quiet, int, int, int, int> line(0, {.path = pty.path()});
  ASSERT_EQ(line.open(), Status::ok);
  const Bytes flood(3072, 0x55);
  ASSERT_EQ(::write(pty.fd(), flood.data(), flood.size()), 3072);
  ASSERT_TRUE(wait_together(line.fd(), 3072));

  EXPECT_TRUE(line.serve(true, kMillisecond));
  EXPECT_EQ(line.driver().received, 2048u);
  EXPECT_EQ(line.next_wake(), 0) << "its next turn is at once";
  EXPECT_TRUE(line.serve(false, kMillisecond));
  EXPECT_EQ(line.driver().received, flood.size());
  EXPECT_EQ(line.next_wake(), kSecond) << "nothing is left";
}

TEST(SerialPort, HangUpIsSeenByReadAndWrite) {
  Pty pty;
  SerialPort port;
  ASSERT_EQ(port.open(pty.path().c_str(), 115'200, false), Status::ok);
  pty.hang_up();
  ASSERT_TRUE(readable(port.fd()));
  std::uint8_t byte[1] = {0};
  EXPECT_TRUE(port.read(byte).lost);
  EXPECT_TRUE(port.write(byte).lost);
}

TEST_F(SerialPortOnDisk, ALinkIsFollowedAgainWhenThePortIsOpenedAgain) {
  const std::string link = path("legs");
  auto first = std::make_unique<Pty>();
  std::filesystem::create_symlink(first->path(), link);
  SerialPort port;
  ASSERT_EQ(port.open(link.c_str(), 115'200, false), Status::ok);
  first->hang_up();
  std::uint8_t byte[1];
  ASSERT_TRUE(readable(port.fd()));
  ASSERT_TRUE(port.read(byte).lost);
  // Elsewhere: the terminal's number may be that of another test's already.
  std::filesystem::remove(link);
  std::filesystem::create_symlink(path("gone"), link);
  EXPECT_EQ(port.open(link.c_str(), 115'200, false), Status::absent);
  EXPECT_FALSE(port.is_open());

  Pty second;
  std::filesystem::remove(link);
  std::filesystem::create_symlink(second.path(), link);
  ASSERT_EQ(port.open(link.c_str(), 115'200, false), Status::ok);
  ASSERT_EQ(port.write(Bytes{'x'}).bytes, 1u);
  EXPECT_EQ(read_from(second.fd(), 1), (Bytes{'x'}));
}

TEST(SerialPort, ASecondOpenerIsTurnedAwayAndTheFirstIsNotDisturbed) {
  Pty pty;
  SerialPort first, second;
  ASSERT_EQ(first.open(pty.path().c_str(), 115'200, false), Status::ok);
  EXPECT_EQ(second.open(pty.path().c_str(), 9'600, false), Status::in_use);
  termios line{};
  ASSERT_EQ(::tcgetattr(first.fd(), &line), 0);
  EXPECT_EQ(::cfgetospeed(&line), static_cast<speed_t>(B115200));
  first.close();
  EXPECT_EQ(second.open(pty.path().c_str(), 9'600, false), Status::ok);
}

TEST(SerialPort, AnOpenerInAnotherProcessIsTurnedAwayUntilTheFirstIsKilled) {
  Pty pty;
  int ready[2];
  ASSERT_EQ(::pipe(ready), 0);
  const pid_t other = ::fork();
  ASSERT_GE(other, 0);
  if (other == 0) {
    SerialPort theirs;
    const char outcome = theirs.open(pty.path().c_str(), 115'200, false) == Status::ok ? 1 : 0;
    if (::write(ready[1], &outcome, 1) != 1) ::_exit(1);
    ::pause();
    ::_exit(0);
  }
  char outcome = 0;
  ASSERT_EQ(::read(ready[0], &outcome, 1), 1);
  ASSERT_EQ(outcome, 1);
  SerialPort port;
  EXPECT_EQ(port.open(pty.path().c_str(), 115'200, false), Status::in_use);
  ::kill(other, SIGKILL);
  ::waitpid(other, nullptr, 0);
  EXPECT_EQ(port.open(pty.path().c_str(), 115'200, false), Status::ok);
  ::close(ready[0]);
  ::close(ready[1]);
}

TEST_F(SerialPortOnDisk, WhatIsNoTerminalIsCalledSo) {
  std::ofstream(path("file")) << "text";
  SerialPort port;
  EXPECT_EQ(port.open(path("file").c_str(), 115'200, false), Status::not_a_terminal);
  EXPECT_EQ(port.open(folder_.c_str(), 115'200, false), Status::not_a_terminal);
  EXPECT_EQ(port.open("/dev/null", 115'200, false), Status::not_a_terminal);
  EXPECT_FALSE(port.is_open());
}

TEST_F(SerialPortOnDisk, WhatIsNotThereIsAbsent) {
  SerialPort port;
  EXPECT_EQ(port.open(path("nothing").c_str(), 115'200, false), Status::absent);
  EXPECT_EQ(port.error(), ENOENT);
}

TEST(SerialPort, ARateThatDoesNotExistIsRefused) {
  Pty pty;
  SerialPort port;
  EXPECT_EQ(port.open(pty.path().c_str(), 123'456, false), Status::bad_baud);
  EXPECT_FALSE(port.is_open());
}

TEST(SerialPort, WithoutRs485HardwareHalfDuplexOpensAndSaysThatItWasNotGranted) {
  Pty pty;
  SerialPort port;
  ASSERT_EQ(port.open(pty.path().c_str(), 115'200, true), Status::ok);
  EXPECT_FALSE(port.rs485_granted());
}

TEST(SerialPort, AClosedPortLosesEverythingAndBreaksNothing) {
  SerialPort port;
  std::uint8_t byte[1] = {0};
  EXPECT_TRUE(port.read(byte).lost);
  EXPECT_TRUE(port.write(byte).lost);
  port.close();
  EXPECT_FALSE(port.is_open());
}

}  // namespace
}  // namespace lss
