#pragma once

// The hardware around the wiring of TALARIS, as far as its bytes go: an IMU and an altimeter on
// pseudo-terminals behind links, and the far end of a CAN bus in datagrams; and the three types of
// threads of the daemon around it. Every wait is bounded.

#include <arpa/inet.h>
#include <fcntl.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <termios.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "daemon/runtime/clock.h"
#include "daemon/runtime/frame_engine.h"
#include "daemon/vehicles/talaris/buses.h"
#include "drivers/can/cannelloni.h"
#include "tests/support/temp_folder.h"

namespace lss::talaris::testing_support {

inline constexpr auto kPatience = std::chrono::seconds(30);

// The far end of a serial line; plugged in under a link, and pulled out.
class Device {
 public:
  explicit Device(std::filesystem::path link) : link_(std::move(link)) { plug_in(); }
  ~Device() { pull_out(); }
  Device(const Device&) = delete;
  Device& operator=(const Device&) = delete;

  void plug_in() {
    fd_ = ::posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
    ASSERT_GE(fd_, 0);
    ASSERT_EQ(::grantpt(fd_) | ::unlockpt(fd_), 0);
    kept_ = ::open(::ptsname(fd_), O_RDWR | O_NOCTTY | O_CLOEXEC);  // else each close hangs it up
    std::filesystem::remove(link_);
    std::filesystem::create_symlink(::ptsname(fd_), link_);
  }
  void pull_out() {
    std::filesystem::remove(link_);
    ::close(std::exchange(kept_, -1));
    ::close(std::exchange(fd_, -1));
  }
  // The other end is open, for it says something.
  void expect_word() {
    pollfd readable{fd_, POLLIN, 0};
    constexpr int kPatience_ms = std::chrono::milliseconds(kPatience).count();
    ASSERT_EQ(::poll(&readable, 1, kPatience_ms), 1);
    std::array<char, 64> word;
    ASSERT_GT(::read(fd_, word.data(), word.size()), 0);
  }
  void write(const void* bytes, std::size_t size) {
    ASSERT_EQ(::write(fd_, bytes, size), static_cast<ssize_t>(size));
  }

 private:
  std::filesystem::path link_;
  int fd_ = -1, kept_ = -1;
};

// A LandMark 30 that stands level and still.
class LandMark {
 public:
  explicit LandMark(const std::filesystem::path& link) : device(link) {}

  Device device;

  // One packet every 5 ms, as the sensor sends them; those in `lost` are counted and not sent.
  void send(int packets, int lost_from = -1, int lost = 0) {
    next_ns_ = std::max(next_ns_, now_ns());
    for (int i = 0; i < packets; ++i, ++counter_) {
      sleep_until(next_ns_);
      next_ns_ += 5 * kMillisecond;
      if (i >= lost_from && i < lost_from + lost) continue;
      std::array<std::uint8_t, 18> bytes{0x2A, counter_};
      bytes[8] = 0xE8;  // 1 g
      bytes[9] = 0x03;
      unsigned sum = 0;
      for (const std::uint8_t byte : bytes) sum += byte;
      bytes[17] = static_cast<std::uint8_t>(0u - sum);
      device.write(bytes.data(), bytes.size());
    }
  }

 private:
  std::uint8_t counter_ = 0;
  TimeNs next_ns_ = 0;
};

// Receives the frames of the CAN bus.
class CanListener {
 public:
  struct Heard {
    TimeNs time_ns = 0;
    CanFrame frame{};
  };

  CanListener() : fd_(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)) {
    sockaddr_in own{};
    own.sin_family = AF_INET;
    own.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof own;
    EXPECT_EQ(::bind(fd_, reinterpret_cast<sockaddr*>(&own), size), 0);
    EXPECT_EQ(::getsockname(fd_, reinterpret_cast<sockaddr*>(&own), &size), 0);
    port_ = ntohs(own.sin_port);
    thread_ = std::thread([this] { run(); });
  }
  ~CanListener() {
    stop_ = true;
    thread_.join();
    ::close(fd_);
  }
  CanListener(const CanListener&) = delete;
  CanListener& operator=(const CanListener&) = delete;

  std::string path() const { return "udp://127.0.0.1:" + std::to_string(port_); }

  // The first frame from the `from`-th on that is so; its number, or nothing for a long time.
  template <class Is>
  std::optional<std::size_t> wait_for(Is&& is, std::size_t from = 0,
                                      std::chrono::nanoseconds patience = kPatience) {
    std::unique_lock lock(mutex_);
    std::size_t at = from;
    const bool found = changed_.wait_for(lock, patience, [&] {
      while (at < heard_.size() && !is(heard_[at].frame)) ++at;
      return at < heard_.size();
    });
    return found ? std::optional(at) : std::nullopt;
  }
  std::vector<Heard> heard() {
    const std::lock_guard lock(mutex_);
    return heard_;
  }
  std::size_t count() { return heard().size(); }

 private:
  void run() {
    std::array<std::uint8_t, 2048> bytes;
    while (!stop_) {
      pollfd readable{fd_, POLLIN, 0};
      if (::poll(&readable, 1, 20) <= 0) continue;
      const ssize_t got = ::recv(fd_, bytes.data(), bytes.size(), 0);
      const TimeNs now = now_ns();
      if (got < 0) continue;
      const std::lock_guard lock(mutex_);
      reader_.begin(std::span(bytes).first(static_cast<std::size_t>(got)));
      for (CanFrame frame; reader_.next(frame);) heard_.push_back({now, frame});
      changed_.notify_all();
    }
  }

  int fd_;
  int port_ = 0;
  CannelloniReader reader_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<Heard> heard_;
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

inline bool tells_valves(const CanFrame& frame) { return frame.id == 0x220; }
inline bool tells_fans(const CanFrame& frame) { return frame.id == 0x221; }

// Frames of 4 packets: 20 ms.
inline config::Config configuration(const lss::testing_support::TempFolder& folder,
                                    const CanListener& can) {
  config::Config config;
  config.period_ns = 20 * kMillisecond;
  config.offset_ns = 5 * kMillisecond;
  config.ports = {{.name = "imu", .path = folder / "imu"},
                  {.name = "altimeter", .path = folder / "altimeter", .baud = 9600},
                  {.name = "can", .path = can.path()}};
  return config;
}

// Input and orders of a frame.
struct FrameSeen {
  Boundary boundary{};
  std::vector<TalarisSample> samples{};
  BusReport report{};
  Released released{};
};

class Rig {
 public:
  // Called on the frame thread.
  using Compute = std::function<void(const FrameSeen&, TalarisOrders&)>;

  lss::testing_support::TempFolder folder;
  CanListener can;
  LandMark imu{folder / "imu"};
  Device altimeter{folder / "altimeter"};
  config::Config config = configuration(folder, can);
  BusesParameters parameters{};

  Rig() {
    parameters.landmark.packets_per_frame = 4;
    parameters.landmark.configure = true;  // so that the test knows when its line is open
    parameters.grace_ns = 1000 * kSecond;  // no delay of the machine makes a frame by the clock
  }
  ~Rig() { stop(); }
  Rig(const Rig&) = delete;
  Rig& operator=(const Rig&) = delete;

  void start(Compute compute) {
    compute_ = std::move(compute);
    buses = std::make_unique<Buses>(config, parameters);
    ASSERT_EQ(buses->wrong_configuration(), "");
    ASSERT_TRUE(buses->probe());
    engine_ = std::make_unique<Engine>(buses->frames(),
                                       FrameParameters{.period_ns = config.period_ns,
                                                       .offset_ns = config.offset_ns,
                                                       .actuate_spin_ns = 100 * kMicrosecond});
    buses->frames().start(now_ns() - config.period_ns);
    for (auto& [name, body] : buses->bodies()) threads_.emplace_back(std::move(body));
    imu.device.expect_word();
    altimeter.expect_word();
    threads_.emplace_back([this] {
      engine_->actuate([this](const TalarisOrders& orders,
                              const Boundary& boundary) { buses->release(orders, boundary); },
                       buses->actuation());
    });
    threads_.emplace_back([this] {
      engine_->frame([this](const Boundary& boundary, const Released& released,
                            TimingPoints&) { return turn(boundary, released); },
                     [](const TimingPoints&) {});
    });
  }
  void stop() {
    if (threads_.empty()) return;
    engine_->stop();
    buses->stop();
    for (std::thread& thread : threads_) thread.join();
    threads_.clear();
  }

  // Until a frame was so; false: none for a long time.
  template <class Is>
  bool wait_for_frame(Is&& is) {
    std::unique_lock lock(mutex_);
    std::size_t at = 0;
    return changed_.wait_for(lock, kPatience, [&] {
      while (at < seen_.size() && !is(seen_[at])) ++at;
      return at < seen_.size();
    });
  }
  // Packets until this number of frames was seen: a thread that waits for the CPU joins several.
  bool send_for_frames(std::size_t count) {
    return send_until([&] { return seen().size() >= count; });
  }
  template <class Condition>
  bool send_until(Condition&& condition) {
    const auto end = std::chrono::steady_clock::now() + kPatience;
    while (!condition()) {
      if (std::chrono::steady_clock::now() > end) return false;
      imu.send(4);
    }
    return true;
  }
  std::vector<FrameSeen> seen() {
    const std::lock_guard lock(mutex_);
    return seen_;
  }

  std::unique_ptr<Buses> buses;

 private:
  using Engine = FrameEngine<SensorFrames, TalarisOrders>;

  TalarisOrders turn(const Boundary& boundary, const Released& released) {
    FrameSeen seen{.boundary = boundary, .released = released};
    std::array<TalarisSample, 64> samples;
    const std::size_t count = buses->collect(boundary.time_ns, samples, seen.report);
    seen.samples.assign(samples.begin(), samples.begin() + static_cast<std::ptrdiff_t>(count));
    TalarisOrders orders{.issued_ns = now_ns(), .boundary_ns = boundary.time_ns};
    orders.release_ns = boundary.time_ns + config.offset_ns;
    compute_(seen, orders);
    const std::lock_guard lock(mutex_);
    seen_.push_back(std::move(seen));
    changed_.notify_all();
    return orders;
  }

  Compute compute_;
  std::unique_ptr<Engine> engine_;
  std::vector<std::thread> threads_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<FrameSeen> seen_;
};

}  // namespace lss::talaris::testing_support
