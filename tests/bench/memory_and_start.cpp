// Row ix: memory of the daemon against the least daemon with DDS and shared memory, and what its
// real-time threads allocate and fault in after READY. Row x: exec to READY against the same
// program.

#include <fmt/format.h>

#include <thread>

#include "daemon/runtime/clock.h"
#include "tests/bench/clients.h"

namespace lss::bench {
namespace {

// The least daemon.
class Minimal : public Service {
 public:
  Minimal(int domain, bool shared_memory) {
    start({program("bench-dds-minimal"), std::to_string(domain)}, {loopback(shared_memory)});
  }
};

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
  const Rounds rounds = turn_by_turn(
      [&] { return resident(std::make_unique<Daemon>(domain(6), lock.is_locked())); },
      [&] { return resident(std::make_unique<Minimal>(domain(7), lock.is_locked())); });
  figures.push_back(held_back(
      noted(figure("ix", "resident memory", "MB", rounds, median, 1.5), how),
      "program and runtimes are populated whole, so that no real-time thread is the first to "
      "touch a page; history of events; five more readers and writers"));

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

Figures time_to_ready(const Options&) {
  return {
      held_back(figure("x", "exec to READY", "ms",
                       turn_by_turn([] { return exec_to_ready_ms<Daemon>(domain(6)); },
                                    [] { return exec_to_ready_ms<Minimal>(domain(7)); }),
                       median, 1.5),
                "more libraries, configuration, twelve topics, memory to populate, a first frame")};
}

}  // namespace lss::bench
