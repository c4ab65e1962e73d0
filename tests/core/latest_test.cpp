#include "daemon/runtime/latest.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <thread>

namespace lss {
namespace {

struct Pair {
  std::uint64_t number = 0;
  std::uint64_t twice = 0;  // torn values show as twice != 2 * number
  std::array<std::uint64_t, 30> same{};
};

TEST(Latest, ReaderSeesNothingNewBeforeTheFirstValue) {
  Latest<int> slot;
  EXPECT_FALSE(slot.update());
  EXPECT_EQ(slot.value(), 0);
}

TEST(Latest, ReaderSeesTheNewestOfSeveralValuesOnce) {
  Latest<int> slot;
  slot.put(1);
  slot.put(2);
  slot.put(3);
  EXPECT_TRUE(slot.update());
  EXPECT_EQ(slot.value(), 3);
  EXPECT_FALSE(slot.update());
  EXPECT_EQ(slot.value(), 3);
  EXPECT_EQ(slot.replaced(), 2u);
}

TEST(Latest, ValuesAreNeverTornAndNeverGoBackwards) {
  Latest<Pair> slot;
  constexpr std::uint64_t kLast = 200'000;
  std::thread writer([&] {
    for (std::uint64_t i = 1; i <= kLast; ++i) {
      Pair p{.number = i, .twice = 2 * i, .same = {}};
      p.same.fill(i);
      slot.put(p);
    }
  });
  std::uint64_t before = 0, read = 0;
  while (before < kLast) {
    read += slot.update();
    const Pair& p = slot.value();
    ASSERT_EQ(p.twice, 2 * p.number);
    for (const std::uint64_t x : p.same) ASSERT_EQ(x, p.number);
    ASSERT_GE(p.number, before);
    before = p.number;
  }
  writer.join();
  EXPECT_EQ(read + slot.replaced(), kLast);
}

}  // namespace
}  // namespace lss
