// Row vi: the cycle of D.I.A.N.A. Ardito on a CAN interface of the kernel: SYNC, all measurements
// in, all orders out, through the real bus thread, master and frame engine, against a raw program
// that sleeps, writes and reads, on the same interface, one after the other. Both are led by the
// clock, so the figure is what the cycle takes besides waiting: how late SYNC is, until all nodes
// got rid of their measurements, and how late the last order is. All of it is seen by the nodes.
// On one CPU sending a measurement includes that the master takes it.

#include <fmt/format.h>
#include <linux/can.h>
#include <linux/can/raw.h>
#include <net/if.h>
#include <net/if_arp.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <filesystem>
#include <fstream>
#include <list>

#include "daemon/runtime/frame_engine.h"
#include "daemon/vehicles/ardito/vehicle.h"
#include "drivers/can/socket_can.h"
#include "tests/ardito/drivers/can_node.h"
#include "tests/bench/programs.h"
#include "tests/bench/realtime.h"

namespace lss::bench {
namespace {

using ardito::RoverOrders;
using testing_support::CanNode;

constexpr TimeNs kPeriod = 100 * kMillisecond, kOffset = 10 * kMillisecond;
constexpr TimeNs kLead = canopen::DriveBusTimes{}.sync_lead_ns;
constexpr int kWarmUpCycles = 5;
constexpr std::uint32_t kSyncId = 0x080;
constexpr std::size_t kMeasurements = 23;
constexpr std::array<std::uint32_t, 11> kOrders = {0x201, 0x202, 0x203, 0x204, 0x205, 0x206,
                                                   0x211, 0x212, 0x215, 0x216, 0x220};
constexpr std::array<std::uint32_t, ardito::kNodes> kNodeIds = {0x01, 0x02, 0x03, 0x04, 0x05, 0x06,
                                                                0x11, 0x12, 0x15, 0x16, 0x20, 0x21};

// The first CAN interface that is up.
std::string can_interface() {
  std::error_code none;
  for (const auto& entry : std::filesystem::directory_iterator("/sys/class/net", none)) {
    unsigned type = 0, flags = 0;
    std::ifstream(entry.path() / "type") >> type;
    std::ifstream(entry.path() / "flags") >> std::hex >> flags;
    if (type == ARPHRD_CAN && (flags & IFF_UP) != 0) return entry.path().filename();
  }
  throw NotHere("no CAN interface is up: lss-bench --machine has one");
}

CanFrame frame(std::uint32_t id, std::uint8_t size, std::uint8_t low = 0, std::uint8_t high = 0) {
  CanFrame made{.id = id, .size = size};
  made.data[0] = low;
  made.data[1] = high;
  return made;
}

// Messages of the nodes after a SYNC while drives follow their orders: docs/icd-ardito.md section
// 5.
std::vector<CanFrame> measurements() {
  std::vector<CanFrame> frames;
  for (const std::uint32_t id : kNodeIds) {
    const bool wheel = id <= 0x06, steering = !wheel && id < 0x20;
    if (wheel || steering) {
      frames.push_back(frame(0x180 + id, 8, 0x37, wheel ? 0x02 : 0x12));
      frames.push_back(frame(0x280 + id, wheel ? 8 : 4));
    } else if (id == 0x20) {
      frames.push_back(frame(0x180 + id, 1, 0x02));
      frames.push_back(frame(0x280 + id, 6));
    } else {
      frames.push_back(frame(0x180 + id, 8));
    }
  }
  return frames;
}

// The result of one of both, as received by the nodes.
struct Seen {
  Samples cycle_us, sync_us, orders_us;
  int missed = 0;  // cycles without SYNC or without all orders
};

// The twelve nodes. While they boot they are those of the tests; then, for both alike, they answer
// SYNC with frames that lie ready.
class Nodes {
 public:
  explicit Nodes(const std::string& interface)
      : fd_(::socket(PF_CAN, SOCK_RAW | SOCK_CLOEXEC | SOCK_NONBLOCK, CAN_RAW)) {
    const sockaddr_can address{.can_family = AF_CAN,
                               .can_ifindex = static_cast<int>(::if_nametoindex(interface.c_str())),
                               .can_addr = {}};
    if (fd_ < 0 || ::bind(fd_, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0)
      throw NotHere(interface + " cannot be used");
  }
  ~Nodes() { ::close(fd_); }
  Nodes(const Nodes&) = delete;
  Nodes& operator=(const Nodes&) = delete;

  // Until a master configured and enabled all of them; false: not within the limit.
  bool boot(TimeNs limit_ns) {
    std::vector<CanNode> nodes;
    for (std::size_t i = 0; i < kNodeIds.size(); ++i) {
      const auto kind = i < ardito::kFirstSteering ? CanNode::Kind::wheel
                        : i < ardito::kIo          ? CanNode::Kind::steering
                        : i == ardito::kIo         ? CanNode::Kind::io
                                                   : CanNode::Kind::imu;
      nodes.emplace_back(kind, static_cast<std::uint8_t>(kNodeIds[i])).reboot(now_ns());
    }
    const auto done = [](const CanNode& node) {
      return node.nmt == CanNode::Nmt::operational &&
             (node.kind == CanNode::Kind::io || node.kind == CanNode::Kind::imu ||
              node.drive == CanNode::Drive::enabled);
    };
    for (TimeNs now = now_ns(), end = now + limit_ns; now < end; now = now_ns()) {
      CanFrame in;
      if (next(in, now + kMillisecond)) {
        for (CanNode& node : nodes) node.receive(in, now_ns());
      }
      for (CanNode& node : nodes) {
        node.run(now_ns());
        for (const CanFrame& out : node.take()) send(out);
      }
      if (std::ranges::all_of(nodes, done)) return true;
    }
    return false;
  }

  // Of a master whose frames begin at begin_ns + k * period.
  Seen watch(TimeNs begin_ns, int cycles) {
    const std::vector<CanFrame> answer = measurements();
    Seen seen;
    for (int k = -kWarmUpCycles; k < cycles; ++k) {
      const TimeNs boundary_ns = begin_ns + (k + kWarmUpCycles) * kPeriod;
      const TimeNs end_ns = boundary_ns + kPeriod - 2 * kLead;
      const TimeNs sync_ns = wait_for_sync(boundary_ns - kPeriod / 2, end_ns);
      if (sync_ns != 0) {
        for (const CanFrame& out : answer) send(out);
      }
      const TimeNs sent_ns = now_ns();
      const TimeNs ordered_ns = wait_for_orders(end_ns);
      live();
      if (k < 0) continue;
      if (sync_ns == 0 || ordered_ns == 0) {
        ++seen.missed;
        continue;
      }
      const TimeNs late_ns = sync_ns - (boundary_ns - kLead);
      const TimeNs orders_ns = ordered_ns - (boundary_ns + kOffset);
      seen.sync_us.push_back(static_cast<double>(late_ns) * 1e-3);
      seen.orders_us.push_back(static_cast<double>(orders_ns) * 1e-3);
      seen.cycle_us.push_back(static_cast<double>(late_ns + sent_ns - sync_ns + orders_ns) * 1e-3);
    }
    return seen;
  }

 private:
  void send(const CanFrame& out) {
    const can_frame raw = to_kernel(out);
    [[maybe_unused]] const auto written = ::write(fd_, &raw, sizeof raw);
  }
  bool next(CanFrame& in, TimeNs until_ns) {
    can_frame raw;
    while (::read(fd_, &raw, sizeof raw) != static_cast<ssize_t>(sizeof raw)) {
      const TimeNs now = now_ns();
      if (now >= until_ns) return false;
      pollfd readable{fd_, POLLIN, 0};
      const timespec timeout = to_timespec(until_ns - now);
      ::ppoll(&readable, 1, &timeout, nullptr);
    }
    in = {.time_ns = now_ns(), .id = raw.can_id, .size = raw.can_dlc};
    std::copy_n(raw.data, in.data.size(), in.data.begin());
    return true;
  }
  // Nodes run on until the time of the frame.
  TimeNs wait_for_sync(TimeNs begin_ns, TimeNs end_ns) {
    for (CanFrame in; next(in, end_ns);) {
      if (in.id != kSyncId) continue;
      if (in.time_ns >= begin_ns) return in.time_ns;
      live();
    }
    return 0;
  }
  void live() {
    for (const std::uint32_t id : kNodeIds) send(frame(0x700 + id, 1, 0x05));
  }
  // Reception time of the last one, one of each.
  TimeNs wait_for_orders(TimeNs end_ns) {
    unsigned heard = 0;
    for (CanFrame in; next(in, end_ns);) {
      const auto* at = std::ranges::find(kOrders, in.id);
      if (at == kOrders.end()) continue;
      heard |= 1u << (at - kOrders.begin());
      if (heard == (1u << kOrders.size()) - 1) return in.time_ns;
    }
    return 0;
  }

  int fd_;
};

struct Misses {
  int ours = 0, raw = 0, measurements = 0;
};

// The daemon's threads with a master that lets all wheels stand under power.
Seen with_ours(const std::string& interface, int cycles, Misses& missed) {
  Nodes nodes(interface);
  ardito::RoverCanBus bus(ardito::RoverBusParameters{}, interface, canopen::filters());
  TimeNs begin_ns = now_ns() + 2 * kPeriod;
  ClockFrames grid(FrameClock(begin_ns, kPeriod, kOffset));
  FrameEngine<ClockFrames, RoverOrders> engine(grid, {.period_ns = kPeriod, .offset_ns = kOffset});
  std::atomic<bool> counts{false};
  Seen seen;
  bool booted = false;
  {
    std::list<Fifo> threads;
    threads.emplace_back("nodes", kHardwarePriority, kHardwareCpu, [&] {
      booted = nodes.boot(20 * kSecond);
      if (booted) {
        begin_ns = begin_ns + ((now_ns() - begin_ns) / kPeriod + 3) * kPeriod;
        counts = true;
        seen = nodes.watch(begin_ns, cycles);
        counts = false;
      }
      engine.stop();
      bus.stop();
    });
    threads.emplace_back("bus", kBusPriority, measured_cpu(), [&] { bus.run(); });
    threads.emplace_back("actuate", kActuatePriority, measured_cpu(), [&] {
      engine.actuate([&](const RoverOrders& orders) noexcept { bus.release(orders); });
    });
    threads.emplace_back("frame", kFramePriority, measured_cpu(), [&] {
      const auto orders = [&](const Boundary& boundary, const Released&, TimingPoints&) noexcept {
        std::size_t in_time = 0;
        for (ardito::RoverSample sample; bus.pop(sample, boundary.time_ns);) ++in_time;
        if (counts && boundary.time_ns >= begin_ns && in_time < kMeasurements)
          ++missed.measurements;
        RoverOrders made{{.issued_ns = boundary.time_ns,
                          .serial = 1,
                          .next_frame_ns = boundary.time_ns + kPeriod}};
        made.standing = !counts;
        for (ardito::WheelOrder& wheel : made.wheel) wheel.enabled = true;
        for (ardito::SteeringOrder& steering : made.steering) steering.enabled = true;
        return made;
      };
      engine.frame(orders, [](const TimingPoints&) noexcept {});
    });
  }
  if (!booted) throw std::runtime_error("the nodes were not configured within 20 s");
  missed.ours += seen.missed;
  return seen;
}

Seen with_raw(const std::string& interface, int cycles, Misses& missed) {
  Nodes nodes(interface);
  const TimeNs begin_ns = now_ns() + 500 * kMillisecond;
  Process raw(
      {program("bench-can-loop"), interface, std::to_string(begin_ns), std::to_string(kPeriod),
       std::to_string(kLead), std::to_string(kOffset), std::to_string(kWarmUpCycles + cycles),
       std::to_string(kBusPriority), std::to_string(measured_cpu())},
      "/dev/null");
  Seen seen;
  run_fifo("nodes", kHardwarePriority, kHardwareCpu, [&] { seen = nodes.watch(begin_ns, cycles); });
  if (const int code = raw.wait(); code != 0)
    throw NotHere(fmt::format("the raw program does not run here (exit code {})", code));
  missed.raw += seen.missed;
  return seen;
}

}  // namespace

Figures can_cycle(const Options& options) {
  const std::string interface = can_interface();
  prepare_real_time();
  const int cycles = options.count(100, 10);
  Misses missed;
  Rounds whole, sync, orders;
  for (int i = 0; i < kRounds; ++i) {
    const Seen before = with_raw(interface, cycles, missed);
    const Seen ours = with_ours(interface, cycles, missed);
    const Seen after = with_raw(interface, cycles, missed);
    whole.push_back({ours.cycle_us, before.cycle_us, after.cycle_us});
    sync.push_back({ours.sync_us, before.sync_us, after.sync_us});
    orders.push_back({ours.orders_us, before.orders_us, after.orders_us});
  }
  const int all = kRounds * cycles;
  Figures figures{
      noted(figure("vi", "cycle besides waiting, p50", "us", whole, median, 1.10),
            fmt::format("{}, {} cycles of 100 ms: SYNC, {} measurements, {} orders; reference: a "
                        "raw program",
                        interface, all, kMeasurements, kOrders.size())),
      figure("vi", "cycle besides waiting, p99", "us", whole, p99, kNone),
      figure("vi", "SYNC - (T_k - lead), p50", "us", sync, median, kNone),
      figure("vi", "last order - (T_k + offset), p50", "us", orders, median, kNone)};
  if (options.maxima) {
    figures.push_back(most("vi", "cycle besides waiting, max", "us", whole));
    figures.push_back(most("vi", "SYNC - (T_k - lead), max", "us", sync));
    figures.push_back(most("vi", "last order - (T_k + offset), max", "us", orders));
  }
  const std::string of = fmt::format("of {}; reference: of {} of the raw program", all, 2 * all);
  figures.push_back(to_be_none(
      figure_of("vi", "cycles without SYNC or an order", "1", missed.ours, missed.raw, kNone, of)));
  figures.push_back(
      to_be_none(figure_of("vi", "frames without all measurements", "1", missed.measurements, kNone,
                           kNone, fmt::format("of {}", all))));
  return figures;
}

}  // namespace lss::bench
