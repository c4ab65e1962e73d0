// Bits that flip in registers and stack while a thread of the daemon works, and in its heap.

#include "tests/campaign/traps.h"

#include <gtest/gtest.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <exception>
#include <new>
#include <numeric>
#include <span>
#include <string_view>
#include <vector>

#include "drivers/talaris/sensor_line.h"
#include "tests/campaign/campaign.h"
#include "tests/campaign/flips.h"

namespace lss::campaign {
namespace {

using testing_support::bus_work;
using testing_support::frame_work;

#ifdef __x86_64__

void few() { asm volatile(".rept 100\n nop\n .endr"); }
void many() { asm volatile(".rept 1100\n nop\n .endr"); }

Instructions counted(void (*work)(), std::uint64_t most) {
  const std::vector<std::uint64_t> told = told_by_a_copy([&] {
    const auto run = [&] {
      frame_work([&] { work(); });
      many();  // no work of a thread
      bus_work(few);
    };
    const Instructions all = count_instructions(run, {most, most});
    return std::vector<std::uint64_t>(all.begin(), all.end());
  });
  Instructions all{};
  std::ranges::copy(told, all.begin());
  return all;
}

TEST(Traps, CountEachInstructionOfAThreadAndNoOther) {
  constexpr std::uint64_t kMost = 1'000'000;
  const Instructions less = counted(few, kMost), more = counted(many, kMost);
  EXPECT_GE(less[0], 100u);
  EXPECT_LT(less[0], 200u);
  EXPECT_EQ(more[0], less[0] + 1000);
  EXPECT_GE(less[1], 100u);
  EXPECT_LT(less[1], 200u);
  EXPECT_EQ(more[1], less[1]);
  EXPECT_EQ(counted(many, 50), (Instructions{50, 50}));
}

// What `work` returns when this hits it half-way through many().
template <class Work>
std::uint64_t after(Hit hit, const Work& work) {
  hit.instruction = 500;
  const std::uint64_t value = told_by_a_copy([&] {
                                expect(hit);
                                return std::vector{frame_work(work)};
                              }).front();
  EXPECT_TRUE(struck().happened);
  return value;
}

TEST(Traps, FlipThisBitOfARegister) {
  const auto rax = [] {
    std::uint64_t value = 5;
    asm volatile(".rept 1100\n nop\n .endr" : "+a"(value));
    return value;
  };
  EXPECT_EQ(after({.bit = register_bits("rax").first + 3}, rax), 13u);
  EXPECT_EQ(after({.bit = register_bits("rax").first + 40}, rax), 5 + (std::uint64_t{1} << 40));
  const auto xmm0 = [] {
    double value = 1;
    asm volatile(".rept 1100\n nop\n .endr" : "+Yz"(value));
    return std::bit_cast<std::uint64_t>(value);
  };
  EXPECT_EQ(after({.bit = register_bits("xmm0").first + 63}, xmm0),
            std::bit_cast<std::uint64_t>(-1.0));
  const auto carry = [] {
    std::uint8_t value = 0;
    asm volatile("clc\n .rept 1100\n nop\n .endr\n setc %0" : "=r"(value) : : "cc");
    return std::uint64_t{value};
  };
  EXPECT_EQ(after({.bit = register_bits("flags").first}, carry), 1u);
}

TEST(Traps, FlipOneBitOfTheStackInUse) {
  const auto set_bits = [] {
    std::array<std::uint8_t, 4096> bytes{};
    asm volatile(".rept 1100\n nop\n .endr" : "+m"(bytes));
    std::uint64_t bits = 0;
    for (const std::uint8_t byte : bytes) bits += static_cast<std::uint64_t>(std::popcount(byte));
    return bits;
  };
  for (const double place : {0.1, 0.5, 0.9})
    EXPECT_EQ(after({.stack = true, .bit = 6, .place = place}, set_bits), 1u) << place;
}

// So that a run goes on while they differ.
TEST(Traps, ShowModesOfTheProcessorThatStay) {
  const auto modes = [](std::uint64_t bit) {
    return told_by_a_copy([&] {
             expect({.instruction = 500, .bit = bit});
             frame_work(many);
             return std::vector{processor_modes()};
           })
        .front();
  };
  const std::uint64_t mxcsr = register_bits("mxcsr").first, now = processor_modes();
  for (unsigned bit = 0; bit < 16; ++bit) {
    if (bit >= 7 && bit <= 12) continue;  // forbids an exception that may come
    EXPECT_EQ(modes(mxcsr + bit) != now, bit > 5) << bit;
  }
  EXPECT_EQ(modes(register_bits("rax").first), now);
}

TEST(Traps, AFlipHighInTheInstructionPointerIsARestart) {
  for (std::uint64_t bit = 40; bit < 64; ++bit) {
    const auto run = [&] {
      expect({.instruction = 500, .bit = register_bits("rip").first + bit});
      frame_work(many);
      return FlipResult{FlipOutcome::none};
    };
    EXPECT_EQ(in_a_copy(run, 5).outcome, FlipOutcome::restarted) << bit;
    EXPECT_TRUE(struck().happened);
  }
}

TEST(Traps, AWorkThatHangsIsARestart) {
  const auto run = [] {
    const auto hangs = [] {
      std::uint64_t once = 0;  // no register: the bit stays
      asm volatile(".rept 1100\n nop\n .endr\n 1: test %0, %0\n jnz 1b" : "+a"(once) : : "cc");
    };
    expect({.instruction = 500, .bit = register_bits("rax").first});
    frame_work(hangs);
    return FlipResult{FlipOutcome::none};
  };
  const FlipResult result = in_a_copy(run, 60);
  EXPECT_EQ(result.outcome, FlipOutcome::restarted);
  EXPECT_TRUE(result.hung);
}

#endif

// What came of them, from a copy of this process, which changes nothing here: it and the next copy
// have everything at the same addresses.
struct Told {
  FlipTally sum{};
  std::uint64_t all = 0;
  bool operator==(const Told&) const = default;
};
Told told(const Subject& subject, const FlipPlan& plan) {
  function_at(0);  // the table of symbols is read here, once
  void* const page =
      mmap(nullptr, sizeof(Told), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  auto* const shared = new (page) Told;
  const pid_t child = fork();
  if (child == 0) {
    FlipCounts counts;
    try {
      counts = subject.flip(plan);
    } catch (const std::exception& error) {
      std::fputs(error.what(), stderr);
      _exit(1);
    }
    for (const auto& [name, tally] : counts.parts)
      for (std::size_t i = 0; i < tally.size(); ++i) shared->sum[i] += tally[i];
    for (const auto* list : {&counts.parts, &counts.places}) {
      for (const auto& [name, tally] : *list) {
        const auto bytes = [](const auto& values) {
          return std::span(reinterpret_cast<const std::uint8_t*>(values.data()),
                           values.size() * sizeof values[0]);
        };
        shared->all = digest(digest(shared->all, bytes(name)), bytes(tally));
      }
    }
    _exit(0);
  }
  waitpid(child, nullptr, 0);
  const Told result = *shared;
  munmap(page, sizeof(Told));
  return result;
}

std::uint64_t of(const Told& all, FlipOutcome outcome) {
  return all.sum[static_cast<std::size_t>(outcome)];
}

// The fastest vehicle has everything that is common to them.
class FlippedThread : public testing::TestWithParam<const char*> {
 protected:
  void SetUp() override {
    if (all_registers().count == 0) GTEST_SKIP() << "only on amd64";
  }
  const Subject& subject = subjects().front();
};

TEST_P(FlippedThread, HasTheSameOutcomesForTheSameSeed) {
  const FlipPlan plan{.seed = 3, .flips = 40, .part = GetParam()};
  const Told once = told(subject, plan), again = told(subject, plan);
  EXPECT_EQ(once.sum, again.sum);
  EXPECT_EQ(once.all, again.all);
  EXPECT_NE(once.all, 0u);
  EXPECT_LT(of(once, FlipOutcome::none), plan.flips);
}

TEST_P(FlippedThread, HasTheOutcomeThatTheWholeRunHas) {
  FlipPlan plan{.seed = 2, .flips = 8, .part = GetParam()};
  const Told part = told(subject, plan);
  plan.to_the_end = true;
  const Told whole = told(subject, plan);
  EXPECT_EQ(part.sum, whole.sum);
  EXPECT_EQ(part.all, whole.all);
}

INSTANTIATE_TEST_SUITE_P(Parts, FlippedThread, testing::Values("registers", "mxcsr", "stack"),
                         [](const auto& part) { return std::string(part.param); });

TEST(FlippedInstructionPointer, IsARestartMostly) {
  if (all_registers().count == 0) GTEST_SKIP() << "only on amd64";
  const FlipPlan plan{.flips = 16, .part = "rip"};
  EXPECT_GT(of(told(subjects().front(), plan), FlipOutcome::restarted), plan.flips / 2);
}

class FlippedHeap : public testing::Test {
 protected:
  void SetUp() override {
    const auto all = subjects();
    const auto found = std::ranges::find(all, std::string_view("talaris"), &Subject::vehicle);
    if (found == all.end()) GTEST_SKIP() << "no vehicle with a heap";
    talaris_ = &*found;
  }
  // How many flips of this bit, each at another moment of the hop, change the orders.
  std::uint64_t change(const char* part, std::uint64_t bit) const {
    const Told all = told(*talaris_, {.flips = 6, .part = part, .bit = bit});
    return of(all, FlipOutcome::safe) + of(all, FlipOutcome::silent) + of(all, FlipOutcome::unsafe);
  }
  const Subject* talaris_ = nullptr;
};

TEST_F(FlippedHeap, HasTheSameOutcomesForTheSameSeed) {
  for (const char* part : {"heap", "sensor lines"}) {
    const FlipPlan plan{.flips = 12, .part = part};
    const Told once = told(*talaris_, plan), again = told(*talaris_, plan);
    EXPECT_EQ(once.all, again.all) << part;
    EXPECT_EQ(std::accumulate(once.sum.begin(), once.sum.end(), 0u), plan.flips) << part;
  }
}

// The driver multiplies all that the IMU says by it; the upper half of the fraction.
TEST_F(FlippedHeap, InAFactorOfTheImuChangesTheOrders) {
  const std::uint64_t bit = 8 * offsetof(talaris::LineStatus, force_unit_m_s2) + 51;
  EXPECT_GT(change("heap: imu status", bit), 0u);
}

// Where the bus thread writes the next sample, the first member of Boost's queue: with another bit
// samples come twice, or never.
TEST_F(FlippedHeap, InTheQueueOfTheImuChangesTheOrders) {
  EXPECT_GT(change("sensor lines: imu queue", 3), 0u);
}

}  // namespace
}  // namespace lss::campaign
