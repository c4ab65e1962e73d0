// Row xiii: an emergency stop by DDS to its first byte on the bus, of each vehicle with its motors
// on, without other traffic and under 20,000 heartbeats and commands a second in the name of its
// pilot; against a minimal program with the same function on the same type of line, under the same
// load.

#include <fmt/format.h>

#include "tests/bench/stop_rig.h"

namespace lss::bench {
namespace {

#ifdef LSS_BENCH_ARDITO
// A wheel drive's controlword: quick stop. icd-ardito.md, section 5.
bool is_quick_stop(std::uint32_t id, std::span<const std::uint8_t> data) {
  return id >= 0x201 && id <= 0x206 && data.size() == 6 && data[0] == 0x02 && data[1] == 0;
}
#endif

#ifdef LSS_BENCH_TALARIS
constexpr std::uint16_t kValve = 303;
constexpr double kValves = 2, kOpen = 1, kTime_s = 20;  // valve 2, which pushes sideways

// The outputs of the valves: all shut. icd-talaris.md, section 5.
bool is_all_shut(std::uint32_t id, std::span<const std::uint8_t> data) {
  return id == 0x220 && data.size() == 2 && data[0] == 0;
}
#endif

std::vector<Stoppable> vehicles() {
  std::vector<Stoppable> all{lunar_zebro()};
#ifdef LSS_BENCH_ARDITO
  all.push_back({.name = "ardito",
                 .start = {},
                 .mode = "Stopped",
                 .then = 0,
                 .parameters = {},
                 .config = {{"path", "\"udp://127.0.0.1:20000\""}, {"beacon_s", "0.5"}},
                 .is_stop = is_quick_stop,
                 .frame_ns = 100 * kMillisecond,
                 .echoed = "02000000010000020106020000000000"});
#endif
#ifdef LSS_BENCH_TALARIS
  all.push_back({.name = "talaris",
                 .start = {},
                 .mode = "Manual",
                 .then = kValve,
                 .parameters = {kValves, kOpen, kTime_s},
                 .config = {},
                 .is_stop = is_all_shut,
                 .frame_ns = 200 * kMillisecond,
                 .echoed = "020000000100000220020000"});
#endif
  return all;
}

void measure(const Options& options, const Stoppable& vehicle, int index, Figures& figures) {
  const int daemon_domain = domain(2 * index), echo_domain = domain(2 * index + 1);
  StopDaemon daemon(vehicle, daemon_domain);
  StopEcho echo(vehicle, echo_domain);
  const int stops = options.count(8, 1), echoes = options.count(80, 10);
  StopDaemon::Late late[2];
  for (const bool loaded : {false, true}) {
    if (loaded && options.quick && index > 0) return;  // each begin of the load takes a second
    const auto under_load = [&](StopSubject& subject, int where, int count) {
      const std::string id = std::string(vehicle.name) + "-1";
      std::optional<Load> load;
      if (loaded) load.emplace(where, id);
      return subject.stops_us(count);
    };
    const Rounds rounds = turn_by_turn(
        [&] {
          daemon.late();
          Samples times = under_load(daemon, daemon_domain, stops);
          late[loaded] += daemon.late();
          return times;
        },
        [&] { return under_load(echo, echo_domain, echoes); }, options.count(kRounds, 1));
    const std::string what = fmt::format("estop of {} to its bus, {}, ", vehicle.name,
                                         loaded ? "20,000 messages/s" : "idle");
    figures.push_back(noted(
        figure("xiii", what + "p50", "us", rounds, median, kNone),
        fmt::format("{} stops, {} of the echo", 2 * rounds.size() * static_cast<std::size_t>(stops),
                    2 * rounds.size() * static_cast<std::size_t>(echoes))));
    figures.push_back(figure("xiii", what + "p99", "us", rounds, p99, 2));
    if (!vehicle.held_back.empty()) figures.back() = held_back(figures.back(), vehicle.held_back);
    figures.push_back(most("xiii", what + "max", "us", rounds));
  }
  const auto share = [](const StopDaemon::Late& of) {
    return of.frames == 0 ? kNone
                          : 100 * static_cast<double>(of.late) / static_cast<double>(of.frames);
  };
  figures.push_back(figure_of("xiii",
                              fmt::format("late frames of {}, 20,000 messages/s", vehicle.name),
                              "%", share(late[1]), share(late[0]), kNone,
                              fmt::format("{} of {}; reference: idle, {} of {}", late[1].late,
                                          late[1].frames, late[0].late, late[0].frames)));
}

}  // namespace

Figures emergency_stop(const Options& options) {
  prepare_real_time();
  Figures figures;
  int index = 0;
  for (const Stoppable& vehicle : vehicles()) {
    try {
      measure(options, vehicle, index++, figures);
    } catch (const NotHere&) {
      throw;
    } catch (const std::exception& why) {  // no reason to lose the others
      fmt::print(stderr, "row xiii failed: {}\n", why.what());
      figures.push_back(not_measured("xiii", std::string(vehicle.name), why.what()));
      figures.back().failed = true;
    }
  }
  return figures;
}

}  // namespace lss::bench
