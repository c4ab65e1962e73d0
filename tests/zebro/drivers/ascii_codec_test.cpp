#include "drivers/zebro/ascii_codec.h"

#include <gtest/gtest.h>
#include <rapidcheck.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <string>
#include <string_view>
#include <vector>

namespace lss::zebro {
namespace {

using Bytes = std::vector<std::uint8_t>;

Bytes bytes_of(std::string_view text) { return {text.begin(), text.end()}; }

Bytes encoded(const Frame& frame, Check check = Check::lrc, Stop stop = Stop::lf) {
  std::array<std::uint8_t, kMaxFrameCharacters> buffer{};
  const auto characters = encode(frame, check, stop, buffer);
  return {characters.begin(), characters.end()};
}

std::string text_of(const Frame& frame, Check check = Check::lrc, Stop stop = Stop::lf) {
  const Bytes b = encoded(frame, check, stop);
  return {b.begin(), b.end()};
}

std::vector<Frame> all_taken(Receiver& receiver) {
  std::vector<Frame> frames;
  while (const auto received = receiver.take()) frames.push_back(received->frame);
  return frames;
}

std::vector<Frame> heard(const Bytes& bytes, Check check = Check::lrc, Stop stop = Stop::lf) {
  Receiver receiver(check, stop);
  receiver.receive(bytes, 0);
  return all_taken(receiver);
}

std::uint64_t drops(const Receiver& receiver) {
  const ReceiverCounters& c = receiver.counters();
  return c.bad_start + c.bad_length + c.bad_character + c.bad_check + c.overflows;
}

rc::Gen<Frame> any_frame() {
  return rc::gen::map(rc::gen::container<std::vector<std::uint8_t>>(
                          2 + kFrameData, rc::gen::arbitrary<std::uint8_t>()),
                      [](const Bytes& b) {
                        Frame frame{b[0], b[1], {}};
                        std::copy(b.begin() + 2, b.end(), frame.data.begin());
                        return frame;
                      });
}

rc::Gen<Check> any_check() { return rc::gen::element(Check::lrc, Check::crc8); }
rc::Gen<Stop> any_stop() { return rc::gen::element(Stop::lf, Stop::crlf); }

// Noise on this bus: its own characters, and others.
rc::Gen<Bytes> noise() {
  return rc::gen::container<Bytes>(rc::gen::oneOf(
      rc::gen::element<std::uint8_t>(':', '\n', '\r', '0', '1', '9', 'A', 'F', 'a', 'G', 0),
      rc::gen::arbitrary<std::uint8_t>()));
}

const Frame kStartLeg1{1, 0x01, {}};
const Frame kLeg3Forward{3, 0x03, {0x23, 0x28, 0x03, 0xE8}};
const Frame kStopAll{0, 0x06, {}};

TEST(AsciiCodec, TheGoldenFramesOfTheInterfaceDocumentComeOut) {
  EXPECT_EQ(text_of(kStartLeg1), ":01010000000000000000FE\n");
  EXPECT_EQ(text_of(kLeg3Forward), ":0303232803E800000000C4\n");
  EXPECT_EQ(text_of(kStopAll), ":00060000000000000000FA\n");
  EXPECT_EQ(text_of(kStartLeg1, Check::crc8), ":01010000000000000000C6\n");
  EXPECT_EQ(text_of(kLeg3Forward, Check::crc8), ":0303232803E80000000016\n");
  EXPECT_EQ(text_of(kStopAll, Check::crc8), ":0006000000000000000012\n");
  EXPECT_EQ(text_of(kStartLeg1, Check::lrc, Stop::crlf), ":01010000000000000000FE\r\n");
}

TEST(AsciiCodec, LrcHasTheValuesOfPublishedModbusFrames) {
  EXPECT_EQ(check_value(Check::lrc, Bytes{0x01, 0x03, 0x02, 0x01, 0x00, 0x01}), 0xF8);
  EXPECT_EQ(check_value(Check::lrc, Bytes{0x01, 0x03, 0x04, 0x01, 0x00, 0x01}), 0xF6);
  EXPECT_EQ(check_value(Check::lrc, Bytes{0x0C, 0xD6, 0x00}), 0x1E);
}

TEST(AsciiCodec, Crc8HasTheCatalogueValueOfPolynomial2F) {
  EXPECT_EQ(check_value(Check::crc8, bytes_of("123456789")), 0xDF);
}

TEST(AsciiCodec, AFrameIsStampedWithTheArrivalOfItsFirstCharacter) {
  Receiver receiver(Check::lrc, Stop::lf);
  const Bytes frame = encoded(kStartLeg1);
  receiver.receive(std::span(frame).first(1), 100);
  receiver.receive(std::span(frame).subspan(1, 20), 200);
  EXPECT_FALSE(receiver.take());
  receiver.receive(std::span(frame).subspan(21), 300);
  const auto received = receiver.take();
  ASSERT_TRUE(received);
  EXPECT_EQ(received->time_ns, 100);
  EXPECT_EQ(received->frame, kStartLeg1);
}

// [Env-1]
TEST(AsciiCodec, EachWrongFrameIsDroppedAndCountedByItsCause) {
  struct Case {
    const char* characters;
    std::uint64_t ReceiverCounters::*cause;
  };
  const Case cases[] = {
      {"x01010000000000000000FE\n", &ReceiverCounters::bad_start},
      {"\n", &ReceiverCounters::bad_start},
      {":0101000000000000000FE\n", &ReceiverCounters::bad_length},
      {":010100000000000000000FE\n", &ReceiverCounters::bad_length},
      {":01010000000000000000FE\r\n", &ReceiverCounters::bad_length},
      {":\n", &ReceiverCounters::bad_length},
      {":01010000000000000000fe\n", &ReceiverCounters::bad_character},
      {":0101000000 000000000FE\n", &ReceiverCounters::bad_character},
      {":01010000000000000000FF\n", &ReceiverCounters::bad_check},
  };
  for (const Case& c : cases) {
    Receiver receiver(Check::lrc, Stop::lf);
    receiver.receive(bytes_of(c.characters), 0);
    EXPECT_TRUE(all_taken(receiver).empty()) << c.characters;
    EXPECT_EQ(receiver.counters().*c.cause, 1u) << c.characters;
    EXPECT_EQ(drops(receiver), 1u) << c.characters;
  }
}

TEST(AsciiCodec, AFrameThatLostItsStopDoesNotTakeTheNextOneWithIt) {
  EXPECT_EQ(heard(bytes_of(":01010000000000000000FE:00060000000000000000FA\n")),
            std::vector<Frame>{kStopAll});
  EXPECT_EQ(heard(bytes_of(":0101000000:00060000000000000000FA\n")), std::vector<Frame>{kStopAll});
}

TEST(AsciiCodec, WithCrlfALoneLineFeedIsNoStop) {
  EXPECT_TRUE(heard(bytes_of(":01010000000000000000FE\n"), Check::lrc, Stop::crlf).empty());
  EXPECT_EQ(heard(bytes_of(":01010000000000000000FE\r\n"), Check::lrc, Stop::crlf),
            std::vector<Frame>{kStartLeg1});
  EXPECT_TRUE(heard(bytes_of(":01010000000000000000FE\r\r\n"), Check::lrc, Stop::crlf).empty());
}

TEST(AsciiCodec, OverflowDropsTheOldestFrame) {
  Receiver receiver(Check::lrc, Stop::lf);
  for (std::uint8_t i = 0; i < Receiver::kCapacity + 2; ++i) {
    receiver.receive(encoded({i, 0x40, {}}), 0);
  }
  const auto frames = all_taken(receiver);
  ASSERT_EQ(frames.size(), Receiver::kCapacity);
  EXPECT_EQ(frames.front().address, 2);
  EXPECT_EQ(frames.back().address, Receiver::kCapacity + 1);
  EXPECT_EQ(receiver.counters().overflows, 2u);
}

TEST(AsciiCodec, LrcDoesNotSeeExchangedBytesAndCrc8Does) {
  Bytes frame = encoded(kLeg3Forward);
  std::swap_ranges(frame.begin() + 5, frame.begin() + 7, frame.begin() + 7);
  EXPECT_EQ(heard(frame).size(), 1u);
  frame = encoded(kLeg3Forward, Check::crc8);
  std::swap_ranges(frame.begin() + 5, frame.begin() + 7, frame.begin() + 7);
  EXPECT_TRUE(heard(frame, Check::crc8).empty());
}

RC_GTEST_PROP(AsciiCodec, AnyFramesComeBackInAnyCutOfTheBytes, ()) {
  const Check check = *any_check();
  const Stop stop = *any_stop();
  const auto frames = *rc::gen::container<std::vector<Frame>>(any_frame());
  Receiver receiver(check, stop);
  Bytes stream;
  for (const Frame& frame : frames) {
    const Bytes b = encoded(frame, check, stop);
    stream.insert(stream.end(), b.begin(), b.end());
  }
  std::vector<Frame> back;
  std::span<const std::uint8_t> rest(stream);
  while (!rest.empty()) {
    const auto n = std::min(*rc::gen::inRange<std::size_t>(1, 60), rest.size());
    receiver.receive(rest.first(n), 0);
    rest = rest.subspan(n);
    for (const Frame& frame : all_taken(receiver)) back.push_back(frame);
  }
  RC_ASSERT(back == frames);
  RC_ASSERT(drops(receiver) == 0u);
}

// A frame that is altered at any place is none.
template <class Alter>
void no_frame_after(Alter alter) {
  const Check check = *any_check();
  const Stop stop = *any_stop();
  const Bytes good = encoded(*any_frame(), check, stop);
  for (std::size_t at = 0; at < good.size(); ++at) {
    Bytes bad = good;
    alter(bad, at);
    RC_ASSERT(heard(bad, check, stop).empty());
  }
}

// [Env-1]
RC_GTEST_PROP(AsciiCodec, AnySingleWrongCharacterNeverGivesAFrame, ()) {
  no_frame_after([](Bytes& bad, std::size_t at) { bad[at] = *rc::gen::distinctFrom(bad[at]); });
}

RC_GTEST_PROP(AsciiCodec, EveryOtherHexadecimalCharacterIsFoundAtEveryPlace, (bool crc)) {
  const Check check = crc ? Check::crc8 : Check::lrc;
  const Bytes good = encoded(*any_frame(), check);
  for (std::size_t at = 1; at + 1 < good.size(); ++at) {
    for (const char c : std::string_view("0123456789ABCDEF")) {
      if (good[at] == static_cast<std::uint8_t>(c)) continue;
      Bytes bad = good;
      bad[at] = static_cast<std::uint8_t>(c);
      RC_ASSERT(heard(bad, check).empty());
    }
  }
}

RC_GTEST_PROP(AsciiCodec, ALostCharacterNeverGivesAFrame, ()) {
  no_frame_after(
      [](Bytes& bad, std::size_t at) { bad.erase(bad.begin() + static_cast<std::ptrdiff_t>(at)); });
}

RC_GTEST_PROP(AsciiCodec, AnInsertedCharacterNeverGivesAWrongFrame, (std::uint8_t c)) {
  const Check check = *any_check();
  const Frame frame = *any_frame();
  const Bytes good = encoded(frame, check);
  for (std::size_t at = 0; at <= good.size(); ++at) {
    Bytes bad = good;
    bad.insert(bad.begin() + static_cast<std::ptrdiff_t>(at), c);
    for (const Frame& got : heard(bad, check)) RC_ASSERT(got == frame);
  }
}

// [Env-1]
RC_GTEST_PROP(AsciiCodec, Crc8FindsEveryErrorWithinEightNeighbouringBitsAndAnyThreeBits, ()) {
  Bytes bytes(kFrameBytes);
  const Frame frame = *any_frame();
  bytes[0] = frame.address;
  bytes[1] = frame.code;
  std::copy(frame.data.begin(), frame.data.end(), bytes.begin() + 2);
  const auto body = std::span(bytes).first(kFrameBytes - 1);
  bytes.back() = check_value(Check::crc8, body);
  const auto flip = [&bytes](std::size_t bit) {
    bytes[bit / 8] = static_cast<std::uint8_t>(bytes[bit / 8] ^ (0x80u >> (bit % 8)));
  };
  const auto good = [&] { return check_value(Check::crc8, body) == bytes.back(); };
  RC_ASSERT(good());

  constexpr std::size_t kBits = kFrameBytes * 8;
  const auto burst = *rc::gen::inRange(1u, 256u);
  const auto from = *rc::gen::inRange<std::size_t>(0, kBits - 7);
  for (std::size_t i = 0; i < 8; ++i) {
    if ((burst >> i & 1u) != 0) flip(from + i);
  }
  RC_ASSERT(!good());
  for (std::size_t i = 0; i < 8; ++i) {
    if ((burst >> i & 1u) != 0) flip(from + i);
  }
  const auto three =
      *rc::gen::unique<std::vector<std::size_t>>(3, rc::gen::inRange<std::size_t>(0, kBits));
  for (const std::size_t bit : three) {
    flip(bit);
    RC_ASSERT(!good());
  }
}

RC_GTEST_PROP(AsciiCodec, AGoodFrameIsReceivedAfterAnyNoise, ()) {
  const Check check = *any_check();
  const Stop stop = *any_stop();
  const Frame frame = *any_frame();
  Receiver receiver(check, stop);
  receiver.receive(*noise(), 0);
  all_taken(receiver);
  receiver.receive(encoded(frame, check, stop), 0);
  RC_ASSERT(all_taken(receiver) == std::vector<Frame>{frame});
}

RC_GTEST_PROP(AsciiCodec, NoiseBetweenFramesCostsNone, ()) {
  const auto frames = *rc::gen::container<std::vector<Frame>>(any_frame());
  Receiver receiver(Check::crc8, Stop::lf);
  std::vector<Frame> back;
  for (const Frame& frame : frames) {
    receiver.receive(*noise(), 0);
    all_taken(receiver);
    receiver.receive(encoded(frame, Check::crc8), 0);
    for (const Frame& got : all_taken(receiver)) back.push_back(got);
  }
  RC_ASSERT(back == frames);
}

}  // namespace
}  // namespace lss::zebro
