// The LandMark 30 of docs/icd-talaris.md section 2.

#include "drivers/talaris/landmark30.h"

#include <gtest/gtest.h>

#include "idl/angles.h"
#include "tests/support/allocations.h"
#include "tests/talaris/drivers/lines.h"

namespace lss::talaris {
namespace {

constexpr TimeNs kPeriod = 5 * kMillisecond;
constexpr TimeNs kByte = 12 * kSecond / 115'200;
constexpr TimeNs kOnWire = 18 * kByte;

// A sensor that sends packet n at n periods, and a reader that reads each when it is complete.
class Landmark : public ::testing::Test {
 protected:
  TimeNs begin_of(int n) const { return kSecond + n * kPeriod; }
  void bring(const Bytes& bytes, TimeNs read_at) { line.receive(line_bytes(bytes), read_at); }
  void packet(int n, std::uint8_t status = 0, TimeNs late = 0) {
    bring(landmark_packet(static_cast<std::uint8_t>(n), status), begin_of(n) + kOnWire + late);
  }
  void packets(int first, int last) {
    for (int n = first; n <= last; ++n) packet(n);
  }
  std::vector<std::pair<TimeNs, ImuPacket>> taken() { return only<ImuPacket>(take_all(line)); }
  const LineCounters& counters() const { return line.status().counters; }

  LandMark30 line{LandMark30Parameters{}};
};

TEST_F(Landmark, TheGoldenPacketIsReadInSiUnits) {
  packet(6);
  taken();
  bring(kLandmarkGolden, begin_of(7) + kOnWire);
  const auto got = taken();
  ASSERT_EQ(got.size(), 2u);  // the first one waited for this one
  const ImuPacket& p = got[1].second;
  EXPECT_DOUBLE_EQ(p.rate_rad_s[0], 1.00 * kDegree);
  EXPECT_DOUBLE_EQ(p.rate_rad_s[1], -2.50 * kDegree);
  EXPECT_DOUBLE_EQ(p.rate_rad_s[2], 0.05 * kDegree);
  EXPECT_DOUBLE_EQ(p.force_m_s2[0], 0.1 * 9.80665);  // its status says 0.0001 g
  EXPECT_NEAR(p.force_m_s2[1], -0.0012 * 9.80665, 1e-15);
  EXPECT_NEAR(p.force_m_s2[2], 0.0003 * 9.80665, 1e-15);
  EXPECT_DOUBLE_EQ(p.temperature_degC, 25.12);
  EXPECT_EQ(p.status, 0x42);
}

TEST_F(Landmark, WithoutAScaleStatusTheDefaultScaleIsUsed) {
  packets(2, 3);
  const auto got = taken();
  ASSERT_EQ(got.size(), 2u);
  EXPECT_NEAR(got[1].second.force_m_s2[0], 9.80665, 1e-12);
  EXPECT_NEAR(got[1].second.force_m_s2[1], -0.012 * 9.80665, 1e-12);
  EXPECT_NEAR(got[1].second.rate_rad_s[1], -2.50 * kDegree, 1e-12);
}

TEST_F(Landmark, ItIsEightE2) {
  const SerialFormat format = line.format();
  EXPECT_EQ(format.baud, 115'200);
  EXPECT_EQ(format.parity, SerialFormat::Parity::even);
  EXPECT_EQ(format.stop_bits, 2);
  EXPECT_EQ(byte_time_ns(format), kByte);
}

TEST_F(Landmark, TheFirstPacketNeedsTheOneAfterIt) {
  packet(100);
  EXPECT_TRUE(taken().empty());
  packet(101);
  EXPECT_EQ(taken().size(), 2u);
}

TEST_F(Landmark, APacketThatNothingFollowsInStepIsNoneThoughItSumsToZero) {
  bring(landmark_packet(10), begin_of(0));
  bring(landmark_packet(12), begin_of(1));  // not the next one
  bring(landmark_packet(13), begin_of(2));
  const auto got = taken();
  ASSERT_EQ(got.size(), 2u);
  EXPECT_EQ(counters().packets, 2u);
  EXPECT_EQ(counters().skipped, 18u);
}

TEST_F(Landmark, BytesInAnyCutAreTheSamePackets) {
  Bytes all;
  for (int n = 0; n < 20; ++n) {
    const Bytes one = landmark_packet(static_cast<std::uint8_t>(n));
    all.insert(all.end(), one.begin(), one.end());
  }
  for (const std::uint8_t byte : all) bring({byte}, begin_of(20));
  EXPECT_EQ(counters().packets, 20u);
  EXPECT_EQ(counters().lost, 0u);
  EXPECT_EQ(counters().skipped, 0u);
}

TEST_F(Landmark, TheCounterWrapsWithoutALoss) {
  packets(250, 262);
  EXPECT_EQ(counters().packets, 13u);
  EXPECT_EQ(counters().lost, 0u);
  EXPECT_EQ(taken().back().second.count, 13u);
}

TEST_F(Landmark, MissingPacketsAreCountedAcrossTheWrap) {
  packets(250, 253);
  packets(258, 260);  // 254 to 257 are missing
  EXPECT_EQ(counters().packets, 7u);
  EXPECT_EQ(counters().lost, 4u);
  EXPECT_EQ(taken().back().second.count, 11u);
}

TEST_F(Landmark, MoreThanAWholeTurnOfTheCounterMissingIsCountedByTheTime) {
  packets(0, 9);
  taken();
  packets(400, 401);  // 1.95 s later: 390 are missing, 134 by the counter alone
  EXPECT_EQ(counters().lost, 390u);
  EXPECT_EQ(taken().back().second.count, 402u);
}

TEST_F(Landmark, AStandingCounterIsNoNewPacket) {
  packets(0, 9);
  for (int n = 10; n < 20; ++n) bring(landmark_packet(9), begin_of(n) + kOnWire);
  EXPECT_EQ(counters().packets, 10u);
  EXPECT_EQ(counters().repeated, 10u);
}

TEST_F(Landmark, AChangedByteCostsThatPacketOnly) {
  packets(0, 9);
  Bytes broken = landmark_packet(10);
  broken[5] ^= 0x10;
  bring(broken, begin_of(10) + kOnWire);
  packets(11, 20);
  EXPECT_EQ(counters().packets, 20u);
  EXPECT_EQ(counters().bad_check, 1u);
  EXPECT_EQ(counters().lost, 1u);
}

TEST_F(Landmark, AByteWithAParityErrorCostsItsPacketThoughTheSumIsGood) {
  packets(0, 9);
  auto marked = line_bytes(landmark_packet(10));
  marked[4].bad = true;
  line.receive(marked, begin_of(10) + kOnWire);
  packets(11, 20);
  EXPECT_EQ(counters().packets, 20u);
  EXPECT_EQ(counters().parity, 1u);
  EXPECT_EQ(counters().bad_check, 0u);
  EXPECT_EQ(counters().lost, 1u);
}

TEST_F(Landmark, ALostByteCostsThatPacketOnly) {
  packets(0, 9);
  Bytes shorter = landmark_packet(10);
  shorter.erase(shorter.begin() + 6);
  bring(shorter, begin_of(10) + kOnWire);
  packets(11, 20);
  EXPECT_EQ(counters().packets, 20u);
  EXPECT_EQ(counters().lost, 1u);
}

// A whole packet that sums to 0 may stand in the data of two.
TEST_F(Landmark, APacketInsideOthersIsNotTaken) {
  Bytes inner = landmark_packet(77);
  Bytes outer(18, 0);
  outer[0] = 0x2A;
  outer[1] = 200;
  std::copy_n(inner.begin(), 14, outer.begin() + 3);
  outer = with_sum(outer);
  Bytes next = landmark_packet(201);
  std::copy_n(inner.begin() + 14, 4, next.begin() + 2);
  next = with_sum(next);
  bring(outer, begin_of(0) + kOnWire);
  bring(next, begin_of(1) + kOnWire);
  EXPECT_EQ(taken().size(), 2u);
  EXPECT_EQ(counters().skipped, 0u);
}

TEST_F(Landmark, TheStampIsTheBeginOfTheFirstByte) {
  packets(0, 9);
  const auto got = taken();
  ASSERT_EQ(got.size(), 10u);
  for (int n = 0; n < 10; ++n) EXPECT_EQ(got[static_cast<std::size_t>(n)].first, begin_of(n)) << n;
}

TEST_F(Landmark, ALateReaderDoesNotMakeLateStamps) {
  packets(0, 9);
  for (int n = 10; n < 60; ++n) packet(n, 0, (n * 37 % 30) * 100 * kMicrosecond);
  const auto got = taken();
  ASSERT_EQ(got.size(), 60u);
  for (int n = 0; n < 60; ++n) {
    const auto [time, p] = got[static_cast<std::size_t>(n)];
    EXPECT_GE(time, begin_of(n)) << n;
    EXPECT_LE(time, begin_of(n) + 300 * kMicrosecond) << n;  // the reader: up to 3 ms
  }
}

TEST_F(Landmark, PacketsReadAllAtOnceKeepTheirRhythm) {
  packets(0, 9);
  Bytes all;
  for (int n = 10; n < 30; ++n) {
    const Bytes one = landmark_packet(static_cast<std::uint8_t>(n));
    all.insert(all.end(), one.begin(), one.end());
  }
  bring(all, begin_of(29) + kOnWire);  // stood for 100 ms
  packets(30, 31);
  const auto got = taken();
  ASSERT_EQ(got.size(), 32u);
  for (int n = 0; n < 32; ++n) {
    EXPECT_NEAR(static_cast<double>(got[static_cast<std::size_t>(n)].first),
                static_cast<double>(begin_of(n)), 300e3)
        << n;
  }
}

TEST_F(Landmark, APauseOfTheSensorDelaysTheStampsAfterIt) {
  packets(0, 9);
  for (int n = 10; n < 20; ++n) packet(n, 0, 50 * kMillisecond);  // each 50 ms later from here on
  const auto got = taken();
  ASSERT_EQ(got.size(), 20u);
  EXPECT_EQ(got[10].first, begin_of(10) + 50 * kMillisecond);
  EXPECT_EQ(counters().lost, 0u);
}

TEST_F(Landmark, StampsNeverGoBack) {
  packets(0, 9);
  for (int n = 10; n < 40; ++n) packet(n, 0, n % 3 == 0 ? -4 * kMillisecond : 4 * kMillisecond);
  TimeNs last = 0;
  for (const auto& [time, p] : taken()) {
    EXPECT_GT(time, last);
    last = time;
  }
}

TEST_F(Landmark, AFrameBeginsWithEachFortiethCount) {
  std::vector<FrameTick> ticks;
  FrameTick tick;
  for (int n = 0; n < 130; ++n) {
    packet(n);
    if (line.take_tick(tick)) ticks.push_back(tick);
  }
  ASSERT_EQ(ticks.size(), 3u);
  for (std::size_t k = 0; k < 3; ++k) {
    EXPECT_EQ(ticks[k].index, k + 1);
    EXPECT_EQ(ticks[k].time_ns, begin_of(static_cast<int>(40 * (k + 1)) - 1));  // counts from 1
  }
}

TEST_F(Landmark, LostPacketsDoNotShiftTheFrame) {
  FrameTick tick;
  packets(0, 36);
  packets(45, 60);  // counts 38 to 45 are lost, the begin of the frame with them
  ASSERT_TRUE(line.take_tick(tick));
  EXPECT_EQ(tick.index, 1u);
  EXPECT_EQ(tick.time_ns, begin_of(39));
  packets(61, 78);
  EXPECT_FALSE(line.take_tick(tick));
  packet(79);
  ASSERT_TRUE(line.take_tick(tick));
  EXPECT_EQ(tick.index, 2u);
  EXPECT_EQ(tick.time_ns, begin_of(79));
  packets(200, 201);  // frames 3 and 4 have no tick at all
  ASSERT_TRUE(line.take_tick(tick));
  EXPECT_EQ(tick.index, 5u);
}

TEST_F(Landmark, TheScaleIsUsedFromItsStatusOnAndReported) {
  packets(2, 3);
  packet(4, 0x40 | 0x11 | 0x02);  // 0.015 deg/s, 0.0001 g
  const auto samples = take_all(line);
  const auto packets = only<ImuPacket>(samples);
  ASSERT_EQ(packets.size(), 3u);
  EXPECT_NEAR(packets[1].second.rate_rad_s[0], 1.00 * kDegree, 1e-15);
  EXPECT_NEAR(packets[2].second.rate_rad_s[0], 1.50 * kDegree, 1e-15);
  EXPECT_NEAR(packets[2].second.force_m_s2[0], 0.1 * 9.80665, 1e-12);
  const auto told = only<ImuStatus>(samples);
  ASSERT_EQ(told.size(), 2u);  // test flags, for the first time, and the scale
  EXPECT_EQ(told[1].second.kind, ImuStatus::Kind::scale);
  EXPECT_NEAR(told[1].second.rate_unit_rad_s, 0.015 * kDegree, 1e-15);
  EXPECT_NEAR(told[1].second.force_unit_m_s2, 1e-4 * 9.80665, 1e-15);
  EXPECT_EQ(line.status().rate_unit_rad_s, told[1].second.rate_unit_rad_s);
}

TEST_F(Landmark, AnotherScaleIsTakenWhenItIsSaidTwice) {
  packets(2, 3);
  packet(4, 0x40);
  packet(5, 0x40 | 0x0E);  // 0.002 g, once: noise
  packet(6, 0x40);
  EXPECT_NEAR(taken().back().second.force_m_s2[0], 9.80665, 1e-12);
  packet(7, 0x40 | 0x0E);
  packet(8, 0x00);  // test flags in between
  packet(9, 0x40 | 0x0E);
  const auto samples = take_all(line);
  const auto packets = only<ImuPacket>(samples);
  ASSERT_EQ(packets.size(), 3u);
  EXPECT_NEAR(packets[0].second.force_m_s2[0], 9.80665, 1e-12);
  EXPECT_NEAR(packets[2].second.force_m_s2[0], 2 * 9.80665, 1e-12);
  EXPECT_EQ(only<ImuStatus>(samples).size(), 1u);
}

TEST_F(Landmark, TheScaleOutlastsALineThatIsOpenedAgain) {
  packets(2, 3);
  packet(4, 0x40 | 0x11 | 0x02);  // 0.015 deg/s, 0.0001 g
  taken();
  line.restart(begin_of(5));
  packets(5, 6);  // test flags
  const auto got = taken();
  ASSERT_EQ(got.size(), 2u);
  for (const std::size_t i : {0u, 1u}) {
    EXPECT_NEAR(got[i].second.rate_rad_s[0], 1.50 * kDegree, 1e-15);
    EXPECT_NEAR(got[i].second.force_m_s2[0], 0.1 * 9.80665, 1e-12);
  }
  packet(7, 0x40);  // another sensor, perhaps
  packet(8, 0x00);
  packet(9, 0x40);
  EXPECT_NEAR(taken().back().second.force_m_s2[0], 9.80665, 1e-12);
}

TEST_F(Landmark, EachScaleOfTheTable) {
  const double force_g[8] = {1e-3, 1e-4, 1e-4, 5e-4, 5e-4, 5e-4, 1e-3, 2e-3};
  for (std::uint8_t i = 0; i < 8; ++i) {
    const auto status = static_cast<std::uint8_t>(0x40 | i << 1);
    EXPECT_NEAR(landmark_force_unit_m_s2(status), force_g[i] * 9.80665, 1e-15);
  }
  const std::pair<int, double> rates[] = {{0x00, 0.01}, {0x01, 0.01},  {0x10, 0.01}, {0x20, 0.01},
                                          {0x30, 0.01}, {0x11, 0.015}, {0x21, 0.05}, {0x31, 0.005}};
  for (const auto& [bits, deg_s] : rates) {
    EXPECT_NEAR(landmark_rate_unit_rad_s(static_cast<std::uint8_t>(0x4E | bits)), deg_s * kDegree,
                1e-15)
        << bits;
  }
}

TEST_F(Landmark, WhatItSaysOfItselfIsReportedOnce) {
  using Kind = ImuStatus::Kind;
  std::vector<std::pair<TimeNs, ImuStatus>> told;
  for (int n = 0; n < 512; ++n) {
    const int counter = n % 256;
    int status = counter % 2 != 0 ? 0x40 : 0x00;
    if (counter == 0) status = 0x03;
    if (counter == 1) status = 0x80 | 0x11;
    if (counter >= 247) status = counter;
    packet(n, static_cast<std::uint8_t>(status));
    for (const auto& one : only<ImuStatus>(take_all(line))) told.push_back(one);
  }
  std::vector<Kind> kinds;
  for (const auto& [time, status] : told) kinds.push_back(status.kind);
  const std::vector<Kind> expected = {
      Kind::firmware_major, Kind::release,       Kind::test_flags,    Kind::scale,
      Kind::filter,         Kind::board_number,  Kind::board_number,  Kind::board_number,
      Kind::board_number,   Kind::serial_number, Kind::serial_number, Kind::serial_number,
      Kind::serial_number};
  EXPECT_EQ(kinds, expected);
  EXPECT_EQ(told[0].second.value, 3);
  EXPECT_EQ(told[1].second.value, 0x11);
  EXPECT_EQ(told[5].second.value, 248);
  EXPECT_EQ(told[12].second.index, 3);
}

TEST_F(Landmark, TestFlagsAreReportedWhenTheyChange) {
  packets(2, 5);
  take_all(line);
  packet(6, 0x05);
  const auto told = only<ImuStatus>(take_all(line));
  ASSERT_EQ(told.size(), 1u);
  EXPECT_EQ(told[0].second.kind, ImuStatus::Kind::test_flags);
  EXPECT_EQ(told[0].second.value, 5);
}

TEST_F(Landmark, ByItselfItSaysNothingToTheSensor) {
  line.restart(kSecond);
  EXPECT_TRUE(written(line, 10 * kSecond).empty());
  EXPECT_EQ(line.next_wake(), INT64_MAX);
}

TEST(LandmarkCommands, PauseRateAndRunAreSaidAndAgainWhenItIsSilent) {
  LandMark30 line{{.configure = true}};
  line.restart(kSecond);
  TimeNs now = kSecond;
  const auto sequence = [&] {
    Bytes all;
    const TimeNs end = now + 200 * kMillisecond;
    while (line.next_wake() < end) {
      now = std::max(now, line.next_wake());
      const Bytes piece = written(line, now);
      EXPECT_FALSE(piece.empty());
      if (piece.empty()) break;
      all.insert(all.end(), piece.begin(), piece.end());
    }
    return all;
  };
  Bytes expected(10, 0xD4);
  for (const int byte : {0x2B, 0x02, 0x00, 0xD3, 0, 0, 0, 0, 0x2B, 0x0D, 0x00, 0xC8, 0, 0, 0, 0}) {
    expected.push_back(static_cast<std::uint8_t>(byte));
  }
  EXPECT_EQ(sequence(), expected);
  EXPECT_EQ(line.next_wake(), now + kSecond);
  now += kSecond;
  EXPECT_EQ(sequence(), expected);
  EXPECT_EQ(line.status().counters.restarts, 1u);
  for (std::uint8_t n = 0; n < 10; ++n) {
    line.receive(line_bytes(landmark_packet(n)), now + n * kPeriod);
  }
  EXPECT_GT(line.next_wake(), now + kSecond + 40 * kMillisecond);
}

TEST(LandmarkCommands, AHundredHertz) {
  const auto command = landmark_command(kLandmark100Hz);
  EXPECT_EQ(command, (std::array<std::uint8_t, 8>{0x2B, 0x0A, 0, 0xCB, 0, 0, 0, 0}));
}

TEST_F(Landmark, NothingAllocates) {
  std::vector<std::vector<LineByte>> made;
  for (int n = 0; n < 300; ++n) {
    made.push_back(line_bytes(landmark_packet(static_cast<std::uint8_t>(n), n % 2 ? 0x40 : 0)));
  }
  made[20][3].value ^= 1;
  made[30][3].bad = true;
  std::array<TalarisSample, SensorLine::kMaxSamples> samples;
  const std::uint64_t before = testing_support::allocations();
  for (int n = 0; n < 300; ++n) {
    line.receive(made[static_cast<std::size_t>(n)], begin_of(n) + kOnWire);
    (void)line.transmit(begin_of(n));
    (void)line.take(samples);
  }
  EXPECT_EQ(testing_support::allocations(), before);
  EXPECT_EQ(counters().packets, 298u);
}

}  // namespace
}  // namespace lss::talaris
