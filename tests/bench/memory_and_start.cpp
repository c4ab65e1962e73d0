// Row ix: memory of the daemon of each vehicle against the least daemon with DDS and shared memory,
// and what its real-time threads allocate and fault in after READY. Row x: exec to READY against
// the same program, and how long a bus is without orders when the daemon dies.

#include <fmt/format.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <fstream>
#include <thread>

#include "daemon/runtime/clock.h"
#include "tests/bench/clients.h"
#include "tests/bench/realtime.h"
#include "tests/support/udp_peer.h"

namespace lss::bench {
namespace {

// The least daemon.
class Minimal : public Service {
 public:
  Minimal(int domain, bool shared_memory) {
    start({program("bench-dds-minimal"), std::to_string(domain)}, {loopback(shared_memory)});
  }
};

constexpr double kResident_MB = 24, kWithoutOrders_ms = 200;  // at most

// lssd of a vehicle without hardware.
class Bare : public Service {
 public:
  Bare(const std::string& vehicle, int domain, bool shared_memory) {
    std::string text =
        edited(shipped_config(vehicle), "shared_memory", shared_memory ? "true" : "false");
    const std::string old = "udp://127.0.0.1:20000";
    if (const std::size_t at = text.find(old); at != std::string::npos)
      text.replace(at, old.size(), bus_.path());
    const std::filesystem::path config = folder_ / "config.toml";
    std::ofstream(config) << text;
    start({program("lssd"), "--config", config, "--run-dir", folder_, "--domain",
           std::to_string(domain)},
          {});
  }

 private:
  testing_support::UdpPeer bus_;  // nobody answers
};

// From kill -9 of Lunar Zebro's daemon to the first byte of the next one on the bus, which is
// started as soon as its parent knows.
Samples death_to_orders_ms(int domain, int count) {
  constexpr int kRunning = 50;  // pieces of orders, until it is killed
  const Terminal legs;
  Folder folder;
  std::string text = edited(shipped_config("zebro"), "shared_memory", "false");
  text = edited(text, "path", '"' + legs.name() + '"');
  const std::filesystem::path config = folder / "zebro.toml";
  std::ofstream(config) << text;
  std::optional<Process> daemon;
  const auto begin = [&] {
    daemon.emplace(std::vector<std::string>{program("lssd"), "--config", config, "--run-dir",
                                            folder, "--domain", std::to_string(domain)},
                   folder / "lssd.log");
  };
  const auto ordered = [&] {
    std::array<char, 4096> bytes;
    return ::read(legs.fd(), bytes.data(), bytes.size()) > 0;
  };
  begin();
  Samples times;
  for (int i = 0; i < count; ++i) {
    int pieces = 0;
    if (!eventually([&] { return ordered() && ++pieces == kRunning; }))
      throw std::runtime_error("the daemon orders nothing: " + read_file(folder / "lssd.log"));
    const TimeNs dead_ns = now_ns();
    daemon->signal(SIGKILL);
    daemon->wait();
    while (ordered()) {  // what it sent before
    }
    begin();
    while (!ordered() && now_ns() - dead_ns < 10 * kSecond)
      std::this_thread::sleep_for(std::chrono::microseconds(100));
    times.push_back(static_cast<double>(now_ns() - dead_ns) * 1e-6);
  }
  return times;
}

template <class Program>
Samples exec_to_ready_ms(int domain) {
  const Program started(domain, false);
  return {static_cast<double>(started.exec_to_ready_ns()) * 1e-6};
}

}  // namespace

Figures memory(const Options& options) {
  Figures figures;
  const RoudiLock lock(std::chrono::seconds(options.count(120, 1)));
  std::optional<Roudi> roudi;
  if (lock.is_locked()) roudi.emplace();
  const std::string how = lock.is_locked()
                              ? "with shared memory"
                              : "without shared memory: another RouDi runs on this machine";
  const auto resident = [&](auto started) {
    std::this_thread::sleep_for(std::chrono::milliseconds(options.count(1000, 100)));
    return Samples{rss_mb(started->pid())};
  };
  for (const std::string vehicle : kVehicles) {
    const Rounds rounds = turn_by_turn(
        [&] { return resident(std::make_unique<Bare>(vehicle, domain(6), lock.is_locked())); },
        [&] { return resident(std::make_unique<Minimal>(domain(7), lock.is_locked())); });
    figures.push_back(held_back(
        noted(at_most(figure("ix", "resident memory of " + vehicle, "MB", rounds, median, kNone),
                      kResident_MB),
              how),
        "program and runtimes are populated whole, so that no real-time thread is the first to "
        "touch a page; history of events; five more readers and writers"));
  }

  const Daemon daemon(domain(6), lock.is_locked());
  const lss_Status status =
      status_after(domain(6), static_cast<std::uint64_t>(options.count(1000, 60)));
  std::uint64_t fifo = 0, mallocs = 0, faults = 0;
  for (std::uint32_t i = 0; i < status.thread_count; ++i) {
    if (status.threads[i].policy == 0) continue;
    ++fifo;
    mallocs += status.threads[i].mallocs_since_start;
    faults += status.threads[i].page_faults_since_start;
  }
  if (fifo == 0) {
    figures.push_back(not_measured("ix", "real-time threads", "no FIFO thread is permitted here"));
    return figures;
  }
  const std::string note =
      fmt::format("{} FIFO threads, {} frames, {}", fifo, status.frame_index, how);
  for (const auto& [name, count] : {std::pair{"mallocs", mallocs}, {"page faults", faults}}) {
    Figure f{.row = "ix",
             .name = fmt::format("{} on FIFO threads after READY", name),
             .unit = "1",
             .value = static_cast<double>(count),
             .goal = 0,
             .absolute = true,
             .note = note};
    figures.push_back(f);
  }
  return figures;
}

Figures time_to_ready(const Options& options) {
  const Samples deaths = death_to_orders_ms(domain(5), options.count(20, 2));
  return {at_most(figure_of("x", "death of the daemon to orders on the bus again, max", "ms",
                            quantile(deaths, 1), kNone, kNone,
                            fmt::format("of {} deaths by kill -9, p50 {:.1f} ms; started again at "
                                        "once (systemd: after RestartSec)",
                                        deaths.size(), median(deaths))),
                  kWithoutOrders_ms),
          figure("x", "exec to READY", "ms",
                 turn_by_turn([] { return exec_to_ready_ms<Daemon>(domain(6)); },
                              [] { return exec_to_ready_ms<Minimal>(domain(7)); }),
                 median, kNone)};
}

}  // namespace lss::bench
