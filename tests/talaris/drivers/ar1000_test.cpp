// The AR1000 of docs/icd-talaris.md section 4.

#include "drivers/talaris/ar1000.h"

#include <gtest/gtest.h>

#include "tests/support/allocations.h"
#include "tests/talaris/drivers/lines.h"

namespace lss::talaris {
namespace {

constexpr TimeNs kByte = 10 * kSecond / 9'600;

class Altimeter : public ::testing::Test {
 protected:
  Altimeter() {
    line.restart(now);
    hear("\r\n");  // earlier bytes are the end of another line
  }
  void hear(std::string_view text) { line.receive(line_bytes(text), now); }
  std::vector<std::pair<TimeNs, Range>> taken() { return only<Range>(take_all(line)); }
  // The only reading, which has this range; its time.
  TimeNs expect_only(double range_m) {
    const auto got = taken();
    EXPECT_EQ(got.size(), 1u);
    if (got.empty()) return 0;
    EXPECT_DOUBLE_EQ(got[0].second.range_m, range_m);
    EXPECT_EQ(got[0].second.error, 0);
    return got[0].first;
  }
  const LineCounters& counters() const { return line.status().counters; }

  Ar1000 line{Ar1000Parameters{}};
  TimeNs now = kSecond;
};

TEST_F(Altimeter, TheGoldenLine) {
  hear("000.934\r\n");
  EXPECT_EQ(expect_only(0.934), now - 9 * kByte);  // the begin of its first byte
}

TEST_F(Altimeter, ALineInPiecesIsStampedWithItsFirst) {
  hear("00");
  const TimeNs first = now - 2 * kByte;
  now += 3 * kMillisecond;
  hear("0.93");
  now += 4 * kMillisecond;
  hear("4\r\n");
  const auto got = taken();
  ASSERT_EQ(got.size(), 1u);
  EXPECT_EQ(got[0].first, first);
}

TEST_F(Altimeter, TheLatencyOfTheMeasurementIsTakenOff) {
  Ar1000 late{{.latency_ns = 20 * kMillisecond}};
  late.restart(now);
  late.receive(line_bytes("\r\n001.000\r\n"), now);
  EXPECT_EQ(only<Range>(take_all(late))[0].first, now - 9 * kByte - 20 * kMillisecond);
}

TEST_F(Altimeter, NumbersInAnyForm) {
  const std::pair<std::string_view, double> lines[] = {
      {"1.5\r\n", 1.5},         {"12.\r\n", 12},          {"7\r\n", 7},
      {" 002.250\r\n", 2.25},   {"29.9999\r\n", 29.9999}, {"003.125 004711\r\n", 3.125},
      {"000000003.5\r\n", 3.5},
  };
  for (const auto& [text, range] : lines) {
    hear(text);
    const auto got = taken();
    ASSERT_EQ(got.size(), 1u) << text;
    EXPECT_DOUBLE_EQ(got[0].second.range_m, range) << text;
    EXPECT_EQ(got[0].second.error, 0) << text;
  }
}

TEST_F(Altimeter, ErrorsAreReportedWithTheirNumber) {
  hear("E15\r\nE16\r\nE200\r\n");
  const auto got = taken();
  ASSERT_EQ(got.size(), 3u);
  EXPECT_EQ(got[0].second.error, 15);
  EXPECT_EQ(got[0].second.range_m, 0);
  EXPECT_EQ(got[1].second.error, 16);
  EXPECT_EQ(got[2].second.error, 200);
  EXPECT_EQ(counters().said_errors, 3u);
}

TEST_F(Altimeter, ARangeThatCannotBeIsOutOfRange) {
  hear("000.099\r\n030.001\r\n-01.000\r\n000.100\r\n030.000\r\n");
  const auto got = taken();
  ASSERT_EQ(got.size(), 5u);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(got[i].second.error, Range::kOutOfRange) << i;
    EXPECT_EQ(got[i].second.range_m, 0) << i;
  }
  EXPECT_EQ(got[3].second.error, 0);
  EXPECT_EQ(got[4].second.error, 0);
  EXPECT_EQ(counters().out_of_range, 3u);
}

TEST_F(Altimeter, ABadLineIsCountedAndNotReported) {
  const std::string_view lines[] = {"\r\n",      "E\r\n",     "E0\r\n",      "E15 \r\nE1x\r\n",
                                    "abc\r\n",   ".934\r\n",  "0.9.3\r\n",   "1,5\r\n",
                                    "1.5 x\r\n", "1.5e3\r\n", "--1.5\r\n",   "1.5\n",
                                    "0x12\r\n",  "nan\r\n",   "1.5 7 8\r\n", "1.57 \t\r\n"};
  std::uint64_t bad = 0;
  for (const std::string_view text : lines) {
    hear(text);
    const auto got = taken();
    if (text.starts_with("E15 ")) {
      EXPECT_EQ(got.size(), 1u);  // blanks at the end are none; the second is no error
    } else {
      EXPECT_TRUE(got.empty()) << text;
    }
    EXPECT_GT(counters().bad_check, bad) << text;
    bad = counters().bad_check;
  }
}

TEST_F(Altimeter, AnOverlongLineIsThrownAwayAndTheNextOneIsGood) {
  hear(std::string(1'000, '1'));
  hear("\r\n002.000\r\n");
  expect_only(2);
  EXPECT_EQ(counters().bad_check, 1u);
}

TEST_F(Altimeter, TheRestOfALineThatBeganBeforeIsNotANumber) {
  line.restart(now);
  hear("0.934\r\n001.000\r\n");
  expect_only(1);
}

TEST_F(Altimeter, AMarkedByteSpoilsItsLine) {
  auto marked = line_bytes("001.500\r\n");
  marked[4].bad = true;
  line.receive(marked, now);
  hear("001.600\r\n");
  expect_only(1.6);
  EXPECT_EQ(counters().parity, 1u);
}

// The thesis saw 1 to 3 readings a frame: DW at 10 Hz is one, DT may be faster.
TEST_F(Altimeter, TenAndFifteenReadingsASecond) {
  written(line, now);
  now += 100 * kMillisecond;
  written(line, now);
  for (const TimeNs period : {100 * kMillisecond, 66'667 * kMicrosecond}) {
    std::size_t count = 0;
    TimeNs last = 0;
    const TimeNs end = now + 2 * kSecond;
    for (; now < end; now += period) {
      EXPECT_TRUE(line.transmit(now).empty());
      hear("001.234\r\n");
      for (const auto& [time, range] : taken()) {
        EXPECT_GT(time, last);
        last = time;
        ++count;
      }
    }
    EXPECT_GE(count, static_cast<std::size_t>(2 * kSecond / period));
  }
  EXPECT_EQ(counters().restarts, 0u);
}

TEST_F(Altimeter, ItIsStoppedAndThenStarted) {
  EXPECT_EQ(written(line, now), Bytes{0x1B});
  EXPECT_TRUE(written(line, now + 99 * kMillisecond).empty());
  EXPECT_EQ(line.next_wake(), now + 100 * kMillisecond);
  now = line.next_wake();
  EXPECT_EQ(written(line, now), (Bytes{'D', 'W', '\r'}));
  EXPECT_EQ(line.next_wake(), now + kSecond);
}

TEST_F(Altimeter, AnotherCommand) {
  Ar1000 other{{.start_command = {'D', 'T'}}};
  other.restart(now);
  written(other, now);
  EXPECT_EQ(written(other, now + 100 * kMillisecond), (Bytes{'D', 'T', '\r'}));
}

TEST_F(Altimeter, SilentForASecondItIsReportedAgain) {
  written(line, now);
  now += 100 * kMillisecond;
  written(line, now);
  now += 900 * kMillisecond;
  hear("E15\r\n");  // an error is a sign of life
  EXPECT_TRUE(written(line, now + 999 * kMillisecond).empty());
  EXPECT_EQ(line.next_wake(), now + kSecond);
  now += kSecond;
  EXPECT_EQ(written(line, now), Bytes{0x1B});
  EXPECT_EQ(written(line, now + 100 * kMillisecond), (Bytes{'D', 'W', '\r'}));
  EXPECT_EQ(counters().restarts, 1u);
}

TEST_F(Altimeter, NothingAllocates) {
  const auto good = line_bytes("001.234\r\n"), error = line_bytes("E15\r\n");
  std::array<TalarisSample, SensorLine::kMaxSamples> samples;
  const std::uint64_t before = testing_support::allocations();
  for (int n = 0; n < 200; ++n) {
    now += 100 * kMillisecond;
    line.receive(n % 5 == 0 ? error : good, now);
    (void)line.transmit(now);
    (void)line.take(samples);
  }
  EXPECT_EQ(testing_support::allocations(), before);
  EXPECT_EQ(counters().packets, 200u);
}

}  // namespace
}  // namespace lss::talaris
