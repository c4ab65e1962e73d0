// Row ii, D.I.A.N.A. Ardito: SYNC, which asks all nodes to measure, leaves before each frame
// boundary by the configured lead. The deviation at reception, through the real bus thread and
// master on a UDP port, against a raw program that sleeps to the same times and sends a datagram,
// at the same time.

#include <arpa/inet.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <list>
#include <stdexcept>

#include "daemon/runtime/frame_engine.h"
#include "daemon/vehicles/ardito/vehicle.h"
#include "drivers/can/cannelloni.h"
#include "tests/bench/programs.h"
#include "tests/bench/realtime.h"
#include "tests/support/udp_peer.h"

namespace lss::bench {
namespace {

using ardito::RoverOrders;

constexpr TimeNs kPeriod = 100 * kMillisecond, kOffset = 10 * kMillisecond;
constexpr int kWarmUpFrames = 20;  // the master begins SYNC at any time and shifts it to its place
constexpr std::uint32_t kSyncId = 0x080;
// Above the bus thread: on one CPU what that does after SYNC must not delay the time stamp.
constexpr int kFarEndPriority = kActuatePriority + 1;

// The far end of a CAN bus over UDP: reception time of SYNC.
class FarEnd : public testing_support::UdpPeer {
 public:
  FarEnd() {
    if (port() == 0) throw NotHere("no UDP port on the loopback");
  }

  void reserve(std::size_t count) { heard_ns_.reserve(count); }
  void run(const std::atomic<bool>& stop) noexcept {
    while (!stop) {
      pollfd readable{fd(), POLLIN, 0};
      if (::poll(&readable, 1, 100) <= 0) continue;
      const TimeNs now = now_ns();
      std::array<std::uint8_t, kMaxDatagram> bytes;
      const auto got = ::recv(fd(), bytes.data(), bytes.size(), 0);
      if (got <= 0) continue;
      reader_.begin(std::span(bytes).first(static_cast<std::size_t>(got)));
      for (CanFrame frame; reader_.next(frame);) {
        if (frame.id == kSyncId && heard_ns_.size() < heard_ns_.capacity())
          heard_ns_.push_back(now);
      }
    }
  }
  // How late after begin + k * period, the first ones left out.
  Samples late_us(TimeNs begin_ns) const {
    Samples late;
    for (std::size_t i = kWarmUpFrames; i < heard_ns_.size(); ++i) {
      TimeNs away = (heard_ns_[i] - begin_ns) % kPeriod;
      if (away > kPeriod / 2) away -= kPeriod;
      late.push_back(static_cast<double>(away) * 1e-3);
    }
    return late;
  }

 private:
  CannelloniReader reader_;
  std::vector<TimeNs> heard_ns_;
};

// Sleeps and sends, nothing else.
void send_raw(std::uint16_t port, TimeNs begin_ns, const std::atomic<bool>& stop) {
  const int fd = ::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(port);
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  CannelloniWriter writer;
  for (TimeNs due = begin_ns; !stop; due += kPeriod) {
    sleep_until(due);
    writer.add({.id = kSyncId});
    const auto bytes = writer.take();
    [[maybe_unused]] const auto sent =
        ::sendto(fd, bytes.data(), bytes.size(), 0, reinterpret_cast<const sockaddr*>(&address),
                 sizeof address);
  }
  ::close(fd);
}

double size(double us) { return std::abs(us); }

}  // namespace

Figures sync_deviation(const Options& options) {
  const int frames = options.count(300, 20);
  const ardito::RoverBusParameters parameters;
  FarEnd ours, raw;
  for (FarEnd* far_end : {&ours, &raw})
    far_end->reserve(static_cast<std::size_t>(kWarmUpFrames + frames));
  ardito::RoverCanBus bus(parameters, fmt::format("udp://127.0.0.1:{}", ours.port()),
                          canopen::filters());
  const TimeNs begin_ns = now_ns() + 2 * kPeriod;
  ClockFrames grid(FrameClock(begin_ns, kPeriod, kOffset));
  FrameEngine<ClockFrames, RoverOrders> engine(grid, {.period_ns = kPeriod, .offset_ns = kOffset});
  std::atomic<bool> stop{false};
  {
    std::list<Fifo> threads;
    const auto begin = [&](const char* name, int priority, int cpu, std::function<void()> body) {
      threads.emplace_back(name, priority, cpu, std::move(body));
    };
    begin("far end", kFarEndPriority, kHardwareCpu, [&] { ours.run(stop); });
    begin("far end", kFarEndPriority, kHardwareCpu, [&] { raw.run(stop); });
    begin("bus", kBusPriority, measured_cpu(), [&] { bus.run(); });
    begin("actuate", kActuatePriority, measured_cpu(), [&] {
      engine.actuate([&](const RoverOrders& orders) noexcept { bus.release(orders); });
    });
    begin("frame", kFramePriority, measured_cpu(), [&] {
      const auto orders = [](const Boundary& boundary, const Released&, TimingPoints&) noexcept {
        return RoverOrders{{.issued_ns = boundary.time_ns,
                            .serial = 1,
                            .next_frame_ns = boundary.time_ns + kPeriod}};
      };
      engine.frame(orders, [](const TimingPoints&) noexcept {});
    });
    // In the middle between ours: they share a CPU.
    begin("raw", kBusPriority, measured_cpu(),
          [&] { send_raw(raw.port(), begin_ns + kPeriod / 2, stop); });
    sleep_until(begin_ns + (kWarmUpFrames + frames + 1) * kPeriod);
    stop = true;
    engine.stop();
    bus.stop();
  }
  Samples late_us = ours.late_us(begin_ns - parameters.sync_lead_ns);
  const Samples raw_us = raw.late_us(begin_ns + kPeriod / 2);
  if (late_us.size() < static_cast<std::size_t>(frames) * 9 / 10)
    throw std::runtime_error("SYNC was not heard in every frame");
  std::ranges::transform(late_us, late_us.begin(), size);
  const Rounds rounds = side_by_side(late_us, raw_us);
  return {
      noted(figure("ii", "SYNC - (T_k - lead), p50", "us", rounds, median, 1.3),
            fmt::format("Ardito, {} frames of 100 ms, lead {} ms, UDP; reference: a raw program "
                        "that sleeps and sends",
                        frames, parameters.sync_lead_ns / kMillisecond)),
      figure("ii", "SYNC - (T_k - lead), p99", "us", rounds, p99, kNone)};
}

}  // namespace lss::bench
