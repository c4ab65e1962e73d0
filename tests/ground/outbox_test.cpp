#include "tools/lss-ground/outbox.h"

#include <gtest/gtest.h>

namespace lss::ground {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

const Clock::time_point kStart{seconds(100)};

FramePtr frame(const std::string& text) { return std::make_shared<Frame>(text); }
std::string text(const FramePtr& f) {
  return {reinterpret_cast<const char*>(f->text()), f->size()};
}

TEST(Outbox, KeepsTheOrderOfWhatMustNotBeLost) {
  Outbox box;
  for (const char* word : {"one", "two", "three"}) EXPECT_TRUE(box.push(frame(word), kStart));
  for (const char* word : {"one", "two", "three"}) EXPECT_EQ(text(box.pop(kStart)), word);
  EXPECT_TRUE(box.empty());
}

TEST(Outbox, OfWhatIsReportedAgainOnlyTheNewestWaits) {
  Outbox box;
  box.push_newest("telemetry a", frame("a1"), kStart);
  box.push_newest("telemetry b", frame("b1"), kStart);
  box.push(frame("ack"), kStart);
  box.push_newest("telemetry a", frame("a2"), kStart);
  box.push_newest("telemetry a", frame("a3"), kStart);
  EXPECT_EQ(box.replaced(), 2u);
  for (const char* word : {"a3", "b1", "ack"}) EXPECT_EQ(text(box.pop(kStart)), word);
  EXPECT_TRUE(box.empty());
}

TEST(Outbox, IsBoundedByNumberAndBySize) {
  Outbox many;
  for (std::size_t i = 0; i < Outbox::kDepth; ++i) ASSERT_TRUE(many.push(frame("x"), kStart));
  EXPECT_FALSE(many.push(frame("x"), kStart));
  Outbox large;
  const FramePtr half = frame(std::string(Outbox::kBytes / 2, 'x'));
  EXPECT_TRUE(large.push(half, kStart));
  EXPECT_TRUE(large.push(half, kStart));
  EXPECT_FALSE(large.push(frame("x"), kStart));
  large.pop(kStart);
  EXPECT_TRUE(large.push(frame("x"), kStart));
}

TEST(Outbox, StallsWhenNothingIsTakenForTooLong) {
  Outbox box;
  EXPECT_FALSE(box.stalled(kStart + seconds(1000))) << "nothing to read";
  box.push(frame("x"), kStart);
  box.push(frame("y"), kStart + seconds(4));
  EXPECT_FALSE(box.stalled(kStart + Outbox::kPatience));
  EXPECT_TRUE(box.stalled(kStart + Outbox::kPatience + milliseconds(1)));
  box.pop(kStart + seconds(5));
  EXPECT_FALSE(box.stalled(kStart + seconds(9)));
}

TEST(RateLimit, LetsABurstThroughAndThenSoManyASecond) {
  RateLimit limit(10, 5);
  for (int i = 0; i < 5; ++i) EXPECT_TRUE(limit.take(kStart));
  EXPECT_FALSE(limit.take(kStart));
  EXPECT_TRUE(limit.take(kStart + milliseconds(100)));
  EXPECT_FALSE(limit.take(kStart + milliseconds(100)));
  int taken = 0;
  for (int ms = 101; ms <= 10'100; ++ms) taken += limit.take(kStart + milliseconds(ms));
  EXPECT_NEAR(taken, 100, 2);
}

}  // namespace
}  // namespace lss::ground
