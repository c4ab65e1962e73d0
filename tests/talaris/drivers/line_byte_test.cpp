// Marks of parity errors, by hand and through a pseudo-terminal.

#include "drivers/serial/line_byte.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <rapidcheck.h>
#include <rapidcheck/gtest.h>
#include <stdlib.h>
#include <termios.h>
#include <unistd.h>

#include <string>

#include "drivers/serial/serial_port.h"
#include "tests/talaris/drivers/lines.h"

namespace lss {
namespace {

using talaris::Bytes;

std::vector<LineByte> decoded(ParityMarks& marks, const Bytes& raw) {
  std::vector<LineByte> out(raw.size());
  out.resize(marks.decode(raw, out));
  return out;
}

// As a terminal marks received bytes.
Bytes marked(const std::vector<LineByte>& came) {
  Bytes raw;
  for (const LineByte& byte : came) {
    if (byte.bad) {
      raw.insert(raw.end(), {0xFF, 0x00, byte.value});
    } else {
      raw.push_back(byte.value);
      if (byte.value == 0xFF) raw.push_back(0xFF);
    }
  }
  return raw;
}

TEST(ParityMarks, GoodBytesBadBytesAndBreaks) {
  ParityMarks marks;
  const auto got = decoded(
      marks, {0x2A, 0xFF, 0xFF, 0x00, 0xFF, 0x00, 0x41, 0xFF, 0x00, 0x00, 0xFF, 0x00, 0xFF, 0x42});
  const std::vector<LineByte> expected = {{0x2A, false}, {0xFF, false}, {0x00, false}, {0x41, true},
                                          {0x00, true},  {0xFF, true},  {0x42, false}};
  EXPECT_EQ(got, expected);
}

TEST(ParityMarks, WhatNoTerminalWritesIsBad) {
  ParityMarks marks;
  EXPECT_EQ(decoded(marks, {0xFF, 0x33}), (std::vector<LineByte>{{0x33, true}}));
}

TEST(ParityMarks, ClearForgetsHalfAMark) {
  ParityMarks marks;
  EXPECT_TRUE(decoded(marks, {0xFF, 0x00}).empty());
  marks.clear();
  EXPECT_EQ(decoded(marks, {0x41}), (std::vector<LineByte>{{0x41, false}}));
}

RC_GTEST_PROP(ParityMarks, AnyBytesInAnyCutComeBackAsTheyWere, ()) {
  const auto came = *rc::gen::container<std::vector<LineByte>>(rc::gen::map(
      rc::gen::pair(
          rc::gen::weightedOneOf<std::uint8_t>({{3, rc::gen::arbitrary<std::uint8_t>()},
                                                {1, rc::gen::element<std::uint8_t>(0x00, 0xFF)}}),
          rc::gen::arbitrary<bool>()),
      [](const auto& pair) {
        return LineByte{pair.first, pair.second};
      }));
  const Bytes raw = marked(came);
  ParityMarks marks;
  std::vector<LineByte> got;
  for (std::size_t at = 0; at < raw.size();) {
    const std::size_t size =
        std::min<std::size_t>(*rc::gen::inRange<std::size_t>(1, 7), raw.size() - at);
    const auto first = raw.begin() + static_cast<std::ptrdiff_t>(at);
    const auto piece = decoded(marks, Bytes(first, first + static_cast<std::ptrdiff_t>(size)));
    got.insert(got.end(), piece.begin(), piece.end());
    at += size;
  }
  RC_ASSERT(got == came);
}

// A pseudo-terminal makes no parity errors, but its terminal doubles FF once marking is on.
class PortWithParity : public ::testing::Test {
 protected:
  PortWithParity() : far_(::posix_openpt(O_RDWR | O_NOCTTY)) {
    EXPECT_EQ(::grantpt(far_), 0);
    EXPECT_EQ(::unlockpt(far_), 0);
    path_ = ::ptsname(far_);
  }
  ~PortWithParity() override { ::close(far_); }

  Bytes through(SerialPort& port, const Bytes& sent) {
    EXPECT_EQ(::write(far_, sent.data(), sent.size()), static_cast<ssize_t>(sent.size()));
    Bytes got;
    pollfd p{port.fd(), POLLIN, 0};
    while (got.size() < sent.size() && ::poll(&p, 1, 2000) == 1) {
      std::array<LineByte, 64> piece;
      const auto in = port.read(piece);
      EXPECT_FALSE(in.lost);
      for (std::size_t i = 0; i < in.bytes; ++i) {
        EXPECT_FALSE(piece[i].bad);
        got.push_back(piece[i].value);
      }
    }
    return got;
  }

  int far_;
  std::string path_;
};

TEST_F(PortWithParity, AllBytesComeThroughAsTheyAre) {
  SerialPort port;
  SerialFormat format;
  format.parity = SerialFormat::Parity::even;
  format.stop_bits = 2;
  ASSERT_EQ(port.open(path_.c_str(), format), SerialPort::Status::ok);
  termios line{};
  ASSERT_EQ(::tcgetattr(port.fd(), &line), 0);
  EXPECT_NE(line.c_iflag & PARMRK, 0u);
  EXPECT_NE(line.c_iflag & INPCK, 0u);
  EXPECT_EQ(line.c_iflag & (IGNPAR | ISTRIP), 0u);
  EXPECT_NE(line.c_cflag & CSTOPB, 0u);
  Bytes all;
  for (int round = 0; round < 3; ++round) {
    for (int byte = 0; byte < 256; ++byte) all.push_back(static_cast<std::uint8_t>(byte));
    all.insert(all.end(), 5, 0xFF);
  }
  EXPECT_EQ(through(port, all), all);
}

// The terminal keeps its settings while its far end is open.
TEST_F(PortWithParity, ItCanBeOpenedAgain) {
  SerialFormat format;
  format.parity = SerialFormat::Parity::even;
  format.stop_bits = 2;
  SerialPort port;
  for (int n = 0; n < 3; ++n) {
    ASSERT_EQ(port.open(path_.c_str(), format), SerialPort::Status::ok) << n;
    EXPECT_EQ(through(port, {0x2A, 0xFF, 0x00}), (Bytes{0x2A, 0xFF, 0x00})) << n;
    port.close();
  }
}

TEST_F(PortWithParity, HalfAMarkOfBeforeIsForgottenWhenItIsOpenedAgain) {
  SerialFormat format;
  format.parity = SerialFormat::Parity::even;
  SerialPort port;
  ASSERT_EQ(port.open(path_.c_str(), format), SerialPort::Status::ok);
  ASSERT_EQ(::write(far_, "\xFF", 1), 1);
  pollfd p{port.fd(), POLLIN, 0};
  ASSERT_EQ(::poll(&p, 1, 2000), 1);
  std::array<LineByte, 1> one;  // the terminal wrote two; one of them is read
  EXPECT_EQ(port.read(one).bytes, 0u);
  ASSERT_EQ(port.open(path_.c_str(), format), SerialPort::Status::ok);
  EXPECT_EQ(through(port, {0x41}), (Bytes{0x41}));
}

TEST_F(PortWithParity, WithoutParityNothingIsMarked) {
  SerialPort port;
  ASSERT_EQ(port.open(path_.c_str(), SerialFormat{}), SerialPort::Status::ok);
  termios line{};
  ASSERT_EQ(::tcgetattr(port.fd(), &line), 0);
  EXPECT_EQ(line.c_iflag & (PARMRK | INPCK), 0u);
  EXPECT_EQ(line.c_cflag & (CSTOPB | PARENB), 0u);
  const Bytes sent = {0x00, 0xFF, 0xFF, 0x00, 0xFF, 0x00, 0x2A};
  EXPECT_EQ(through(port, sent), sent);
}

TEST(SerialFormat, BitsOfACharacter) {
  EXPECT_EQ(SerialFormat{}.bits(), 10);
  EXPECT_EQ((SerialFormat{115'200, SerialFormat::Parity::even, 2, false}.bits()), 12);
}

}  // namespace
}  // namespace lss
