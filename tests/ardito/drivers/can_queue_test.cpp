// Frames that the kernel does not accept at once.

#include "drivers/can/can_queue.h"

#include <gtest/gtest.h>

#include <vector>

#include "tests/support/can_frames.h"

namespace lss {
namespace {

using testing_support::frame;

// Takes as many frames as there is room for.
class Bus final : public CanTransport {
 public:
  CanStatus open(const char*, std::span<const CanFilter>) noexcept override {
    return CanStatus::ok;
  }
  void close() noexcept override {}
  Received receive(std::span<CanFrame>, CanCounters&) noexcept override { return {}; }
  Sent send(std::span<const CanFrame> frames, CanCounters&) noexcept override {
    Sent result;
    result.lost = unplugged;
    for (const CanFrame& f : frames) {
      if (room == 0 || unplugged) break;
      --room;
      sent.push_back(f.id);
      ++result.frames;
    }
    return result;
  }

  std::size_t room = 0;
  bool unplugged = false;
  std::vector<std::uint32_t> sent;
};

struct Waiting {
  CanQueue queue;
  CanCounters counters;
  Bus bus;
  TimeNs now = kSecond;
  void push(std::uint32_t id) { queue.push(frame(id, {}), now, counters); }
  bool flush() { return queue.flush(bus, now, counters); }
};

TEST(CanQueue, WhatTheKernelDoesNotTakeIsSentLaterInItsOrder) {
  Waiting w;
  for (const std::uint32_t id : {0x201u, 0x202u, 0x203u}) w.push(id);
  w.bus.room = 1;
  EXPECT_TRUE(w.flush());
  EXPECT_EQ(w.queue.next_wake(), w.now + CanQueue::kRetry);
  EXPECT_EQ(w.counters.retries, 1u);
  w.push(0x204);
  w.bus.room = 9;
  w.now = w.queue.next_wake();
  EXPECT_TRUE(w.flush());
  EXPECT_EQ(w.bus.sent, (std::vector<std::uint32_t>{0x201, 0x202, 0x203, 0x204}));
  EXPECT_EQ(w.queue.next_wake(), CanQueue::kNever);
}

TEST(CanQueue, FullItDropsTheOldestPdoAndCounts) {
  Waiting w;
  w.push(0x000);
  for (std::size_t n = 1; n < CanQueue::kLength; ++n) w.push(0x200 + static_cast<std::uint32_t>(n));
  w.push(0x601);
  EXPECT_EQ(w.queue.size(), CanQueue::kLength);
  EXPECT_EQ(w.counters.dropped_full, 1u);
  w.bus.room = 1'000;
  EXPECT_TRUE(w.flush());
  ASSERT_EQ(w.bus.sent.size(), CanQueue::kLength);
  EXPECT_EQ(w.bus.sent[0], 0x000u) << "an NMT command stays";
  EXPECT_EQ(w.bus.sent[1], 0x202u);
  EXPECT_EQ(w.bus.sent.back(), 0x601u);
}

TEST(CanQueue, FullOfOtherThingsItDropsTheOldest) {
  Waiting w;
  for (std::size_t n = 0; n < CanQueue::kLength; ++n) w.push(0x600);
  w.push(0x601);
  w.bus.room = 1'000;
  EXPECT_TRUE(w.flush());
  EXPECT_EQ(w.bus.sent.size(), CanQueue::kLength);
  EXPECT_EQ(w.bus.sent.back(), 0x601u);
}

TEST(CanQueue, APdoThatWaitedTooLongIsNotSentAnyMore) {
  Waiting w;
  w.push(0x201);
  w.push(0x000);
  w.now += CanQueue::kStale;
  w.push(0x202);
  w.now += 1;
  w.bus.room = 9;
  EXPECT_TRUE(w.flush());
  EXPECT_EQ(w.bus.sent, (std::vector<std::uint32_t>{0x000, 0x202}));
  EXPECT_EQ(w.counters.dropped_stale, 1u);
}

TEST(CanQueue, SaysThatTheTransportIsLost) {
  Waiting w;
  w.push(0x201);
  w.bus.unplugged = true;
  EXPECT_FALSE(w.flush());
}

}  // namespace
}  // namespace lss
