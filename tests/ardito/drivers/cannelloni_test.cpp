// CAN frames in datagrams, both ways, to the byte of docs/icd-ardito.md section 12.

#include "drivers/can/cannelloni.h"

#include <gtest/gtest.h>
#include <rapidcheck.h>
#include <rapidcheck/gtest.h>

#include <vector>

#include "tests/support/allocations.h"
#include "tests/support/any_frame.h"
#include "tests/support/can_frames.h"

namespace lss {
namespace {

using testing_support::Bytes;
using testing_support::frame;

std::vector<CanFrame> read(CannelloniReader& reader, const Bytes& datagram) {
  std::vector<CanFrame> frames;
  CanFrame next;
  reader.begin(datagram);
  while (reader.next(next)) frames.push_back(next);
  return frames;
}

Bytes write(CannelloniWriter& writer, const std::vector<CanFrame>& frames) {
  for (const CanFrame& f : frames) EXPECT_TRUE(writer.add(f));
  const auto datagram = writer.take();
  return {datagram.begin(), datagram.end()};
}

// The sequence number of the next datagram becomes `number`.
void count_up_to(CannelloniWriter& writer, int number) {
  for (int n = 0; n < number; ++n) writer.take();
}

const CanFrame kThree = frame(0x181, {1, 2, 3});
const Bytes kThreeBytes = {0x02, 0x00, 0x05, 0x00, 0x01, 0x00, 0x00,
                           0x01, 0x81, 0x03, 0x01, 0x02, 0x03};
// An extended frame, and a CAN FD frame that is none of ours.
const Bytes kExtendedAndFd = {0x02, 0x00, 0x06, 0x00, 0x02, 0x98, 0xFF, 0x01, 0x02, 0x02, 0xAA,
                              0xBB, 0x00, 0x00, 0x01, 0x23, 0x83, 0x01, 0x01, 0x02, 0x03};

TEST(Cannelloni, WritesTheGoldenDatagrams) {
  CannelloniWriter writer;
  count_up_to(writer, 5);
  EXPECT_EQ(write(writer, {kThree}), kThreeBytes);
  count_up_to(writer, 249);
  const Bytes sync_and_heartbeat = {0x02, 0x00, 0xFF, 0x00, 0x02, 0x00, 0x00, 0x00,
                                    0x80, 0x00, 0x00, 0x00, 0x07, 0x7F, 0x01, 0x05};
  EXPECT_EQ(write(writer, {frame(0x080, {}), frame(0x77F, {5})}), sync_and_heartbeat);
  EXPECT_EQ(write(writer, {kThree})[2], 0) << "the sequence number wraps";
}

TEST(Cannelloni, ReadsTheGoldenDatagrams) {
  CannelloniReader reader;
  EXPECT_EQ(read(reader, kThreeBytes), std::vector<CanFrame>{kThree});
  CanFrame extended = frame(0x18FF0102, {0xAA, 0xBB});
  extended.extended = true;
  EXPECT_EQ(read(reader, kExtendedAndFd), std::vector<CanFrame>{extended});
  EXPECT_EQ(reader.counters().can_fd, 1u);
  EXPECT_EQ(reader.counters().frames, 2u);
  EXPECT_EQ(reader.counters().broken(), 0u);
}

TEST(Cannelloni, ARemoteFrameHasALengthAndNoData) {
  CanFrame remote;
  remote.id = 0x701;
  remote.remote = true;
  remote.size = 1;
  CannelloniWriter writer;
  const Bytes datagram = write(writer, {remote, kThree});
  EXPECT_EQ(datagram.size(), 5u + 5u + 8u);
  EXPECT_EQ(datagram[5], 0x40);
  CannelloniReader reader;
  EXPECT_EQ(read(reader, datagram), (std::vector<CanFrame>{remote, kThree}));
}

TEST(Cannelloni, AnErrorFrameSaysSo) {
  CanFrame error = frame(0x40, {0, 0, 0, 0, 0, 0, 0, 0});
  error.error = true;
  CannelloniWriter writer;
  CannelloniReader reader;
  EXPECT_EQ(read(reader, write(writer, {error})), std::vector<CanFrame>{error});
}

TEST(Cannelloni, AWrongHeaderIsNotRead) {
  CannelloniReader reader;
  for (const std::size_t at : {0u, 1u}) {
    Bytes wrong = kThreeBytes;
    wrong[at] = 1;
    EXPECT_TRUE(read(reader, wrong).empty());
  }
  EXPECT_TRUE(read(reader, {2, 0, 0, 0}).empty());
  EXPECT_EQ(reader.counters().bad_header, 3u);
  EXPECT_TRUE(read(reader, {2, 0, 0, 0, 0}).empty()) << "no frames: legal";
  EXPECT_EQ(reader.counters().broken(), 3u);
}

TEST(Cannelloni, ATruncatedDatagramIsUsedUpToThere) {
  CannelloniWriter writer;
  const Bytes whole = write(writer, {kThree, frame(0x182, {4, 5})});
  for (std::size_t size = 5; size < whole.size(); ++size) {
    CannelloniReader reader;
    const auto frames = read(reader, Bytes(whole.begin(), whole.begin() + static_cast<long>(size)));
    EXPECT_EQ(frames.size(), size < 13 ? 0u : 1u);
    EXPECT_EQ(reader.counters().truncated, 1u);
  }
}

TEST(Cannelloni, MoreThanAnnouncedIsNotUsed) {
  Bytes more = kThreeBytes;
  more.insert(more.end(), kThreeBytes.begin() + 5, kThreeBytes.end());
  CannelloniReader reader;
  EXPECT_EQ(read(reader, more).size(), 1u);
  EXPECT_EQ(reader.counters().trailing, 1u);
}

TEST(Cannelloni, NineBytesOfDataOrATooLongIdentifierAreNoFrame) {
  Bytes nine = kThreeBytes;
  nine[9] = 9;
  nine.resize(5 + 5 + 9);
  CannelloniReader reader;
  EXPECT_TRUE(read(reader, nine).empty());
  EXPECT_EQ(reader.counters().bad_frame, 1u);
  Bytes identifier = kThreeBytes;
  identifier[7] = 0x08;
  EXPECT_TRUE(read(reader, identifier).empty());
  EXPECT_EQ(reader.counters().bad_frame, 2u);
}

TEST(Cannelloni, ADatagramIsNeverLongerThanOneEthernetFrameOfUdp) {
  CannelloniWriter writer;
  std::size_t count = 0;
  while (writer.add(frame(0x181, {1, 2, 3, 4, 5, 6, 7, 8}))) ++count;
  EXPECT_EQ(count, (1472u - 5u) / 13u);
  const auto datagram = writer.take();
  CannelloniReader reader;
  EXPECT_EQ(read(reader, {datagram.begin(), datagram.end()}).size(), count);
}

RC_GTEST_PROP(Cannelloni, ReadsWhatItWrote, ()) {
  const auto count = *rc::gen::inRange<std::size_t>(0, 100);
  std::vector<CanFrame> frames;
  for (std::size_t n = 0; n < count; ++n) frames.push_back(*testing_support::any_frame());
  CannelloniWriter writer;
  CannelloniReader reader;
  RC_ASSERT(read(reader, write(writer, frames)) == frames);
  RC_ASSERT(reader.counters().broken() == 0u);
}

RC_GTEST_PROP(Cannelloni, ReadsNothingWrongOutOfArbitraryBytes, (Bytes bytes)) {
  if (*rc::gen::inRange(0, 4) > 0 && bytes.size() > 2) bytes[0] = 2, bytes[1] = 0;
  CannelloniReader reader;
  for (const CanFrame& f : read(reader, bytes)) {
    RC_ASSERT(f.size <= 8);
    RC_ASSERT(f.id <= (f.extended || f.error ? kExtendedIds : kStandardIds));
  }
}

TEST(Cannelloni, AllocatesNothing) {
  CannelloniReader reader;
  CannelloniWriter writer;
  std::size_t heard = 0;
  const std::uint64_t before = testing_support::allocations();
  for (int n = 0; n < 1'000; ++n) {
    while (writer.add(kThree)) {
    }
    reader.begin(writer.take());
    CanFrame next;
    while (reader.next(next)) ++heard;
  }
  EXPECT_EQ(testing_support::allocations(), before);
  EXPECT_EQ(heard, 1'000u * ((1472u - 5u) / 8u));
}

}  // namespace
}  // namespace lss
