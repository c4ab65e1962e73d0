// The camera of docs/icd-talaris.md section 10.

#include "drivers/talaris/flow_camera.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "tests/support/allocations.h"
#include "tests/talaris/drivers/lines.h"

namespace lss::talaris {
namespace {

constexpr TimeNs kByte = 10 * kSecond / 115'200;
// Quality 200, 1500 counts along y, -250 along z.
const Bytes kGolden = {0x24, 0x58, 0x3C, 0x00, 0x02, 0x1F, 0x09, 0x00, 0xC8,
                       0xDC, 0x05, 0x00, 0x00, 0x06, 0xFF, 0xFF, 0xFF, 0x35};

class Camera : public ::testing::Test {
 protected:
  Camera() { line.restart(now); }
  std::vector<std::pair<TimeNs, Flow>> hear(const Bytes& bytes) {
    line.receive(line_bytes(bytes), now);
    return only<Flow>(take_all(line));
  }
  const LineCounters& counters() const { return line.status().counters; }

  FlowCamera line{FlowCameraParameters{}};
  TimeNs now = kSecond;
};

Bytes joined(std::initializer_list<Bytes> parts) {
  Bytes all;
  for (const Bytes& part : parts) all.insert(all.end(), part.begin(), part.end());
  return all;
}

TEST_F(Camera, TheGoldenFrame) {
  const auto got = hear(kGolden);
  ASSERT_EQ(got.size(), 1u);
  EXPECT_DOUBLE_EQ(got[0].second.angle_rad[0], 1.5);
  EXPECT_DOUBLE_EQ(got[0].second.angle_rad[1], -0.25);
  EXPECT_EQ(got[0].second.quality, 200);
  EXPECT_TRUE(got[0].second.usable);
  EXPECT_EQ(got[0].first, now - 18 * kByte);  // the begin of its first byte
  EXPECT_TRUE(written(line, now).empty());
}

TEST_F(Camera, AFrameInPiecesIsStampedWithItsFirstByteLessTheLatency) {
  FlowCamera late{{.counts_per_rad = 500, .latency_ns = 20 * kMillisecond}};
  late.restart(now);
  late.receive(line_bytes(Bytes(kGolden.begin(), kGolden.begin() + 5)), now);
  late.receive(line_bytes(Bytes(kGolden.begin() + 5, kGolden.end())), now + 2 * kMillisecond);
  const auto got = only<Flow>(take_all(late));
  ASSERT_EQ(got.size(), 1u);
  EXPECT_EQ(got[0].first, now - 5 * kByte - 20 * kMillisecond);
  EXPECT_DOUBLE_EQ(got[0].second.angle_rad[0], 3.0);
}

TEST_F(Camera, AWrongCheckAMarkedByteAndAnotherLengthAreNoSample) {
  for (std::size_t at = 3; at < kGolden.size(); ++at) {
    for (int bit = 0; bit < 8; ++bit) {
      Bytes wrong = kGolden;
      wrong[at] ^= static_cast<std::uint8_t>(1 << bit);
      FlowCamera other{FlowCameraParameters{}};
      other.restart(now);
      other.receive(line_bytes(wrong), now);
      EXPECT_TRUE(take_all(other).empty()) << "byte " << at << ", bit " << bit;
    }
  }
  auto marked = line_bytes(kGolden);
  marked[10].bad = true;
  line.receive(marked, now);
  EXPECT_TRUE(take_all(line).empty());
  EXPECT_EQ(counters().parity, 1u);
}

TEST_F(Camera, FramesOfOtherSensorsInTheDeviceArePassedOver) {
  // A range finder's (0x1F01), of 5 bytes.
  const Bytes range = {0x24, 0x58, 0x3C, 0x00, 0x01, 0x1F, 0x05,
                       0x00, 0xFF, 0xE8, 0x03, 0x00, 0x00, 0x82};
  EXPECT_EQ(hear(joined({range, kGolden, range})).size(), 1u);
  // The example of the protocol's documentation, of 18 bytes.
  Bytes example = {0x24, 0x58, 0x3C, 0xA5, 0x42, 0x42, 0x12, 0x00};
  for (const char c : std::string_view("Hello flying world"))
    example.push_back(static_cast<std::uint8_t>(c));
  example.push_back(0x82);
  EXPECT_EQ(hear(joined({example, kGolden})).size(), 1u);
  EXPECT_EQ(counters().packets, 2u);
  EXPECT_EQ(counters().errors(), 0u);
}

TEST_F(Camera, BadQualityIsHeardAndNotUsable) {
  FlowCamera choosy{{.least_quality = 201}};
  choosy.restart(now);
  choosy.receive(line_bytes(kGolden), now);
  const auto got = only<Flow>(take_all(choosy));
  ASSERT_EQ(got.size(), 1u);
  EXPECT_FALSE(got[0].second.usable);
  EXPECT_EQ(choosy.status().counters.said_errors, 1u);
}

TEST_F(Camera, AFrameThatBeginsWithinABrokenOneIsTaken) {
  const Bytes broken(kGolden.begin(), kGolden.begin() + 9);
  EXPECT_EQ(hear(joined({broken, kGolden})).size(), 1u);
  EXPECT_EQ(
      hear(joined({{0x24, 0x24, 0x58}, kGolden, {0x24, 0x58, 0x3C, 0, 0, 0, 0xFF, 0xFF}, kGolden}))
          .size(),
      2u);
}

TEST_F(Camera, ReceivesWithoutAllocating) {
  const auto bytes = line_bytes(kGolden);
  std::array<TalarisSample, SensorLine::kMaxSamples> samples;
  const std::uint64_t before = testing_support::allocations();
  std::size_t taken = 0;
  for (int i = 0; i < 200; ++i) {
    line.receive(bytes, now += 50 * kMillisecond);
    taken += line.take(samples);
  }
  EXPECT_EQ(testing_support::allocations(), before);
  EXPECT_EQ(taken, 200u);
}

// Every byte of a broken part may be the begin of a frame, so two whole frames end every search.
RC_GTEST_PROP(CameraFuzz, AnyBytesThenWholeFrames, ()) {
  FlowCamera line{FlowCameraParameters{}};
  line.restart(kSecond);
  const auto noise = *rc::gen::container<Bytes>(rc::gen::weightedOneOf<std::uint8_t>(
      {{3, rc::gen::elementOf(kGolden)}, {1, rc::gen::arbitrary<std::uint8_t>()}}));
  for (std::size_t at = 0; at < noise.size();) {
    const auto size =
        std::min<std::size_t>(*rc::gen::inRange<std::size_t>(1, 40), noise.size() - at);
    const auto from = noise.begin() + static_cast<std::ptrdiff_t>(at);
    line.receive(line_bytes(Bytes(from, from + static_cast<std::ptrdiff_t>(size))), kSecond);
    at += size;
    take_all(line);
  }
  Bytes frames;
  for (int i = 0; i < 4; ++i) frames.insert(frames.end(), kGolden.begin(), kGolden.end());
  line.receive(line_bytes(frames), 2 * kSecond);
  const auto got = only<Flow>(take_all(line));
  RC_ASSERT(!got.empty());
  RC_ASSERT(got.back().second.angle_rad[0] == 1.5);
}

}  // namespace
}  // namespace lss::talaris
