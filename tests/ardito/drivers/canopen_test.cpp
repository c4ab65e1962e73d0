// Numbers, SDO client and node configuration, to the byte of docs/icd-ardito.md.

#include "drivers/canopen/canopen.h"

#include <gtest/gtest.h>
#include <rapidcheck.h>
#include <rapidcheck/gtest.h>

#include <set>
#include <string>
#include <vector>

#include "drivers/canopen/node.h"
#include "drivers/canopen/sdo.h"
#include "tests/support/any_frame.h"
#include "tests/support/can_frames.h"

namespace lss::canopen {
namespace {

using testing_support::Bytes;
using testing_support::data_of;
using testing_support::frame;
using Result = SdoClient::Result;

constexpr TimeNs kTimeout = 200 * kMillisecond;

struct Transfer {
  SdoClient client{1, kTimeout, 3};
  TimeNs now = kSecond;
  Bytes sent() {
    CanFrame f;
    if (!client.transmit(now, f)) return {};
    EXPECT_EQ(f.id, 0x601u);
    return data_of(f);
  }
  void answer(const Bytes& data) { client.receive(frame(0x581, data)); }
};

TEST(Canopen, StatuswordsAreTheStatesOfCia402) {
  EXPECT_EQ(drive_state(0x0000), DriveState::not_ready);
  EXPECT_EQ(drive_state(0x0250), DriveState::switch_on_disabled);
  EXPECT_EQ(drive_state(0x0231), DriveState::ready_to_switch_on);
  EXPECT_EQ(drive_state(0x0233), DriveState::switched_on);
  EXPECT_EQ(drive_state(0x1637), DriveState::operation_enabled);
  EXPECT_EQ(drive_state(0x0217), DriveState::quick_stop_active);
  EXPECT_EQ(drive_state(0x021F), DriveState::fault_reaction);
  EXPECT_EQ(drive_state(0x0218), DriveState::fault);
  // Bits that say nothing about the state do not change it: 4 voltage, 7 warning, 8 to 15.
  for (unsigned other = 0; other < 0x10000; ++other) {
    const auto word = static_cast<std::uint16_t>((other & 0xFF90) | 0x27);
    ASSERT_EQ(drive_state(word), DriveState::operation_enabled) << other;
  }
}

TEST(Canopen, EachStatusOfADriveHasAControlwordOnTheWayToEnabled) {
  EXPECT_EQ(towards_enabled(DriveState::switch_on_disabled), 0x06);
  EXPECT_EQ(towards_enabled(DriveState::ready_to_switch_on), 0x07);
  EXPECT_EQ(towards_enabled(DriveState::switched_on), 0x0F);
  EXPECT_EQ(towards_enabled(DriveState::operation_enabled), 0x0F);
  EXPECT_EQ(towards_enabled(DriveState::quick_stop_active), 0x00);
  EXPECT_EQ(towards_enabled(DriveState::fault), 0x00);
  EXPECT_EQ(towards_enabled(DriveState::fault_reaction), 0x00);
  EXPECT_EQ(towards_enabled(DriveState::not_ready), 0x00);
  EXPECT_EQ(towards_enabled(DriveState::unknown), 0x00);
}

TEST(Sdo, WritesTheGoldenFrames) {
  const std::vector<std::pair<Entry, Bytes>> golden = {
      {{0x6060, 0, 1, 3}, {0x2F, 0x60, 0x60, 0, 3, 0, 0, 0}},
      {{0x6040, 0, 2, 0x000F}, {0x2B, 0x40, 0x60, 0, 0x0F, 0, 0, 0}},
      {{0x60FF, 0, 4, static_cast<std::uint32_t>(-1592)},
       {0x23, 0xFF, 0x60, 0, 0xC8, 0xF9, 0xFF, 0xFF}},
      {{0x1016, 1, 3, 0x030201}, {0x27, 0x16, 0x10, 1, 1, 2, 3, 0}}};
  for (const auto& [entry, bytes] : golden) {
    Transfer t;
    t.client.write(entry);
    EXPECT_EQ(t.sent(), bytes);
    EXPECT_EQ(t.client.result(), Result::pending);
    EXPECT_TRUE(t.sent().empty()) << "one request at a time";
    t.answer({0x60, bytes[1], bytes[2], bytes[3], 0, 0, 0, 0});
    EXPECT_EQ(t.client.result(), Result::done);
  }
}

TEST(Sdo, ReadsTheGoldenFrames) {
  const std::vector<std::tuple<std::uint16_t, Bytes, std::uint32_t>> golden = {
      {0x606C, {0x43, 0x6C, 0x60, 0, 0x2E, 0xFB, 0xFF, 0xFF}, static_cast<std::uint32_t>(-1234)},
      {0x6041, {0x4B, 0x41, 0x60, 0, 0x40, 0, 0x77, 0x77}, 0x0040},
      {0x1000, {0x43, 0x00, 0x10, 0, 0x92, 1, 2, 0}, 0x00020192},
      {0x6061, {0x4F, 0x61, 0x60, 0, 0x03, 9, 9, 9}, 3},
      {0x6061, {0x42, 0x61, 0x60, 0, 0x03, 0, 0, 1}, 0x01000003}};
  for (const auto& [index, answer, value] : golden) {
    Transfer t;
    t.client.read(index, 0);
    EXPECT_EQ(t.sent(), (Bytes{0x40, answer[1], answer[2], 0, 0, 0, 0, 0}));
    t.answer(answer);
    ASSERT_EQ(t.client.result(), Result::done);
    EXPECT_EQ(t.client.value(), value);
  }
}

TEST(Sdo, AnAbortOfTheNodeEndsTheTransfer) {
  Transfer t;
  t.client.read(0x5FFF, 0);
  EXPECT_EQ(t.sent(), (Bytes{0x40, 0xFF, 0x5F, 0, 0, 0, 0, 0}));
  t.answer({0x80, 0xFF, 0x5F, 0, 0x00, 0x00, 0x02, 0x06});
  EXPECT_EQ(t.client.result(), Result::aborted);
  EXPECT_EQ(t.client.abort_code(), 0x06020000u);
  EXPECT_TRUE(t.sent().empty());
  EXPECT_EQ(t.client.next_wake(), INT64_MAX);
}

TEST(Sdo, SilenceIsAskedAgainAndThenGivenUp) {
  Transfer t;
  t.client.write({0x6060, 0, 1, 3});
  const Bytes request = t.sent();
  for (int n = 0; n < 2; ++n) {
    EXPECT_EQ(t.client.next_wake(), t.now + kTimeout);
    t.now += kTimeout - 1;
    EXPECT_TRUE(t.sent().empty());
    t.now += 1;
    EXPECT_EQ(t.sent(), request);
  }
  t.now += kTimeout;
  EXPECT_EQ(t.sent(), (Bytes{0x80, 0x60, 0x60, 0, 0x00, 0x00, 0x04, 0x05}))
      << "the abort is sent to the node";
  EXPECT_EQ(t.client.result(), Result::aborted);
  EXPECT_EQ(t.client.abort_code(), kAbortTimeout);
  EXPECT_TRUE(t.sent().empty());
  EXPECT_EQ(t.client.counters().repeats, 2u);
}

TEST(Sdo, AnswersToOtherThingsAreCountedAndNotUsed) {
  Transfer t;
  t.answer({0x60, 0x60, 0x60, 0, 0, 0, 0, 0});
  t.client.write({0x6060, 0, 1, 3});
  t.answer({0x60, 0x60, 0x60, 0, 0, 0, 0, 0});  // before it was asked
  (void)t.sent();
  t.answer({0x60, 0x61, 0x60, 0, 0, 0, 0, 0});
  t.answer({0x60, 0x60, 0x60, 1, 0, 0, 0, 0});
  t.answer({0x60, 0x60, 0x60, 0});
  EXPECT_EQ(t.client.result(), Result::pending);
  EXPECT_EQ(t.client.counters().unexpected, 5u);
  t.answer({0x60, 0x60, 0x60, 0, 0, 0, 0, 0});
  EXPECT_EQ(t.client.result(), Result::done);
}

TEST(Sdo, ASegmentedAnswerIsRefused) {
  Transfer t;
  t.client.read(0x1008, 0);
  (void)t.sent();
  t.answer({0x41, 0x08, 0x10, 0, 20, 0, 0, 0});
  EXPECT_EQ(t.client.result(), Result::aborted);
  EXPECT_EQ(t.sent(), (Bytes{0x80, 0x08, 0x10, 0, 0x01, 0x00, 0x04, 0x05}));
}

RC_GTEST_PROP(Sdo, ArbitraryAnswersNeverEndInAnythingElseThanAResult, ()) {
  Transfer t;
  const bool reads = *rc::gen::arbitrary<bool>();
  if (reads) {
    t.client.read(0x1000, 0);
  } else {
    t.client.write({0x1000, 0, 4, 1});
  }
  for (int n = 0; n < 50; ++n) {
    (void)t.sent();
    CanFrame f = *testing_support::any_frame();
    if (*rc::gen::arbitrary<bool>()) f.data[1] = 0, f.data[2] = 0x10, f.data[3] = 0, f.size = 8;
    t.client.receive(f);
    t.now += *rc::gen::inRange<TimeNs>(0, 2 * kTimeout);
    RC_ASSERT(t.client.result() != Result::idle);
    if (reads && t.client.result() == Result::done) {
      const auto size = t.client.entry().size;
      RC_ASSERT(size >= 1 && size <= 4);
      RC_ASSERT(size == 4 || t.client.value() >> (8 * size) == 0);
    }
  }
  RC_ASSERT(t.client.counters().requests <= 3u);
}

TEST(NodeConfiguration, IsWrittenInTheOrderThatCia301Allows) {
  NodeParameters node;
  node.node = 0x05;
  node.entries[0] = {0x6060, 0, 1, 3};
  node.rpdo[0] = {1, kEvent, 0, 0, {0x6040'0010, 0x60FF'0020}};
  node.tpdo[0] = {1, kDeviceEvent, 20, 0, {0x6000'0108}};
  node.tpdo[1] = {3, kEvent, 0, 1000, {0x2101'0110}};
  const Configuration configuration(node, {});
  const std::vector<Entry> expected = {
      {0x1017, 0, 2, 100},        {0x1016, 1, 4, 0x007F012C}, {0x6060, 0, 1, 3},
      {0x1400, 1, 4, 0x80000205}, {0x1600, 0, 1, 0},          {0x1600, 1, 4, 0x60400010},
      {0x1600, 2, 4, 0x60FF0020}, {0x1600, 0, 1, 2},          {0x1400, 2, 1, 255},
      {0x1400, 1, 4, 0x00000205}, {0x1800, 1, 4, 0xC0000185}, {0x1A00, 0, 1, 0},
      {0x1A00, 1, 4, 0x60000108}, {0x1A00, 0, 1, 1},          {0x1800, 2, 1, 254},
      {0x1800, 3, 2, 20},         {0x1800, 1, 4, 0x40000185}, {0x1802, 1, 4, 0xC0000385},
      {0x1A02, 0, 1, 0},          {0x1A02, 1, 4, 0x21010110}, {0x1A02, 0, 1, 1},
      {0x1802, 2, 1, 255},        {0x1802, 5, 2, 1000},       {0x1802, 1, 4, 0x40000385},
  };
  const auto entries = configuration.entries();
  EXPECT_EQ(std::vector<Entry>(entries.begin(), entries.end()), expected);
  EXPECT_TRUE(configuration.complete());
  EXPECT_EQ(node.rpdo[0].bytes(), 6);
  EXPECT_EQ(node.tpdo_of(3), &node.tpdo[1]);
  EXPECT_EQ(node.tpdo_of(2), nullptr);
  EXPECT_EQ(node.tpdo_of(0), nullptr);
}

TEST(NodeConfiguration, SaysWhenThereIsNoRoomForAll) {
  NodeParameters node;
  node.node = 1;
  for (Entry& entry : node.entries) entry = {0x6060, 0, 1, 3};
  for (int n = 0; n < kMaxPdos; ++n) {
    const Pdo pdo = {static_cast<std::uint8_t>(n + 1), kOnSync, 1, 1, {1, 1, 1, 1}};
    node.rpdo[static_cast<std::size_t>(n)] = node.tpdo[static_cast<std::size_t>(n)] = pdo;
  }
  EXPECT_FALSE(Configuration(node, {}).complete());
}

}  // namespace
}  // namespace lss::canopen
