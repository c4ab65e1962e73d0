// Row ii, event path: from the packet of the IMU that begins a frame to the order of the valves on
// the CAN bus, through lssd of TALARIS as it ships, except that its offset is as short as its cycle
// allows; against a program that reads the same packets and sends a datagram, at the same time. The
// hopper stands still, and its nodes do not answer.

#include <fmt/format.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <list>

#include "daemon/runtime/clock.h"
#include "drivers/can/cannelloni.h"
#include "tests/bench/clients.h"
#include "tests/bench/realtime.h"
#include "tests/support/udp_peer.h"

namespace lss::bench {
namespace {

constexpr std::size_t kPacketBytes = 18;
constexpr int kPackets = 40;  // make a frame
constexpr TimeNs kPacketPeriod = 5 * kMillisecond;
// It counts from the first byte of a packet, which takes 1.875 ms on the line; with 2.0 ms on two
// virtual CPUs each tenth frame was late.
constexpr const char* kOffset_ms = "2.1";
constexpr std::uint32_t kValveOrder = 0x220;  // icd-talaris.md, section 5: one for each release
// Above the daemon: on one CPU the rest of the frame must not delay the time stamp of the order.
constexpr int kFarEndPriority = kActuatePriority + 1;
constexpr int kWarmUpFrames = 5;  // not counted

// The IMU and the CAN bus at the far end of the subject. Only orders of valves answer; of the echo
// every datagram.
class Hopper {
 public:
  Hopper(int frames, bool echoed) : frames_(frames), echoed_(echoed) {
    if (bus.port() == 0) throw NotHere("no UDP port on the loopback");
    latencies_us_.reserve(static_cast<std::size_t>(frames));
  }

  Terminal imu;
  testing_support::UdpPeer bus;

  void run(TimeNs begin_ns) noexcept {
    const int packets = (kWarmUpFrames + frames_) * kPackets;
    for (int i = 0; i < packets; ++i) {
      listen(begin_ns + i * kPacketPeriod);
      const auto bytes = packet(static_cast<std::uint8_t>(i));
      if ((i + 1) % kPackets == 0 && i >= kWarmUpFrames * kPackets) asked_ns_ = now_ns();
      [[maybe_unused]] const auto written = ::write(imu.fd(), bytes.data(), bytes.size());
    }
    listen(begin_ns + packets * kPacketPeriod);
  }
  // From just before the packet that begins a frame was written; without unanswered ones.
  const Samples& latencies_us() const { return latencies_us_; }

 private:
  // Level and still, but never the same twice: icd-talaris.md, section 2.
  static std::array<std::uint8_t, kPacketBytes> packet(std::uint8_t counter) {
    std::array<std::uint8_t, kPacketBytes> bytes{0x2A, counter};
    bytes[2] = counter & 1;
    bytes[8] = 0xE8;  // 1 g
    bytes[9] = 0x03;
    unsigned sum = 0;
    for (const std::uint8_t byte : bytes) sum += byte;
    bytes[kPacketBytes - 1] = static_cast<std::uint8_t>(0u - sum);
    return bytes;
  }
  void listen(TimeNs until_ns) noexcept {
    for (TimeNs now = now_ns(); now < until_ns; now = now_ns()) {
      pollfd readable{bus.fd(), POLLIN, 0};
      const timespec timeout = to_timespec(until_ns - now);
      if (::ppoll(&readable, 1, &timeout, nullptr) <= 0) continue;
      const TimeNs heard_ns = now_ns();
      std::array<std::uint8_t, kMaxDatagram> bytes;
      const auto got = ::recv(bus.fd(), bytes.data(), bytes.size(), MSG_DONTWAIT);
      if (got <= 0 || asked_ns_ == 0) continue;
      if (!echoed_ && !orders(std::span(bytes).first(static_cast<std::size_t>(got)))) continue;
      latencies_us_.push_back(static_cast<double>(heard_ns - asked_ns_) * 1e-3);
      asked_ns_ = 0;
    }
  }
  bool orders(std::span<const std::uint8_t> datagram) noexcept {
    bool found = false;
    reader_.begin(datagram);
    for (CanFrame frame; reader_.next(frame);) found |= frame.id == kValveOrder;
    return found;
  }

  int frames_;
  bool echoed_;
  CannelloniReader reader_;
  TimeNs asked_ns_ = 0;  // 0: nothing is asked
  Samples latencies_us_;
};

class HopperDaemon : public Service {
 public:
  HopperDaemon(int domain, const Hopper& hopper) {
    std::string text = edited(shipped_config("talaris"), "shared_memory", "false");
    text = edited(text, "offset_ms", kOffset_ms);
    for (const auto& [from, to] : {std::pair{std::string("sim:imu"), hopper.imu.name()},
                                   {"sim:altimeter", altimeter_.name()},
                                   {"udp://127.0.0.1:20000", hopper.bus.path()}}) {
      const std::size_t at = text.find('"' + from + '"');
      if (at == std::string::npos) throw std::runtime_error("config/talaris.toml has no " + from);
      text.replace(at + 1, from.size(), to);
    }
    const std::filesystem::path config = folder_ / "talaris.toml";
    std::ofstream(config) << text;
    start({program("lssd"), "--config", config, "--run-dir", folder_, "--domain",
           std::to_string(domain)},
          {});
  }

 private:
  Terminal altimeter_;  // silent
};

}  // namespace

Figures event_path(const Options& options, const std::string& how) {
  const int frames = options.count(300, 10);
  const int daemon_domain = domain(0);
  Folder folder;
  Hopper ours(frames, false), echoed(frames, true);
  std::optional<HopperDaemon> daemon;
  {
    const OnCpu subject(measured_cpu());
    daemon.emplace(daemon_domain, ours);
  }
  Process echo({program("bench-pty-echo"), echoed.imu.name(),
                std::to_string(kPacketBytes * kPackets), std::to_string(kBusPriority),
                std::to_string(measured_cpu()), std::to_string(echoed.bus.port())},
               folder / "echo.log");
  if (!eventually([&] { return echo.said("ready"); }))
    throw NotHere("the echo program does not run");
  const OnCpu clients(kHardwareCpu);
  const lss_Status before = status_after(daemon_domain, 1);
  {
    // In the middle between ours: they share a CPU.
    const TimeNs begin_ns = now_ns() + 20 * kMillisecond;
    const TimeNs between = kPackets / 2 * kPacketPeriod + kPacketPeriod / 2;
    std::list<Fifo> hardware;
    hardware.emplace_back("sensor", kFarEndPriority, kHardwareCpu, [&] { ours.run(begin_ns); });
    hardware.emplace_back("sensor", kFarEndPriority, kHardwareCpu,
                          [&] { echoed.run(begin_ns + between); });
  }
  const lss_Status after = status_after(daemon_domain, before.frame_index + 1);

  const Rounds rounds = side_by_side(ours.latencies_us(), echoed.latencies_us());
  const std::string what = "byte to byte, event path" + how;
  Figures figures{
      held_back(
          noted(figure("ii", what + ", p50", "us", rounds, median, 1.3),
                fmt::format("lssd of TALARIS, offset {} ms from the first byte of a packet of "
                            "1.875 ms, {} frames, {} late; reference: reads, sends a datagram",
                            kOffset_ms, frames, after.overruns - before.overruns)),
          "it waits for the offset"),
      figure("ii", what + ", p99", "us", rounds, p99, kNone)};
  if (options.maxima) figures.push_back(most("ii", what + ", max", "us", rounds));
  return figures;
}

}  // namespace lss::bench
