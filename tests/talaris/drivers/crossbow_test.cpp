// The Crossbow of docs/icd-talaris.md section 3.

#include "drivers/talaris/crossbow.h"

#include <gtest/gtest.h>

#include <numbers>

#include "tests/support/allocations.h"
#include "tests/talaris/drivers/lines.h"

namespace lss::talaris {
namespace {

constexpr TimeNs kPeriod = 10 * kMillisecond;
constexpr TimeNs kByte = 10 * kSecond / 38'400;
constexpr TimeNs kOnWire = 18 * kByte;

// Drives the line in virtual time; `answers` gives the reply to each message.
class CrossbowLine : public ::testing::Test {
 protected:
  void run_until(TimeNs end) {
    while (true) {
      say();
      TimeNs next = line.next_wake();
      ASSERT_GT(next, now) << "asked to be woken in the past";
      if (has_answer_) next = std::min(next, answer_at_);
      if (next > end) break;
      now = next;
      if (has_answer_ && now >= answer_at_) {
        has_answer_ = false;
        line.receive(line_bytes(answer_), now);
      }
    }
    now = end;
  }
  void open() {
    line.restart(now);
    run_until(now + 5 * kMillisecond);
    ASSERT_EQ(said, "RPcG");
    said.clear();
  }
  void answer(const Bytes& bytes, TimeNs after) {
    answer_ = bytes;
    answer_at_ = now + after;
    has_answer_ = true;
  }
  const LineCounters& counters() const { return line.status().counters; }

  Crossbow line{CrossbowParameters{}};
  TimeNs now = kSecond;
  std::string said;
  std::vector<TimeNs> polls;
  Bytes packet = kCrossbowGolden;
  bool mute = false;
  int mute_polls = 0;  // the next ones are not answered
  TimeNs reply_ns = kMillisecond;

 private:
  void say() {
    for (const std::uint8_t letter : written(line, now)) {
      said.push_back(static_cast<char>(letter));
      if (letter == 'G') polls.push_back(now);
      if (mute) continue;
      if (letter == 'R') answer({'H'}, kMillisecond);
      if (letter == 'c') answer({'C'}, kMillisecond);
      if (letter != 'G') continue;
      if (mute_polls > 0) {
        --mute_polls;
      } else {
        answer(packet, reply_ns + kOnWire);
      }
    }
  }

  Bytes answer_;
  TimeNs answer_at_ = 0;
  bool has_answer_ = false;
};

TEST_F(CrossbowLine, TheGoldenPacketIsReadInSiUnits) {
  open();
  run_until(now + 5 * kMillisecond);
  const auto got = only<ImuPacket>(take_all(line));
  ASSERT_EQ(got.size(), 1u);
  const ImuPacket& p = got[0].second;
  EXPECT_NEAR(p.rate_rad_s[0] * 180 / std::numbers::pi, 0.9979, 5e-5);
  EXPECT_NEAR(p.rate_rad_s[1] * 180 / std::numbers::pi, -437 * 150.0 / 32768, 1e-12);
  EXPECT_EQ(p.rate_rad_s[2], 0);
  EXPECT_NEAR(p.force_m_s2[0] / 9.80665, 1.0, 1e-4);
  EXPECT_NEAR(p.force_m_s2[1] / 9.80665, -22 * 3.0 / 32768, 1e-12);
  EXPECT_NEAR(p.temperature_degC, 25.69, 5e-3);
  EXPECT_EQ(got[0].first, polls[0] + kMillisecond);  // the begin of its first byte
}

TEST_F(CrossbowLine, ItIsEightN1) {
  EXPECT_EQ(line.format(), (SerialFormat{38'400, SerialFormat::Parity::none, 1, false}));
}

TEST_F(CrossbowLine, ItIsAskedUntilItAnswers) {
  mute = true;
  line.restart(now);
  run_until(now + 450 * kMillisecond);
  EXPECT_EQ(said, "RRRRR");
  mute = false;
  run_until(now + 100 * kMillisecond);
  EXPECT_EQ(said.substr(0, 9), "RRRRRRPcG");
}

TEST_F(CrossbowLine, AHundredPollsASecondOnAGrid) {
  open();
  run_until(now + kSecond);
  ASSERT_GE(polls.size(), 100u);
  for (std::size_t i = 1; i < polls.size(); ++i) EXPECT_EQ(polls[i] - polls[i - 1], kPeriod);
  EXPECT_EQ(counters().lost, 0u);
  EXPECT_EQ(counters().packets + 1, polls.size());
}

TEST_F(CrossbowLine, AFrameIsTwentyPolls) {
  open();
  std::vector<FrameTick> ticks;
  FrameTick tick;
  for (int n = 0; n < 100; ++n) {
    if (n == 35) mute_polls = 10;  // the begin of a frame is among them
    run_until(now + kPeriod);
    if (line.take_tick(tick)) ticks.push_back(tick);
  }
  ASSERT_EQ(ticks.size(), 5u);
  EXPECT_EQ(counters().lost, 10u);
  for (std::size_t k = 0; k < ticks.size(); ++k) {
    EXPECT_EQ(ticks[k].index, k + 1);
    EXPECT_EQ(ticks[k].time_ns, polls[20 * k + 19] + kMillisecond) << k;
  }
}

TEST_F(CrossbowLine, AnAnswerThatIsTooLateIsLostAndNotTheNextOnes) {
  open();
  run_until(now + 10 * kPeriod);
  const std::uint64_t good = counters().packets;
  reply_ns = 4 * kMillisecond;  // whole 8.7 ms after the poll
  run_until(now + kPeriod);
  reply_ns = kMillisecond;
  run_until(now + 10 * kPeriod);
  EXPECT_EQ(counters().lost, 1u);
  EXPECT_EQ(counters().packets, good + 10);
}

TEST_F(CrossbowLine, AChangedByteIsNoPacket) {
  open();
  run_until(now + 10 * kPeriod);
  packet[4] ^= 0x04;
  const std::uint64_t good = counters().packets;
  run_until(now + kPeriod);
  packet = kCrossbowGolden;
  run_until(now + 10 * kPeriod);
  EXPECT_EQ(counters().bad_check, 1u);
  EXPECT_EQ(counters().lost, 1u);
  EXPECT_EQ(counters().packets, good + 10);
}

TEST_F(CrossbowLine, APacketAfterGarbageIsFound) {
  open();
  packet.insert(packet.begin(), {0x11, 0xFF, 0x22});
  run_until(now + 3 * kPeriod);
  EXPECT_EQ(counters().packets, 3u);
  EXPECT_EQ(only<ImuPacket>(take_all(line)).size(), 3u);
}

TEST_F(CrossbowLine, BytesThatNobodyAskedForAreNotUsed) {
  open();
  run_until(now + 6 * kMillisecond);  // answered
  const std::uint64_t good = counters().packets;
  line.receive(line_bytes(kCrossbowGolden), now);
  EXPECT_EQ(counters().packets, good);
  EXPECT_EQ(counters().skipped, 18u);
}

TEST_F(CrossbowLine, SilentForASecondItIsStartedAgain) {
  open();
  run_until(now + 10 * kPeriod);
  mute = true;
  said.clear();
  run_until(now + 110 * kPeriod);
  EXPECT_EQ(counters().restarts, 1u);
  EXPECT_NE(said.find('R'), said.npos);
  mute = false;
  said.clear();
  run_until(now + 20 * kPeriod);
  EXPECT_EQ(said.substr(0, 4), "RPcG");
}

TEST_F(CrossbowLine, AThreadThatStoodCountsThePollsThatItMissed) {
  open();
  run_until(now + 10 * kPeriod);
  take_all(line);
  const std::uint64_t before = polls.size();
  now += 5 * kPeriod;
  run_until(now + kPeriod);
  const auto got = only<ImuPacket>(take_all(line));
  ASSERT_FALSE(got.empty());
  EXPECT_GE(got.back().second.count, before + 5);
}

TEST_F(CrossbowLine, NothingAllocates) {
  open();
  const auto golden = line_bytes(kCrossbowGolden);
  std::array<TalarisSample, SensorLine::kMaxSamples> samples;
  const std::uint64_t before = testing_support::allocations();
  for (int n = 0; n < 200; ++n) {
    now += kPeriod;
    while (!line.transmit(now).empty()) {
    }
    line.receive(golden, now + 6 * kMillisecond);
    (void)line.take(samples);
  }
  EXPECT_EQ(testing_support::allocations(), before);
}

}  // namespace
}  // namespace lss::talaris
