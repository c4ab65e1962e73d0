// Two copies and their sum: a flip of any single bit is corrected, two that hit both are noticed.

#include "daemon/cycle/twins.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <new>

namespace lss {
namespace {

constexpr std::size_t kSize = 1003;  // no whole number of words

struct TwinTest : testing::Test {
  TwinTest() {
    for (std::size_t i = 0; i < kSize; ++i) live[i] = static_cast<std::uint8_t>(i * i);
    before = live;
    twin.seal(live);
  }
  MemoryCheck check() { return twin.check(live); }

  std::array<std::uint8_t, kSize> live{}, before{};
  Twin<kSize> twin;
};

void flip(std::span<std::uint8_t> bytes, std::size_t bit) {
  bytes[bit / 8] = static_cast<std::uint8_t>(bytes[bit / 8] ^ 1u << bit % 8);
}

TEST_F(TwinTest, EveryBitOfTheFirstCopyIsCorrected) {
  EXPECT_EQ(check(), MemoryCheck::good);
  for (std::size_t bit = 0; bit < 8 * kSize; ++bit) {
    flip(live, bit);
    ASSERT_EQ(check(), MemoryCheck::corrected) << bit;
    ASSERT_EQ(live, before) << bit;
    ASSERT_EQ(check(), MemoryCheck::good) << bit;
  }
}

TEST_F(TwinTest, EveryBitOfTheSecondCopyIsCorrected) {
  for (std::size_t bit = 0; bit < 8 * kSize; ++bit) {
    flip(twin.copy(), bit);
    ASSERT_EQ(check(), MemoryCheck::corrected) << bit;
    ASSERT_EQ(live, before) << bit;
    ASSERT_EQ(check(), MemoryCheck::good) << bit;
  }
}

TEST(SealedTest, EveryBitIsCorrectedAndTwoAreNoticed) {
  using Bytes = std::array<std::uint8_t, 53>;
  Bytes value{};
  for (std::size_t i = 0; i < value.size(); ++i) value[i] = static_cast<std::uint8_t>(7 * i);
  Sealed<Bytes> sealed(value);
  const std::span<std::uint8_t> memory = bytes_of(sealed);
  Bytes opened{};
  for (std::size_t bit = 0; bit < 8 * memory.size(); ++bit) {
    flip(memory, bit);
    opened = {};
    ASSERT_TRUE(sealed.open(opened)) << bit;
    ASSERT_EQ(opened, value) << bit;
    flip(memory, bit);
  }
  flip(memory, 3);
  flip(memory, 8 * value.size() + 4);
  opened = {};
  EXPECT_FALSE(sealed.open(opened));
  EXPECT_EQ(opened, Bytes{});
}

// Only its outbox has no second copy.
TEST(TwinsTest, ContainAllOfTheSupervisorThatOutlivesAFrame) {
  using S = Twins<int>;
  alignas(Supervisor) std::array<std::uint8_t, sizeof(Supervisor)> room{};
  const auto& supervisor = *std::launder(reinterpret_cast<Supervisor*>(room.data()));
  EXPECT_EQ(reinterpret_cast<const std::uint8_t*>(&supervisor.outbox()), &room[S::kSupervisor]);
}

TEST_F(TwinTest, FlipsInBothCopiesAreLost) {
  for (std::size_t bit = 0; bit + 9 < 8 * kSize; ++bit) {
    flip(live, bit);
    flip(twin.copy(), bit + 9);
    ASSERT_EQ(check(), MemoryCheck::lost) << bit;
    EXPECT_EQ(check(), MemoryCheck::good) << "it goes on with what there is";
    live = before;
    twin.seal(live);
  }
}

// Also of the highest bits of two words, which an odd factor leaves as they are.
TEST_F(TwinTest, TwoFlipsInOneCopyAreNoticedWhenTheOtherIsDamagedToo) {
  for (const std::size_t highest : {63u, 62u, 31u, 0u}) {
    for (std::size_t word = 1; word < kSize / 8; ++word) {
      if (word % 4 == 0) continue;  // in one of the four sums of words a few pairs cancel: sum.h
      flip(live, highest);
      flip(live, 64 * word + highest);
      flip(twin.copy(), 8 * 500);
      ASSERT_EQ(check(), MemoryCheck::lost) << highest << " " << word;
      live = before;
      twin.seal(live);
    }
  }
}

TEST_F(TwinTest, AWipedCopyReplacesNothing) {
  std::ranges::fill(bytes_of(twin), std::uint8_t{0});
  EXPECT_EQ(check(), MemoryCheck::lost);
  EXPECT_EQ(live, before);
}

}  // namespace
}  // namespace lss
