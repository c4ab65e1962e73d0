// Samples that nobody takes are counted in the report of the bus thread.

#include "daemon/runtime/bus_thread.h"

#include <gtest/gtest.h>

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

class TickLine {
 public:
  using Driver = TickDriver;
  using Orders = NoOrders;
  using Sample = Tick;
  struct Report {
    std::uint64_t dropped = 0;
    TimeNs time_ns = 0;
    bool open = false, was_open = false, all_stop_pending = false;
  };
  enum class Status : std::uint8_t { ok };
  static constexpr std::size_t kMaxSamples = 8;

  Driver& driver() noexcept { return driver_; }
  Status open() noexcept {
    open_ = true;
    return Status::ok;
  }
  void begin() noexcept {}
  void close() noexcept { open_ = false; }
  bool is_open() const noexcept { return open_; }
  int fd() const noexcept { return -1; }
  short events() const noexcept { return 0; }
  TimeNs next_wake() const noexcept { return 0; }
  bool coming() noexcept { return false; }
  bool serve(bool, TimeNs) noexcept { return true; }
  void describe(Report& report, std::uint64_t dropped) noexcept { report.dropped = dropped; }

 private:
  Driver driver_;
  bool open_ = false;
};

TEST(BusThread, ReportsHowManySamplesFoundNoRoom) {
  BusThread<TickLine> bus;
  std::thread thread([&bus] { bus.run(); });
  while (bus.report().dropped == 0 && bus.turns() < 10'000'000) std::this_thread::yield();
  bus.stop();
  thread.join();
  EXPECT_GT(bus.report().dropped, 0u);
  Tick oldest;
  EXPECT_TRUE(bus.pop(oldest, INT64_MAX));
  EXPECT_EQ(oldest.time_ns, 1) << "the newer ones are dropped";
}

}  // namespace
}  // namespace lss
