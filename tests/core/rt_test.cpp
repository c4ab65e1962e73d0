#include <gtest/gtest.h>
#include <sched.h>
#include <sys/mman.h>
#include <unistd.h>

#include <atomic>

#include "daemon/runtime/thread.h"

namespace lss::rt {
namespace {

TEST(Thread, RunsWithThePolicyThatWasAskedForWhenItIsGranted) {
  std::atomic<int> policy{-1}, priority{-1};
  Thread thread;
  const auto ok = thread.start({.name = "frame", .priority = 12}, false, [&] {
    sched_param p{};
    int got = 0;
    pthread_getschedparam(pthread_self(), &got, &p);
    policy = got;
    priority = p.sched_priority;
  });
  thread.join();
  if (ok) {
    EXPECT_EQ(policy, SCHED_FIFO);
    EXPECT_EQ(priority, 12);
    EXPECT_TRUE(thread.status().granted);
  } else {  // not permitted here: it must run all the same, and say so
    EXPECT_EQ(policy, SCHED_OTHER);
    EXPECT_NE(ok.error().find("LimitRTPRIO"), std::string::npos);
    EXPECT_FALSE(thread.status().granted);
  }
}

TEST(Thread, WithEnforceAThreadWhoseCpuIsRefusedDoesNotRunAndNamesIt) {
  std::atomic<bool> ran{false};
  Thread thread;
  const auto ok = thread.start({.name = "frame", .cpu = 1000}, true, [&] { ran = true; });
  thread.join();
  ASSERT_FALSE(ok);
  EXPECT_NE(ok.error().find("CPU 1000"), std::string::npos);
  EXPECT_FALSE(ran);
}

TEST(Thread, CountsThePageFaultsOfItsBody) {
  Thread thread;
  std::atomic<int> stage{0};
  ASSERT_TRUE(thread.start({.name = "toucher"}, false, [&] {
    while (stage != 1) sched_yield();
    constexpr std::size_t kPages = 32;
    const auto page = static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));
    void* memory =
        ::mmap(nullptr, kPages * page, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    for (std::size_t i = 0; i < kPages; ++i) static_cast<volatile char*>(memory)[i * page] = 1;
    ::munmap(memory, kPages * page);
    stage = 2;
    while (stage != 3) sched_yield();
  }));
  thread.mark_ready();
  stage = 1;
  while (stage != 2) sched_yield();
  EXPECT_GE(thread.status().page_faults, 32u);
  stage = 3;
  thread.join();
}

}  // namespace
}  // namespace lss::rt
