#include "tests/bench/growth.h"

#include <fmt/format.h>

#include <array>
#include <deque>
#include <filesystem>
#include <memory>
#include <sstream>
#include <thread>

#include "daemon/runtime/clock.h"
#include "drivers/canopen/master.h"
#include "idl/topics.h"
#include "tests/bench/fleet.h"
#include "tests/bench/frame_mathematics.h"
#include "tests/bench/lockstep.h"
#include "tests/bench/programs.h"
#include "tests/bench/realtime.h"
#include "zebro.h"

namespace lss::bench {
namespace {

using Counts = std::vector<int>;

// Each count once a round.
std::vector<Point> in_turn(const Counts& counts, const Options& options,
                           const std::function<double(int)>& cost) {
  std::vector<Point> points;
  for (const int count : counts) points.push_back({.count = static_cast<double>(count)});
  for (int i = 0; i < options.count(kRounds, 1); ++i) {
    for (Point& point : points) point.cost.push_back(cost(static_cast<int>(point.count)));
  }
  return points;
}

// A master and so many nodes that do what they are ordered, without a bus between them.
class Nodes {
 public:
  explicit Nodes(int count) : count_(count), master_(parameters(count)) {
    master_.restart(now_, now_);
    for (int i = 0; i < 1000 && operational() < count_; ++i) {
      now_ += kMillisecond;
      while (!to_master_.empty()) {
        const CanFrame frame = to_master_.front();
        to_master_.pop_front();
        receive(frame);
      }
      transmit();
    }
    if (operational() < count_) throw std::runtime_error("the nodes of the bench do not boot");
    answers_ = false;
  }

  // SYNC, two PDOs of measurements and a heartbeat of each node, an order to each: what the bus
  // thread has its driver do.
  void cycle() {
    now_ += kPeriod;
    transmit();
    for (int node = 1; node <= count_; ++node) {
      receive(frame(0x180 + node, 8));
      receive(frame(0x280 + node, 8));
      receive(frame(0x700 + node, 1, 5));
    }
    canopen::PdoSample sample;
    while (master_.take(sample)) ++taken_;
    constexpr std::array<std::uint8_t, 6> kOrder{};
    for (int node = 0; node < count_; ++node)
      master_.send_rpdo(static_cast<std::size_t>(node), 1, kOrder);
    transmit();
  }
  std::uint64_t taken() const { return taken_; }
  std::uint64_t orders() const { return orders_; }

 private:
  static constexpr TimeNs kPeriod = 100 * kMillisecond;
  static constexpr std::uint32_t kType = 0x00020192;

  static canopen::MasterParameters parameters(int count) {
    canopen::MasterParameters p;
    for (int i = 0; i < count; ++i) {
      canopen::NodeParameters& node = p.nodes[static_cast<std::size_t>(i)];
      node.node = static_cast<std::uint8_t>(i + 1);
      node.device_type = kType;
      node.rpdo[0] = {.number = 1, .objects = {0x60400010, 0x60FF0020}};
      for (const std::uint8_t number : std::array<std::uint8_t, 2>{1, 2})
        node.tpdo[number - 1u] = {.number = number, .objects = {0x60410020, 0x606C0020}};
    }
    return p;
  }
  CanFrame frame(int id, std::uint8_t size, std::uint8_t first = 0) const {
    CanFrame made{.time_ns = now_, .id = static_cast<std::uint32_t>(id), .size = size};
    made.data[0] = first;
    return made;
  }
  void receive(CanFrame in) {
    in.time_ns = now_;
    master_.receive(in);
    transmit();
  }
  void transmit() {
    for (CanFrame out; master_.transmit(now_, out);) {
      orders_ += out.id > 0x200 && out.id < 0x280;
      if (answers_) answer(out);
    }
    const TimeNs wake = master_.next_wake();
    keep(&wake);
  }
  // As nodes while they boot (CiA 301).
  void answer(const CanFrame& out) {
    if (out.id == 0) {
      const bool start = out.data[0] == static_cast<std::uint8_t>(canopen::Nmt::start);
      to_master_.push_back(frame(0x700 + out.data[1], 1, start ? 5 : 0));
    } else if (out.id > 0x600 && out.id < 0x680) {
      const bool read = out.data[0] >> 5 == 2;
      CanFrame reply = out;
      reply.id = out.id - 0x80;
      reply.data[0] = read ? 0x43 : 0x60;
      for (unsigned byte = 0; byte < 4; ++byte)
        reply.data[4 + byte] = read ? static_cast<std::uint8_t>(kType >> 8 * byte) : 0;
      to_master_.push_back(reply);
    }
  }
  int operational() const {
    int n = 0;
    for (std::size_t i = 0; i < master_.nodes(); ++i)
      n += master_.status(i).state == canopen::NodeState::operational;
    return n;
  }

  int count_;
  TimeNs now_ = kSecond;
  canopen::Master master_;
  std::deque<CanFrame> to_master_;
  bool answers_ = true;
  std::uint64_t taken_ = 0, orders_ = 0;
};

Growth modules(const Options& options) {
  const int cycles = options.count(20'000, 500);
  return {.name = "modules",
          .what = "nodes on a CANopen bus",
          .cost = "CPU of the master in a cycle",
          .unit = "us",
          .points = in_turn({1, 2, 4, 8, 16}, options,
                            [&](int count) {
                              Nodes nodes(count);
                              const std::uint64_t sent = nodes.orders();
                              const double begin_s = thread_cpu_s();
                              for (int i = 0; i < cycles; ++i) nodes.cycle();
                              const double spent_s = thread_cpu_s() - begin_s;
                              const auto all = static_cast<std::uint64_t>(cycles * count);
                              if (nodes.taken() != 2 * all || nodes.orders() != sent + all)
                                throw std::runtime_error("the master lost a frame");
                              return spent_s / cycles * 1e6;
                            }),
          .note = "SYNC, three frames from each node, an order to each; without the system calls"};
}

// CPU time of all threads of a process so far, s.
double cpu_s(pid_t pid) {
  double ns = 0;
  std::error_code ended;
  for (const auto& task :
       std::filesystem::directory_iterator(fmt::format("/proc/{}/task", pid), ended)) {
    std::istringstream words(read_file(task.path() / "schedstat"));
    double of_this = 0;
    words >> of_this;
    ns += of_this;
  }
  if (ended || ns <= 0)
    throw std::runtime_error("the CPU time of lssd cannot be read: has it ended?");
  return ns * 1e-9;
}

// Of a process while time passes, ms for each second.
double cpu_ms_s(pid_t pid, double seconds) {
  const TimeNs begin_ns = now_ns();
  const double before_s = cpu_s(pid);
  std::this_thread::sleep_for(std::chrono::duration<double>(seconds));
  const double spent_s = cpu_s(pid) - before_s;
  if (spent_s < 0) throw std::runtime_error("a thread of lssd ended while it was measured");
  return spent_s * 1e12 / static_cast<double>(now_ns() - begin_ns);
}

// Each reads all telemetry, as a participant of its own.
class Subscribers {
 public:
  Subscribers(int domain, int count) {
    const dds::Topic topic = dds::telemetry_topic("zebro", &lss_ZebroTelemetry_desc);
    for (int i = 0; i < count; ++i) {
      participants_.push_back(value(dds::Participant::create({.domain = domain})));
      readers_.push_back(value(dds::create_reader(participants_.back().get(), topic)));
    }
    const auto all_hear = [&] {
      lss_ZebroTelemetry sample;
      void* pointer = &sample;
      dds_sample_info_t info;
      return std::ranges::all_of(readers_, [&](const dds::Entity& reader) {
        return dds_take(reader.get(), &pointer, &info, 1, 1) > 0;
      });
    };
    if (!eventually(all_hear, std::chrono::seconds(60)))
      throw std::runtime_error(fmt::format("not all of {} subscribers hear telemetry", count));
  }

 private:
  std::vector<dds::Participant> participants_;
  std::vector<dds::Entity> readers_;
};

Growth subscribers(const Options& options) {
  const int id = domain(0);
  const Daemon daemon(id, false);
  return {.name = "subscribers",
          .what = "subscribers of telemetry, each a participant",
          .cost = "CPU of lssd in a second of 50 frames",
          .unit = "ms",
          .points = in_turn(options.quick ? Counts{1, 4} : Counts{1, 2, 4, 8, 16, 32, 64}, options,
                            [&](int count) {
                              const Subscribers crowd(id, count);
                              return cpu_ms_s(daemon.pid(), options.quick ? 0.2 : 3);
                            }),
          .note = "all threads of the daemon; by the network, without shared memory"};
}

std::array<Growth, 2> vehicles(const Options& options) {
  std::array<Growth, 2> both{
      {{.name = "vehicles",
        .what = "vehicles on the domain",
        .cost = "a new client has the status of all after",
        .unit = "s",
        .note = "each vehicle a daemon of its own; all on this machine; counts not in turn"},
       {.name = "idle",
        .what = "vehicles on the domain",
        .cost = "CPU of one daemon in a second, nothing moves",
        .unit = "ms",
        .note = "the first that was started, with a client that reads the status of all; counts "
                "not in turn"}}};
  std::vector<std::unique_ptr<Daemon>> fleet;
  for (const int count : options.quick ? Counts{1, 3} : Counts{1, 2, 4, 8, 16, 32, 64}) {
    while (fleet.size() < static_cast<std::size_t>(count))
      fleet.push_back(std::make_unique<Daemon>(domain(1), false, std::filesystem::path(),
                                               fmt::format("zebro-{}", fleet.size() + 1)));
    StatusReader(domain(1)).wait_until_all_know_each_other(fleet.size());
    Point found{.count = static_cast<double>(count)}, idle = found;
    for (int i = 0; i < options.count(kRounds, 1); ++i) {
      StatusReader client(domain(1));
      found.cost.push_back(client.all_heard_s(fleet.size()));
      idle.cost.push_back(cpu_ms_s(fleet.front()->pid(), options.quick ? 0.2 : 2));
    }
    both[0].points.push_back(std::move(found));
    both[1].points.push_back(std::move(idle));
  }
  return both;
}

std::vector<Growth> recordings(const Options& options) {
  std::vector<Growth> all;
  const auto add = [&](const char* name, const char* cost, const char* unit, const char* note) {
    all.push_back(
        {.name = name, .what = "minutes of recording", .cost = cost, .unit = unit, .note = note});
  };
  add("replay", "lssd --replay takes", "s", "all 50 frames of a second executed and compared");
  add("replay-memory", "memory of lssd --replay, largest", "MB", "resident");
  add("export", "lss-cli log export of two columns takes", "s", "");
  add("export-memory", "memory of lss-cli log export, largest", "MB", "resident");
  Folder folder;
  for (const int minutes : options.quick ? Counts{1} : Counts{1, 2, 4, 8, 16}) {
    const std::filesystem::path file = folder / fmt::format("{}.lssrec", minutes);
    lockstep_ms(kWalk, "kinematic", minutes * 60, file);
    for (Growth& growth : all) growth.points.push_back({.count = static_cast<double>(minutes)});
    const auto run = [&](std::size_t first, const std::vector<std::string>& words) {
      Process reader(words, folder / "reader.log");
      if (const int code = reader.wait(std::chrono::minutes(5)); code != 0)
        throw std::runtime_error(fmt::format("{} of {} minutes ended with {}: {}", words[0],
                                             minutes, code, read_file(folder / "reader.log")));
      all[first].points.back().cost.push_back(static_cast<double>(now_ns() - reader.started_ns()) *
                                              1e-9);
      all[first + 1].points.back().cost.push_back(reader.peak_mb());
    };
    for (int i = 0; i < options.count(3, 1); ++i) {
      run(0, {program("lssd"), "--replay", file});
      run(2, {program("lss-cli"), "log", "export", file, "--columns", "distance_m,timing.margin_ns",
              "--out", folder / "out.csv"});
    }
  }
  return all;
}

}  // namespace

std::vector<Growth> growth(const Options& options, bool& failed) {
  std::vector<Growth> all;
  // One that fails is no reason to lose the others.
  const auto add = [&](const char* name, const char* what, const auto& measured) {
    try {
      for (Growth& one : measured()) all.push_back(std::move(one));
    } catch (const std::exception& why) {
      failed = failed || dynamic_cast<const NotHere*>(&why) == nullptr;
      all.push_back({.name = name,
                     .what = what,
                     .cost = std::string("cost by ") + what,
                     .unit = "-",
                     .note = std::string("not measured: ") + why.what()});
    }
  };
#ifdef LSS_BENCH_TALARIS
  add("samples", "IMU samples in a frame", [&] {
    return std::array{Growth{
        .name = "samples",
        .what = "IMU samples in a frame",
        .cost = "TALARIS' navigation, a frame",
        .unit = "us",
        .points = in_turn({10, 20, 40, 80, 160}, options,
                          [&](int n) { return talaris_frame_us(n, options.count(500, 20)); }),
        .note = "and two ranges of the altimeter"}};
  });
#endif
  add("modules", "nodes on a CANopen bus", [&] { return std::array{modules(options)}; });
  add("subscribers", "subscribers", [&] { return std::array{subscribers(options)}; });
  add("vehicles", "vehicles on the domain", [&] { return vehicles(options); });
  add("recordings", "minutes of recording", [&] { return recordings(options); });
  return all;
}

}  // namespace lss::bench
