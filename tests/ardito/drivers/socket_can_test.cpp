// On a CAN interface of the kernel. LSS_TEST_CAN names a virtual one that the test may take down,
// remove and add again (as root); without it, or without CAN in the kernel, the tests skip:
//   ip link add dev vcan0 type vcan && ip link set vcan0 up && LSS_TEST_CAN=vcan0 test_can

#include "drivers/can/socket_can.h"

#include <gtest/gtest.h>
#include <linux/can.h>
#include <linux/can/error.h>
#include <linux/can/raw.h>
#include <net/if.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cstdlib>
#include <string>
#include <vector>

#include "drivers/can/can_port.h"
#include "tests/support/allocations.h"
#include "tests/support/can_frames.h"

namespace lss {
namespace {

using Status = CanPort::Status;
using testing_support::frame;

bool readable(int fd) {
  pollfd p{fd, POLLIN, 0};
  return ::poll(&p, 1, 2000) == 1;
}

TimeNs now_ns() { return read_clocks().monotonic_ns; }

class SocketCanTest : public ::testing::Test {
 protected:
  void SetUp() override {
    const char* name = std::getenv("LSS_TEST_CAN");
    if (name == nullptr) GTEST_SKIP() << "LSS_TEST_CAN names no interface";
    name_ = name;
    ASSERT_EQ(port_.open(name), Status::ok) << text(port_.open(name));
    open_other();
  }
  void TearDown() override {
    if (other_ >= 0) ::close(other_);
  }

  void link(const std::string& command) {
    ASSERT_EQ(std::system(("ip link " + command).c_str()), 0) << command;
  }
  void open_other() {
    if (other_ >= 0) ::close(other_);
    other_ = ::socket(PF_CAN, SOCK_RAW | SOCK_CLOEXEC, CAN_RAW);
    ASSERT_GE(other_, 0);
    sockaddr_can address{};
    address.can_family = AF_CAN;
    address.can_ifindex = static_cast<int>(::if_nametoindex(name_.c_str()));
    ASSERT_EQ(::bind(other_, reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
  }
  // As another node on the bus.
  void put(std::uint32_t id, std::uint8_t size, const std::vector<std::uint8_t>& data = {}) {
    can_frame raw{};
    raw.can_id = id;
    raw.can_dlc = size;
    std::copy(data.begin(), data.end(), raw.data);
    ASSERT_EQ(::write(other_, &raw, sizeof raw), static_cast<ssize_t>(sizeof raw));
  }
  can_frame get() {
    can_frame raw{};
    EXPECT_TRUE(readable(other_));
    EXPECT_EQ(::read(other_, &raw, sizeof raw), static_cast<ssize_t>(sizeof raw));
    return raw;
  }
  std::vector<CanFrame> receive(std::size_t count, std::size_t at_once = 16) {
    std::vector<CanFrame> frames, some(at_once);
    while (frames.size() < count && readable(port_.fd())) {
      const auto got = port_.receive(some);
      EXPECT_FALSE(got.lost);
      if (got.lost) break;
      frames.insert(frames.end(), some.begin(), some.begin() + static_cast<long>(got.frames));
    }
    return frames;
  }
  bool lost() {
    std::array<CanFrame, 4> some;
    return readable(port_.fd()) && port_.receive(some).lost;
  }

  std::string name_;
  CanPort port_;
  int other_ = -1;
};

TEST_F(SocketCanTest, FramesGoBothWays) {
  port_.send(frame(0x201, {1, 2, 3, 4, 5, 6}), now_ns());
  port_.send(frame(0x080, {}), now_ns());
  ASSERT_TRUE(port_.flush(now_ns()));
  const can_frame first = get();
  EXPECT_EQ(first.can_id, 0x201u);
  EXPECT_EQ(first.can_dlc, 6);
  EXPECT_EQ(first.data[5], 6);
  EXPECT_EQ(get().can_id, 0x080u);
  put(0x181, 3, {1, 2, 3});
  const auto frames = receive(1);
  ASSERT_EQ(frames.size(), 1u) << "and not our own";
  CanFrame expected = frame(0x181, {1, 2, 3}, frames[0].time_ns);
  EXPECT_EQ(frames[0], expected);
}

TEST_F(SocketCanTest, ExtendedAndRemoteFramesAreThatBothWays) {
  put(0x18FF0102u | CAN_EFF_FLAG, 1, {9});
  put(0x701u | CAN_RTR_FLAG, 1);
  const auto frames = receive(2);
  ASSERT_EQ(frames.size(), 2u);
  EXPECT_TRUE(frames[0].extended);
  EXPECT_EQ(frames[0].id, 0x18FF0102u);
  EXPECT_TRUE(frames[1].remote);
  EXPECT_EQ(frames[1].size, 1);
  for (const CanFrame& f : frames) port_.send(f, now_ns());
  ASSERT_TRUE(port_.flush(now_ns()));
  EXPECT_EQ(get().can_id, 0x18FF0102u | CAN_EFF_FLAG);
  EXPECT_EQ(get().can_id, 0x701u | CAN_RTR_FLAG);
}

// The kernel begins to stamp some time after it was asked: the first tries may be too early.
TEST_F(SocketCanTest, FramesAreStampedWithTheirArrival) {
  bool stamped = false;
  for (int n = 0; n < 100 && !stamped; ++n) {
    const TimeNs before = now_ns();
    put(0x181, 0);
    ASSERT_TRUE(readable(port_.fd()));
    const TimeNs arrived = now_ns();
    while (now_ns() < arrived + 20 * kMillisecond) {
    }
    const auto frames = receive(1);
    ASSERT_EQ(frames.size(), 1u);
    const TimeNs tolerance = kMillisecond;  // two clocks are read one after the other
    stamped = frames[0].time_ns >= before - tolerance && frames[0].time_ns <= arrived + tolerance;
  }
  EXPECT_TRUE(stamped);
}

TEST_F(SocketCanTest, ManyFramesComeInOrder) {
  for (std::uint32_t n = 0; n < 200; ++n) put(0x100 + n, 0);
  const auto frames = receive(200, 7);
  ASSERT_EQ(frames.size(), 200u);
  for (std::uint32_t n = 0; n < 200; ++n) EXPECT_EQ(frames[n].id, 0x100 + n);
  EXPECT_EQ(port_.counters().overflows, 0u);
}

TEST_F(SocketCanTest, WhatTheKernelDropsIsCounted) {
  for (std::uint32_t n = 0; n < 20'000; ++n) put(0x181, 8);
  std::vector<CanFrame> some(64);
  std::size_t heard = 0;
  pollfd p{port_.fd(), POLLIN, 0};
  while (::poll(&p, 1, 0) == 1) heard += port_.receive(some).frames;
  EXPECT_LT(heard, 20'000u);
  put(0x181, 8);  // carries the count
  receive(1);
  EXPECT_EQ(heard + port_.counters().overflows, 20'000u);
}

TEST_F(SocketCanTest, TheKernelFilters) {
  const std::array<CanFilter, 2> filters = {{{0x180, 0x780}, {0x701, 0x7FF}}};
  ASSERT_EQ(port_.open(name_.c_str(), filters), Status::ok);
  put(0x201, 0);
  put(0x181u | CAN_EFF_FLAG, 0);
  put(0x181u | CAN_RTR_FLAG, 0);
  put(0x702, 0);
  put(0x1FF, 0);
  put(0x701, 0);
  const auto frames = receive(2);
  ASSERT_EQ(frames.size(), 2u);
  EXPECT_EQ(frames[0].id, 0x1FFu);
  EXPECT_EQ(frames[1].id, 0x701u);
}

TEST_F(SocketCanTest, BusOffIsNoticedAndTheReturnFromIt) {
  port_.send(frame(0x201, {}), now_ns());
  put(CAN_ERR_FLAG | CAN_ERR_CRTL, 8, {0, CAN_ERR_CRTL_TX_PASSIVE, 0, 0, 0, 0, 0, 0});
  put(0x181, 0);
  EXPECT_EQ(receive(1).size(), 1u);
  EXPECT_EQ(port_.state(), CanState::passive);
  put(CAN_ERR_FLAG | CAN_ERR_BUSOFF, 8);
  put(0x182, 0);
  EXPECT_EQ(receive(1).size(), 1u) << "the error frame itself is not handed up";
  EXPECT_EQ(port_.state(), CanState::bus_off);
  EXPECT_EQ(port_.counters().bus_offs, 1u);
  EXPECT_EQ(port_.counters().dropped_stale, 1u) << "what waited was for the bus of before";
  put(CAN_ERR_FLAG | CAN_ERR_RESTARTED, 8);
  put(0x183, 0);
  EXPECT_EQ(receive(1).size(), 1u);
  EXPECT_EQ(port_.state(), CanState::active);
  EXPECT_EQ(port_.counters().restarts, 1u);
  EXPECT_EQ(port_.counters().error_frames, 3u);
  EXPECT_EQ(port_.counters().error_passive, 1u);
}

TEST_F(SocketCanTest, AnInterfaceThatGoesDownIsLostAndOpenedAgainWhenItIsUp) {
  link("set " + name_ + " down");
  EXPECT_TRUE(lost());
  EXPECT_EQ(port_.open(name_.c_str()), Status::down);
  link("set " + name_ + " up");
  EXPECT_EQ(port_.open(name_.c_str()), Status::ok);
  open_other();
  put(0x181, 0);
  EXPECT_EQ(receive(1).size(), 1u);
}

TEST_F(SocketCanTest, SendingOnAnInterfaceThatIsDownSaysThatItIsLost) {
  link("set " + name_ + " down");
  port_.send(frame(0x201, {}), now_ns());
  EXPECT_FALSE(port_.flush(now_ns()));
  link("set " + name_ + " up");
}

TEST_F(SocketCanTest, AnInterfaceThatIsUnpluggedIsLostAndFoundAgainByItsName) {
  link("del " + name_);
  EXPECT_TRUE(lost());
  EXPECT_EQ(port_.open(name_.c_str()), Status::absent);
  link("add dev " + name_ + " type vcan");
  EXPECT_EQ(port_.open(name_.c_str()), Status::down);
  link("set " + name_ + " up");
  EXPECT_EQ(port_.open(name_.c_str()), Status::ok);
  open_other();
  port_.send(frame(0x201, {}), now_ns());
  EXPECT_TRUE(port_.flush(now_ns()));
  EXPECT_EQ(get().can_id, 0x201u);
}

TEST_F(SocketCanTest, AnotherInterfaceIsNoCan) {
  EXPECT_EQ(port_.open("lo"), Status::not_can);
  EXPECT_EQ(port_.open("nocan7"), Status::absent);
}

TEST_F(SocketCanTest, AllocatesNothingOnceOpen) {
  std::array<CanFrame, 16> some;
  const CanFrame out = frame(0x201, {1});
  put(0x181, 0);
  ASSERT_TRUE(readable(port_.fd()));
  const std::uint64_t before = testing_support::allocations();
  EXPECT_EQ(port_.receive(some).frames, 1u);
  port_.send(out, 0);
  EXPECT_TRUE(port_.flush(0));
  EXPECT_EQ(testing_support::allocations(), before);
}

}  // namespace
}  // namespace lss
