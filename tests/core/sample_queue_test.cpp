// Samples come in order and only before the end of a frame; a flipped bit is corrected, two that
// hit both copies cost the sample.

#include "daemon/runtime/sample_queue.h"

#include <gtest/gtest.h>

#include <vector>

#include "tests/support/copies.h"

namespace lss {
namespace {

struct Stamped {
  TimeNs time_ns = 0;
  std::uint64_t value = 0;
};

std::vector<std::uint64_t> taken(SampleQueue<Stamped>& queue, TimeNs end) {
  std::vector<std::uint64_t> all;
  for (Stamped sample; queue.pop(sample, end);) all.push_back(sample.value);
  return all;
}

TEST(SampleQueue, GivesSamplesInOrderUpToTheEndOfTheFrame) {
  SampleQueue<Stamped> queue;
  for (const TimeNs time : {1, 2, 3, 5}) queue.push({time, static_cast<std::uint64_t>(10 * time)});
  EXPECT_EQ(taken(queue, 3), (std::vector<std::uint64_t>{10, 20}));
  EXPECT_EQ(taken(queue, 3), std::vector<std::uint64_t>{});
  EXPECT_EQ(taken(queue, 6), (std::vector<std::uint64_t>{30, 50}));
}

TEST(SampleQueue, DropsAndCountsWhatDoesNotFit) {
  SampleQueue<Stamped> queue;
  for (std::uint64_t i = 0; i < 256; ++i) ASSERT_TRUE(queue.push({1, i}));
  EXPECT_FALSE(queue.push({1, 256}));
  EXPECT_EQ(queue.dropped(), 1u);
  EXPECT_EQ(taken(queue, 2).size(), 256u);
}

TEST(SampleQueue, CorrectsAFlippedBitAndDropsASampleOfWhichBothCopiesAreDamaged) {
  constexpr std::uint64_t kValue = 0x1234'5678'9ABC'DEF0;
  for (const std::size_t damaged : {0u, 1u, 2u}) {
    SampleQueue<Stamped> queue;
    queue.push({1, kValue});
    queue.push({2, 7});
    const auto copies = testing_support::copies_of(kValue, bytes_of(queue));
    ASSERT_EQ(copies.size(), 2u);
    testing_support::damage(copies, damaged);
    const bool corrected = damaged != 2;
    EXPECT_EQ(taken(queue, 3),
              corrected ? (std::vector<std::uint64_t>{kValue, 7}) : std::vector<std::uint64_t>{7});
    EXPECT_EQ(queue.dropped(), corrected ? 0u : 1u);
  }
}

}  // namespace
}  // namespace lss
