#include "daemon/runtime/ring.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <thread>

namespace lss {
namespace {

TEST(Ring, KeepsTheOldestAndCountsWhatItDropsWhenFull) {
  Ring<int, 4> ring;
  for (int i = 0; i < 6; ++i) EXPECT_EQ(ring.push(i), i < 4);
  EXPECT_EQ(ring.dropped(), 2u);
  for (int i = 0, value = -1; i < 4; ++i) {
    ASSERT_TRUE(ring.pop(value));
    EXPECT_EQ(value, i);
  }
  int none = 0;
  EXPECT_FALSE(ring.pop(none));
}

TEST(Ring, PopIfLeavesWhatIsNotTaken) {
  Ring<int, 4> ring;
  ring.push(1);
  ring.push(5);
  int value = 0;
  EXPECT_TRUE(ring.pop_if(value, [](int v) { return v < 3; }));
  EXPECT_EQ(value, 1);
  EXPECT_FALSE(ring.pop_if(value, [](int v) { return v < 3; }));
  EXPECT_TRUE(ring.pop(value));
  EXPECT_EQ(value, 5);
}

TEST(Ring, EveryValueArrivesOnceAndInOrderOrIsCounted) {
  Ring<std::uint64_t, 64> ring;
  constexpr std::uint64_t kLast = 200'000;
  std::atomic<bool> done{false};
  std::thread writer([&] {
    for (std::uint64_t i = 1; i <= kLast; ++i) ring.push(i);
    done = true;
  });
  std::uint64_t before = 0, received = 0;
  for (;;) {
    const bool last = done;
    std::uint64_t value = 0;
    while (ring.pop(value)) {
      ASSERT_GT(value, before);
      before = value;
      ++received;
    }
    if (last) break;
  }
  writer.join();
  EXPECT_EQ(received + ring.dropped(), kLast);
}

}  // namespace
}  // namespace lss
