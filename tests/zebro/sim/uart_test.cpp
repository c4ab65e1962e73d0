#include "tools/lss-sim/frame/uart.h"

#include <gtest/gtest.h>

#include <bit>
#include <limits>
#include <string>

namespace lss::sim {
namespace {

// Answers each line with the line in capitals.
class Echo final : public LineDevice {
 public:
  std::span<const std::uint8_t> receive(std::uint8_t character, TimeNs) override {
    line_.push_back(character >= 'a' ? static_cast<std::uint8_t>(character - 'a' + 'A')
                                     : character);
    if (character != '\n') return {};
    reply_ = std::exchange(line_, {});
    ++lines;
    return reply_;
  }
  int lines = 0;

 private:
  std::vector<std::uint8_t> line_, reply_;
};

class UartTest : public testing::Test {
 protected:
  static constexpr TimeNs kCharacter = 10 * kSecond / 100'000;  // 100 us

  void write(const std::string& text, TimeNs now) {
    uart_.from_master({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()}, now);
  }
  // Runs until the line is idle; returns the reply and its end time.
  std::string run(Uart& uart) {
    std::string heard;
    while (uart.next_wake() != std::numeric_limits<TimeNs>::max()) {
      now_ = uart.next_wake();
      uart.advance(now_);
      for (const std::uint8_t c : uart.take(now_)) heard.push_back(static_cast<char>(c));
    }
    return heard;
  }
  std::string run() { return run(uart_); }
  Fault fault(const char* text) { return parse_fault(text, line_fault_kinds()).value(); }
  void attach(const char* text) { uart_.faults.set(fault(text), true); }

  Echo echo_;
  Uart uart_{{.baud = 100'000}, echo_};
  TimeNs now_ = 0;
};

TEST_F(UartTest, AReplyEndsOneTurnAroundAndItsLengthAfterTheRequest) {
  write(":abc\n", 0);
  EXPECT_EQ(run(), ":ABC\n");
  EXPECT_EQ(now_, (5 + 1 + 5) * kCharacter);
}

TEST_F(UartTest, PipelinedRequestsAreAnsweredWithoutAGap) {
  for (int i = 0; i < 7; ++i) write(":abc\n", 0);
  EXPECT_EQ(run().size(), 35u);
  EXPECT_EQ(now_, (8 * 5 + 1) * kCharacter);
}

TEST_F(UartTest, NothingArrivesBeforeItsLastBit) {
  write(":abc\n", 0);
  uart_.advance(5 * kCharacter - 1);
  EXPECT_EQ(echo_.lines, 0);
  uart_.advance(5 * kCharacter);
  EXPECT_EQ(echo_.lines, 1);
}

TEST_F(UartTest, WithoutPaceEverythingIsAtOnce) {
  Uart uart({.paced = false}, echo_);
  const std::string text = ":abc\n";
  uart.from_master({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()}, 5);
  uart.advance(5);
  EXPECT_EQ(uart.take(5).size(), text.size());
}

TEST_F(UartTest, LateRepliesAreLateByThatMuch) {
  attach("late:3");
  write(":abc\n", 0);
  run();
  EXPECT_EQ(now_, 11 * kCharacter + 3 * kMillisecond);
}

TEST_F(UartTest, DuplicatedRepliesComeTwice) {
  attach("duplicate:1");
  write(":abc\n", 0);
  EXPECT_EQ(run(), ":ABC\n:ABC\n");
}

TEST_F(UartTest, LateRepliesDoNotMakeThoseLateThatFollow) {
  attach("late:500");
  for (int i = 0; i < 10; ++i) write(":abc\n", now_);
  uart_.advance(50 * kCharacter);
  uart_.faults.set(fault("late:500"), false);
  for (int i = 0; i < 10; ++i) write(":def\n", 50 * kCharacter);  // lost in those that are late
  EXPECT_EQ(run().size(), 50u);
  EXPECT_EQ(now_, 56 * kCharacter + 500 * kMillisecond);
  const TimeNs again_ns = now_;
  write(":ghi\n", again_ns);
  EXPECT_EQ(run(), ":GHI\n");
  EXPECT_EQ(now_, again_ns + 11 * kCharacter);
}

TEST_F(UartTest, MoreRepliesThanTheLineCarriesAreLostAndNotLaterAndLater) {
  attach("duplicate:1");
  constexpr int kRequests = 1000;
  for (int i = 0; i < kRequests; ++i) write(":abc\n", 0);
  const auto replies = run().size() / 5;
  EXPECT_LE(now_, (kRequests + 5) * 5 * kCharacter);
  EXPECT_NEAR(static_cast<double>(replies), kRequests, 5);
}

TEST_F(UartTest, ACutBusPassesNothingUntilTheFaultIsCleared) {
  attach("bus-cut");
  write(":abc\n", 0);
  EXPECT_EQ(run(), "");
  EXPECT_EQ(echo_.lines, 0);
  uart_.faults.set(fault("bus-cut"), false);
  write(":abc\n", kSecond);
  EXPECT_EQ(run(), ":ABC\n");
}

TEST_F(UartTest, DroppedFramesAreLostWholeInEitherDirection) {
  attach("drop:0.5");
  int replies = 0;
  for (int i = 0; i < 400; ++i) {
    write(":abc\n", now_);
    const std::string heard = run();
    ASSERT_TRUE(heard.empty() || heard == ":ABC\n");
    replies += heard.empty() ? 0 : 1;
  }
  EXPECT_NEAR(echo_.lines, 200, 50);
  EXPECT_NEAR(replies, 100, 40);
}

class Recorder final : public LineDevice {
 public:
  std::span<const std::uint8_t> receive(std::uint8_t character, TimeNs) override {
    heard.push_back(character);
    return {};
  }
  std::vector<std::uint8_t> heard;
};

TEST_F(UartTest, NoiseChangesOneBitOfAboutAsManyCharactersAsItSays) {
  Recorder recorder;
  Uart uart({.baud = 100'000}, recorder);
  uart.faults.set(fault("noise:0.1"), true);
  const std::vector<std::uint8_t> sent(10'000, 'A');
  uart.from_master(sent, 0);
  run(uart);
  ASSERT_EQ(recorder.heard.size(), sent.size());
  int changed = 0;
  for (const unsigned character : recorder.heard) {
    const int bits = std::popcount(character ^ 'A');
    ASSERT_LE(bits, 1);
    changed += bits;
  }
  EXPECT_NEAR(changed, 1000, 150);
}

}  // namespace
}  // namespace lss::sim
