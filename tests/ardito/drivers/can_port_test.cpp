// On real sockets of the loopback interface. CAN interfaces themselves need a kernel that has them.

#include "drivers/can/can_port.h"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cstring>
#include <string>
#include <vector>

#include "tests/support/allocations.h"
#include "tests/support/can_frames.h"
#include "tests/support/udp_peer.h"

namespace lss {
namespace {

using Status = CanPort::Status;
using testing_support::Bytes;
using testing_support::frame;

TimeNs now_ns() { return read_clocks().monotonic_ns; }

bool readable(int fd) {
  pollfd p{fd, POLLIN, 0};
  return ::poll(&p, 1, 2000) == 1;
}

// The other end.
class Peer : public testing_support::UdpPeer {
 public:
  void send(int to_port, const Bytes& datagram) {
    const sockaddr_in to = loopback(static_cast<std::uint16_t>(to_port));
    EXPECT_EQ(::sendto(fd(), datagram.data(), datagram.size(), 0,
                       reinterpret_cast<const sockaddr*>(&to), sizeof to),
              static_cast<ssize_t>(datagram.size()));
  }
  void send(int to_port, const std::vector<CanFrame>& frames) {
    for (const CanFrame& f : frames) {
      if (writer_.add(f)) continue;
      flush(to_port);
      writer_.add(f);
    }
    flush(to_port);
  }

  // Whole datagrams, until `count` frames have come.
  std::vector<CanFrame> receive(std::size_t count) {
    std::vector<CanFrame> frames;
    Bytes bytes(2048);
    while (frames.size() < count && readable(fd())) {
      socklen_t size = sizeof from;
      const ssize_t got = ::recvfrom(fd(), bytes.data(), bytes.size(), 0,
                                     reinterpret_cast<sockaddr*>(&from), &size);
      if (got < 0) break;
      reader_.begin(std::span(bytes).first(static_cast<std::size_t>(got)));
      CanFrame next;
      while (reader_.next(next)) frames.push_back(next);
    }
    return frames;
  }

  sockaddr_in from{};

 private:
  void flush(int to_port) {
    const auto datagram = writer_.take();
    send(to_port, Bytes(datagram.begin(), datagram.end()));
  }

  CannelloniReader reader_;
  CannelloniWriter writer_;
};

std::vector<CanFrame> receive(CanPort& port, std::size_t count, std::size_t at_once = 16) {
  std::vector<CanFrame> frames;
  std::vector<CanFrame> some(at_once);
  while (frames.size() < count && readable(port.fd())) {
    CanPort::Received got;
    do {
      got = port.receive(some);
      frames.insert(frames.end(), some.begin(), some.begin() + static_cast<long>(got.frames));
    } while (got.more);
    if (got.lost) break;
  }
  return frames;
}

std::vector<CanFrame> without_time(std::vector<CanFrame> frames) {
  for (CanFrame& f : frames) f.time_ns = 0;
  return frames;
}

std::vector<CanFrame> numbered(std::size_t count) {
  std::vector<CanFrame> frames;
  for (std::size_t n = 0; n < count; ++n) {
    frames.push_back(frame(0x181, {static_cast<std::uint8_t>(n), static_cast<std::uint8_t>(n >> 8),
                                   3, 4, 5, 6, 7, 8}));
  }
  return frames;
}

TEST(CanPort, FramesGoBothWaysInOrder) {
  Peer peer;
  CanPort port;
  ASSERT_EQ(port.open(peer.path().c_str()), Status::ok);
  const std::vector<CanFrame> sent = {frame(0x080, {}), frame(0x201, {1, 2, 3, 4, 5, 6}),
                                      frame(0x77F, {5})};
  for (const CanFrame& f : sent) port.send(f, now_ns());
  EXPECT_TRUE(port.flush(now_ns()));
  EXPECT_EQ(peer.receive(3), sent);
  EXPECT_EQ(port.counters().sent, 3u);

  const std::vector<CanFrame> answers = numbered(3);
  peer.send(Peer::port_of(port.fd()), answers);
  EXPECT_EQ(without_time(receive(port, 3)), answers);
  EXPECT_EQ(port.counters().received, 3u);
}

TEST(CanPort, MoreFramesThanFitIntoOneDatagramAndOneCallArriveInOrder) {
  Peer peer;
  CanPort port;
  ASSERT_EQ(port.open(peer.path().c_str()), Status::ok);
  const auto many = numbered(300);
  peer.send(Peer::port_of(port.fd()), many);
  EXPECT_EQ(without_time(receive(port, many.size(), 7)), many);
  for (const CanFrame& f : numbered(CanQueue::kLength)) port.send(f, now_ns());
  EXPECT_TRUE(port.flush(now_ns()));
  EXPECT_EQ(peer.receive(CanQueue::kLength), numbered(CanQueue::kLength));
}

// The kernel begins to stamp some time after it was asked: the first tries may be too early.
TEST(CanPort, FramesAreStampedWithTheirArrivalNotWithTheirReading) {
  Peer peer;
  CanPort port;
  ASSERT_EQ(port.open(peer.path().c_str()), Status::ok);
  bool stamped = false;
  for (int n = 0; n < 100 && !stamped; ++n) {
    const TimeNs before = now_ns();
    peer.send(Peer::port_of(port.fd()), numbered(1));
    ASSERT_TRUE(readable(port.fd()));
    const TimeNs arrived = now_ns();
    while (now_ns() < arrived + 20 * kMillisecond) {
    }
    const auto frames = receive(port, 1);
    ASSERT_EQ(frames.size(), 1u);
    const TimeNs tolerance = kMillisecond;  // two clocks are read one after the other
    stamped = frames[0].time_ns >= before - tolerance && frames[0].time_ns <= arrived + tolerance;
  }
  EXPECT_TRUE(stamped);
}

TEST(CanPort, DatagramsOfOthersAreDroppedAndCounted) {
  Peer peer, stranger;
  CanPort port;
  ASSERT_EQ(port.open(peer.path().c_str()), Status::ok);
  const int own = Peer::port_of(port.fd());
  stranger.send(own, numbered(2));
  peer.send(own, numbered(1));
  EXPECT_EQ(receive(port, 1).size(), 1u);
  EXPECT_EQ(port.counters().foreign, 1u);
  EXPECT_EQ(port.counters().cannelloni.datagrams, 1u);
}

// The peer is an address and a port: neither alone is enough.
TEST(CanPort, ThePortOfThePeerAtAnotherAddressIsAStranger) {
  Peer peer;
  CanPort port;
  ASSERT_EQ(port.open(peer.path().c_str()), Status::ok);
  const int stranger = ::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  sockaddr_in own = Peer::loopback(peer.port());
  own.sin_addr.s_addr = htonl(INADDR_LOOPBACK + 1);
  ASSERT_EQ(::bind(stranger, reinterpret_cast<const sockaddr*>(&own), sizeof own), 0);
  CannelloniWriter writer;
  writer.add(numbered(1).front());
  const auto datagram = writer.take();
  const auto to = Peer::loopback(static_cast<std::uint16_t>(Peer::port_of(port.fd())));
  EXPECT_EQ(::sendto(stranger, datagram.data(), datagram.size(), 0,
                     reinterpret_cast<const sockaddr*>(&to), sizeof to),
            static_cast<ssize_t>(datagram.size()));
  ::close(stranger);
  peer.send(ntohs(to.sin_port), numbered(1));
  EXPECT_EQ(receive(port, 1).size(), 1u);
  EXPECT_EQ(port.counters().foreign, 1u);
  EXPECT_EQ(port.counters().cannelloni.datagrams, 1u);
}

TEST(CanPort, AFloodOfForeignDatagramsDoesNotOccupyTheThread) {
  Peer peer, stranger;
  CanPort port;
  ASSERT_EQ(port.open(peer.path().c_str()), Status::ok);
  for (int n = 0; n < 50; ++n) stranger.send(Peer::port_of(port.fd()), numbered(1));
  ASSERT_TRUE(readable(port.fd()));
  std::array<CanFrame, 16> some;
  const auto got = port.receive(some);
  EXPECT_EQ(got.frames, 0u);
  EXPECT_TRUE(got.more);
  EXPECT_LT(port.counters().foreign, 50u);
}

TEST(CanPort, BrokenDatagramsAreDroppedAndCounted) {
  Peer peer;
  CanPort port;
  ASSERT_EQ(port.open(peer.path().c_str()), Status::ok);
  const int own = Peer::port_of(port.fd());
  peer.send(own, Bytes{});
  peer.send(own, Bytes{1, 0, 0, 0, 1});
  peer.send(own, Bytes(60'000, 2));
  peer.send(own, numbered(1));
  EXPECT_EQ(without_time(receive(port, 1)), numbered(1));
  EXPECT_EQ(port.counters().cannelloni.bad_header, 3u);
}

TEST(CanPort, WhatNoFilterPassesIsNotHandedUp) {
  Peer peer;
  CanPort port;
  const std::array<CanFilter, 2> filters = {{{0x180, 0x780}, {0x701, 0x7FF}}};
  ASSERT_EQ(port.open(peer.path().c_str(), filters), Status::ok);
  CanFrame extended = frame(0x181, {1}), remote = frame(0x181, {});
  extended.extended = true;
  remote.remote = true;
  peer.send(Peer::port_of(port.fd()),
            {frame(0x201, {}), extended, remote, frame(0x702, {5}), frame(0x701, {5})});
  EXPECT_EQ(without_time(receive(port, 1)), std::vector<CanFrame>{frame(0x701, {5})});
  EXPECT_EQ(port.counters().filtered, 4u);
}

TEST(CanPort, ErrorFramesOfTheOtherEndAreCountedOnly) {
  Peer peer;
  CanPort port;
  ASSERT_EQ(port.open(peer.path().c_str()), Status::ok);
  CanFrame error = frame(0x40, {0, 0, 0, 0, 0, 0, 0, 0});
  error.error = true;
  peer.send(Peer::port_of(port.fd()), {error, frame(0x701, {5})});
  EXPECT_EQ(receive(port, 1).size(), 1u);
  EXPECT_EQ(port.counters().error_frames, 1u);
  EXPECT_EQ(port.state(), CanState::active);
}

TEST(CanPort, LocalChoosesOurOwnPort) {
  Peer peer;
  int free = 0;
  {
    const Peer other;
    free = other.port();
  }
  CanPort port, second;
  const std::string path = peer.path() + "?local=" + std::to_string(free);
  ASSERT_EQ(port.open(path.c_str()), Status::ok);
  EXPECT_EQ(Peer::port_of(port.fd()), free);
  EXPECT_EQ(second.open(path.c_str()), Status::in_use);
  EXPECT_FALSE(second.is_open());
}

TEST(CanPort, NobodyAtTheOtherEndIsNoError) {
  std::string path;
  {
    const Peer gone;
    path = gone.path();
  }
  CanPort port;
  ASSERT_EQ(port.open(path.c_str()), Status::ok);
  std::array<CanFrame, 4> some;
  for (int n = 0; n < 3; ++n) {
    port.send(frame(0x080, {}), now_ns());
    EXPECT_TRUE(port.flush(now_ns()));
    EXPECT_FALSE(port.receive(some).lost);
  }
  EXPECT_EQ(port.counters().send_errors, 0u);
}

TEST(CanPort, AnAddressThatIsNoneIsRefused) {
  CanPort port;
  for (const char* path :
       {"udp://", "udp://127.0.0.1", "udp://127.0.0.1:", "udp://127.0.0.1:0",
        "udp://127.0.0.1:65536", "udp://127.0.0.1:12x", "udp://:20000", "udp://localhost:20000",
        "udp://127.0.0.1:20000?local=", "udp://127.0.0.1:20000?local=0",
        "udp://127.0.0.1:20000?remote=1", "udp://127.0.0.1.1.1.1.1.1.1:20000", "",
        "a_name_that_no_interface_can_have"}) {
    EXPECT_EQ(port.open(path), Status::bad_address) << path;
    EXPECT_FALSE(port.is_open());
  }
}

TEST(CanPort, AddressesBeyondThisMachineAreRefused) {
  CanPort port;
  for (const char* path :
       {"udp://192.168.1.5:20000", "udp://0.0.0.0:20000", "udp://128.0.0.1:20000"}) {
    EXPECT_EQ(port.open(path), Status::not_local) << path;
  }
}

TEST(CanPort, AnInterfaceThatIsNotThereSaysWhy) {
  CanPort port;
  const Status status = port.open("nocan7");
  EXPECT_TRUE(status == Status::absent || status == Status::no_can) << text(status);
  EXPECT_FALSE(port.is_open());
  const Status loopback = port.open("lo");
  EXPECT_TRUE(loopback == Status::not_can || loopback == Status::no_can) << text(loopback);
}

TEST(CanPort, EachStatusSaysWhatToDo) {
  for (int s = 1; s <= static_cast<int>(Status::failed); ++s) {
    EXPECT_GT(std::strlen(text(static_cast<Status>(s))), 15u);
  }
}

TEST(CanPort, ClosedItDoesNothing) {
  CanPort port;
  std::array<CanFrame, 4> some;
  port.send(frame(0x201, {}), now_ns());
  EXPECT_TRUE(port.flush(now_ns()));
  EXPECT_EQ(port.receive(some).frames, 0u);
  EXPECT_EQ(port.fd(), -1);
}

TEST(CanPort, OpenedAgainItForgetsWhatWaited) {
  Peer peer;
  CanPort port;
  ASSERT_EQ(port.open(peer.path().c_str()), Status::ok);
  port.send(frame(0x201, {}), now_ns());
  ASSERT_EQ(port.open(peer.path().c_str()), Status::ok);
  port.send(frame(0x202, {}), now_ns());
  EXPECT_TRUE(port.flush(now_ns()));
  EXPECT_EQ(peer.receive(1), std::vector<CanFrame>{frame(0x202, {})});
}

TEST(CanPort, AllocatesNothingOnceOpen) {
  Peer peer;
  CanPort port;
  ASSERT_EQ(port.open(peer.path().c_str()), Status::ok);
  const int own = Peer::port_of(port.fd());
  const CanFrame out = frame(0x201, {1});
  std::array<CanFrame, 16> some;
  for (int n = 0; n < 20; ++n) {
    peer.send(own, numbered(5));
    ASSERT_TRUE(readable(port.fd()));
    const std::uint64_t before = testing_support::allocations();
    EXPECT_EQ(port.receive(some).frames, 5u);
    port.send(out, 0);
    port.flush(0);
    EXPECT_EQ(testing_support::allocations(), before);
  }
}

}  // namespace
}  // namespace lss
