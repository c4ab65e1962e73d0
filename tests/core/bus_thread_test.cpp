// What the bus thread reports besides its line's state: samples that nobody takes, damaged memory.

#include "daemon/runtime/bus_thread.h"

#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <cstdint>
#include <cstring>
#include <functional>
#include <span>
#include <thread>

namespace lss {
namespace {

struct Tick {
  TimeNs time_ns = 0;
};

// Has a sample in each turn.
struct TickDriver {
  void restart(TimeNs) noexcept {}
  std::size_t take(std::span<Tick> out) noexcept {
    out.front() = {++time_ns};
    return 1;
  }
  TimeNs time_ns = 0;
};

constexpr int kParameters = 3, kStatus = 5, kOrders = 7;
constexpr std::uint64_t kMark = 0x1122'3344'5566'7788;

// Keeps what it is given.
struct MarkedDriver {
  void restart(TimeNs) noexcept {}
  void begin_again(int parameters, int said, int last, TimeNs) noexcept {
    begun = {parameters, said, last};
  }
  void release(int orders, TimeNs) noexcept { released = orders; }
  std::size_t take(std::span<Tick>) noexcept { return 0; }
  std::uint64_t mark = kMark;
  int released = 0;
  std::array<int, 3> begun{};
};

template <class TheDriver, class TheOrders>
class FakeLine {
 public:
  using Driver = TheDriver;
  using Orders = TheOrders;
  using Sample = Tick;
  struct Report {
    std::uint64_t dropped = 0;
    int status = 0;
    TimeNs time_ns = 0;
    bool open = false, was_open = false, all_stop_pending = false;
  };
  enum class Status : std::uint8_t { ok };
  static constexpr std::size_t kMaxSamples = 8;

  std::function<void()> waits{};  // called when the thread waits

  Driver& driver() noexcept { return driver_; }
  int parameters() const noexcept { return kParameters; }
  Status open() noexcept {
    open_ = true;
    return Status::ok;
  }
  void begin() noexcept {}
  void close() noexcept { open_ = false; }
  bool is_open() const noexcept { return open_; }
  int fd() const noexcept { return -1; }
  short events() const noexcept { return 0; }
  TimeNs next_wake() const noexcept {
    if (waits) waits();
    return 0;
  }
  bool coming() noexcept { return false; }
  bool serve(bool, TimeNs) noexcept { return true; }
  void describe(Report& report, std::uint64_t dropped) noexcept {
    report.dropped = dropped;
    report.status = kStatus;
  }

 private:
  Driver driver_;
  bool open_ = false;
};

TEST(BusThread, ReportsHowManySamplesFoundNoRoom) {
  BusThread<FakeLine<TickDriver, NoOrders>> bus;
  std::thread thread([&bus] { bus.run(); });
  while (bus.report().dropped == 0 && bus.turns() < 10'000'000) std::this_thread::yield();
  bus.stop();
  thread.join();
  EXPECT_GT(bus.report().dropped, 0u);
  Tick oldest;
  EXPECT_TRUE(bus.pop(oldest, INT64_MAX));
  EXPECT_EQ(oldest.time_ns, 1) << "the newer ones are dropped";
}

// Both copies are damaged once, while the thread waits, by the thread itself.
TEST(BusThread, ReportsDamagedMemoryOnceAndGivesTheDriverWhatIsNotDamaged) {
  BusThread<FakeLine<MarkedDriver, int>> bus;
  bus.release(kOrders);
  std::size_t copies = 0;
  std::atomic<bool> damaged{false};
  bus.line().waits = [&] {
    if (damaged || bus.line().driver().released == 0) return;
    const auto memory = bytes_of(bus);
    for (std::size_t at = 0; at + sizeof kMark <= memory.size(); at += sizeof kMark) {
      if (std::memcmp(&memory[at], &kMark, sizeof kMark) != 0) continue;
      memory[at] = static_cast<std::uint8_t>(++copies);
    }
    damaged = true;
  };
  std::thread thread([&bus] { bus.run(); });
  while (!damaged) std::this_thread::yield();
  bool lost = false;
  while (!lost && bus.turns() < 10'000'000) lost = bus.take_memory_lost();
  bus.stop();
  thread.join();
  EXPECT_EQ(copies, 2u);
  EXPECT_TRUE(lost);
  EXPECT_FALSE(bus.take_memory_lost());
  EXPECT_EQ(bus.line().driver().begun, (std::array{kParameters, kStatus, kOrders}));
}

}  // namespace
}  // namespace lss
