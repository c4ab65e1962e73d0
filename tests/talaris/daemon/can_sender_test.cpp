// A second thread that sends on a port which its owner opens and closes, on real sockets of the
// loopback interface.

#include "drivers/can/can_sender.h"

#include <arpa/inet.h>
#include <dirent.h>
#include <fcntl.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <atomic>
#include <thread>
#include <vector>

#include "drivers/can/can_port.h"
#include "tests/support/allocations.h"
#include "tests/support/can_frames.h"
#include "tests/support/udp_peer.h"

namespace lss {
namespace {

using testing_support::frame;
using Result = CanSender::Result;

// The other end: datagrams as they come.
class Peer : public testing_support::UdpPeer {
 public:
  // The next datagram and the port that it came from; empty: none within `wait_ms`.
  std::vector<std::uint8_t> receive(int wait_ms = 2000) {
    pollfd p{fd(), POLLIN, 0};
    if (::poll(&p, 1, wait_ms) != 1) return {};
    std::vector<std::uint8_t> bytes(2048);
    sockaddr_in from{};
    socklen_t size = sizeof from;
    const ssize_t got =
        ::recvfrom(fd(), bytes.data(), bytes.size(), 0, reinterpret_cast<sockaddr*>(&from), &size);
    from_port = ntohs(from.sin_port);
    bytes.resize(static_cast<std::size_t>(std::max<ssize_t>(got, 0)));
    return bytes;
  }
  int from_port = 0;
};

int open_files() {
  int count = 0;
  DIR* folder = ::opendir("/proc/self/fd");
  while (::readdir(folder) != nullptr) ++count;
  ::closedir(folder);
  return count;
}

struct Bench {
  Bench() { port.attach(&sender); }
  CanStatus open() { return port.open(peer.path().c_str()); }

  Peer peer;
  CanSender sender;
  CanPort port;
};

TEST(CanSender, BeforeThePortIsOpenNothingIsSentAndItIsCounted) {
  CanSender sender;
  EXPECT_EQ(sender.send(frame(0x220, {1, 1})), Result::closed);
  EXPECT_EQ(sender.counters().closed, 1u);
  EXPECT_EQ(sender.generation(), 0u);
}

TEST(CanSender, ItsFramesGoOutByTheSameSocketNumberedWithThePorts) {
  Bench b;
  ASSERT_EQ(b.open(), CanStatus::ok);
  EXPECT_EQ(b.sender.generation(), 1u);
  int from_port = 0;
  for (std::uint8_t n = 0; n < 20; ++n) {
    if (n % 3 == 0) {
      b.port.send(frame(0x77F, {5}), kSecond);
      EXPECT_TRUE(b.port.flush(kSecond));
    } else {
      EXPECT_EQ(b.sender.send(frame(0x220, {n, n})), Result::sent);
    }
    const auto datagram = b.peer.receive();
    ASSERT_GE(datagram.size(), 11u);
    EXPECT_EQ(datagram[2], n) << "sequence";
    if (n > 0) {
      EXPECT_EQ(b.peer.from_port, from_port);
    }
    from_port = b.peer.from_port;
    if (n % 3 == 0) continue;
    EXPECT_EQ(datagram, (std::vector<std::uint8_t>{2, 0, n, 0, 1, 0, 0, 0x02, 0x20, 2, n, n}));
  }
  EXPECT_EQ(b.sender.counters().sent, 13u);
}

TEST(CanSender, AClosedPortIsSeenAndTheNextOneHasAnotherGeneration) {
  Bench b;
  ASSERT_EQ(b.open(), CanStatus::ok);
  const std::uint32_t first = b.sender.generation();
  EXPECT_EQ(b.sender.send(frame(0x220, {1, 1})), Result::sent);
  b.port.close();
  EXPECT_EQ(b.sender.send(frame(0x220, {1, 2})), Result::closed);
  ASSERT_EQ(b.open(), CanStatus::ok);
  EXPECT_NE(b.sender.generation(), first);
  EXPECT_EQ(b.sender.send(frame(0x220, {1, 3})), Result::sent);
}

// "All shut" has to be the first word on a bus that was opened again: orders from before are not.
TEST(CanSender, OnANewPortNothingIsSaidBeforeItIsKnownToBeNew) {
  Bench b;
  ASSERT_EQ(b.open(), CanStatus::ok);
  b.sender.generation();
  EXPECT_EQ(b.sender.send(frame(0x220, {1, 1})), Result::sent);
  b.port.close();
  ASSERT_EQ(b.open(), CanStatus::ok);
  EXPECT_EQ(b.sender.send(frame(0x220, {1, 2})), Result::closed);
  EXPECT_EQ(b.sender.counters().closed, 1u);
  b.sender.generation();
  EXPECT_EQ(b.sender.send(frame(0x220, {0, 0})), Result::sent);
  b.sender.renew();  // back from bus-off: the same
  EXPECT_EQ(b.sender.send(frame(0x220, {1, 3})), Result::closed);
  b.sender.generation();
  EXPECT_EQ(b.sender.send(frame(0x220, {0, 0})), Result::sent);
  for (const int bits : {1, 0, 0}) EXPECT_EQ(b.peer.receive().at(10), bits);
}

// With a local port of its own the socket must be gone before it can be opened again.
TEST(CanSender, NothingOfAClosedPortStaysOpen) {
  Bench b;
  const int before = open_files();
  for (int n = 0; n < 20; ++n) {
    ASSERT_EQ(b.open(), CanStatus::ok);
    b.sender.generation();
    EXPECT_EQ(b.sender.send(frame(0x220, {1, 1})), Result::sent);
    b.port.close();
    EXPECT_EQ(open_files(), before);
  }
}

TEST(CanSender, APortThatCouldNotBeOpenedOffersNothing) {
  Bench b;
  EXPECT_NE(b.port.open("udp://nowhere"), CanStatus::ok);
  EXPECT_EQ(b.sender.send(frame(0x220, {1, 1})), Result::closed);
}

// One thread opens and closes, files of others take the numbers that became free, the second
// thread sends all the while: every datagram arrives whole, nothing goes into the other files.
TEST(CanSender, OpeningAndClosingUnderTheSecondThread) {
  Bench b;
  std::atomic<bool> stop{false};
  std::atomic<int> foreign{0};
  const int before = open_files();
  std::thread second([&] {
    for (std::uint8_t n = 0; !stop.load(); ++n) {
      b.sender.generation();
      b.sender.send(frame(0x220, {0x55, n}));
    }
  });
  std::thread reader([&] {
    while (!stop.load()) {
      const auto datagram = b.peer.receive(20);
      if (datagram.empty()) continue;
      if (datagram.size() != 12 || datagram[0] != 2 || datagram[10] != 0x55) ++foreign;
    }
  });
  for (int round = 0; round < 1'000; ++round) {
    if (b.open() != CanStatus::ok) ADD_FAILURE() << "open";
    const std::uint64_t sent = b.sender.counters().sent;
    while (round % 10 == 0 && b.sender.counters().sent < sent + 3) std::this_thread::yield();
    b.port.close();
    int pipes[2];  // take the numbers that became free
    ASSERT_EQ(::pipe2(pipes, O_CLOEXEC | O_NONBLOCK), 0);
    std::uint8_t byte = 0;
    if (::read(pipes[0], &byte, 1) > 0) ++foreign;
    ::close(pipes[0]);
    ::close(pipes[1]);
  }
  stop.store(true);
  second.join();
  reader.join();
  EXPECT_EQ(foreign.load(), 0);
  EXPECT_GE(b.sender.counters().sent, 300u);
  EXPECT_EQ(open_files(), before);
}

TEST(CanSender, NothingAllocates) {
  Bench b;
  ASSERT_EQ(b.open(), CanStatus::ok);
  const CanFrame valve = frame(0x220, {1, 1});
  b.sender.generation();
  const std::uint64_t before = testing_support::allocations();
  for (int n = 0; n < 100; ++n) b.sender.send(valve);
  EXPECT_EQ(testing_support::allocations(), before);
}

}  // namespace
}  // namespace lss
